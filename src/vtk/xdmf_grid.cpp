#include "vtk/xdmf_grid.h"

#include <vtkCellData.h>
#include <vtkPointData.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>

#include "vtk/cell_lookup.h"
#include "vtk/number_types.h"
#include "vtk/xdmf_function.h"

namespace tetfusion {
namespace {

bool have_equal_bytes(vtkDataArray* a, vtkDataArray* b) {
  if (a == b) return true;
  if (a->GetDataType() != b->GetDataType() || a->GetNumberOfValues() != b->GetNumberOfValues()) {
    return false;
  }
  const auto bytes = static_cast<std::size_t>(a->GetNumberOfValues()) *
                     static_cast<std::size_t>(a->GetDataTypeSize());
  return bytes == 0 || std::memcmp(a->GetVoidPointer(0), b->GetVoidPointer(0), bytes) == 0;
}

bool are_equal(const XdmfCells& a, const XdmfBlock& b) {
  vtkCellArray* const cells = b.grid->GetCells();
  if (a.cells == cells) return true;
  return have_equal_bytes(a.types, b.types) &&
         have_equal_bytes(a.cells->GetOffsetsArray(), cells->GetOffsetsArray()) &&
         have_equal_bytes(a.cells->GetConnectivityArray(), cells->GetConnectivityArray());
}

// Columns side by side; `missing` of them are zeros.
vtkSmartPointer<vtkDataArray> interleaved(const std::vector<vtkSmartPointer<vtkDataArray>>& columns,
                                          int missing) {
  const vtkIdType rows = columns.front()->GetNumberOfTuples();
  const auto width = columns.size() + static_cast<std::size_t>(missing);
  auto out = new_numbers(columns.front()->GetDataType(), static_cast<std::uint64_t>(rows) * width);
  with_number_type(out->GetDataType(), [&](auto zero) {
    auto* to = numbers_of<decltype(zero)>(out);
    for (vtkIdType row = 0; row < rows; ++row) {
      for (const auto& column : columns) *to++ = numbers_of<decltype(zero)>(column)[row];
      for (int k = 0; k < missing; ++k) *to++ = zero;
    }
  });
  return out;
}

// Rows of two with a zero behind each.
vtkSmartPointer<vtkDataArray> lifted(vtkDataArray* flat) {
  const vtkIdType rows = flat->GetNumberOfTuples() / 2;
  auto out = new_numbers(flat->GetDataType(), static_cast<std::uint64_t>(rows) * 3);
  with_number_type(out->GetDataType(), [&](auto zero) {
    const auto* from = numbers_of<decltype(zero)>(flat);
    auto* to = numbers_of<decltype(zero)>(out);
    for (vtkIdType row = 0; row < rows; ++row) {
      *to++ = *from++;
      *to++ = *from++;
      *to++ = zero;
    }
  });
  return out;
}

// Makes it so many rows.
void make_rows(const XdmfDocument& document, pugi::xml_node attribute, vtkDataArray* array,
               vtkIdType rows, const char* of_what) {
  const vtkIdType values = array->GetNumberOfTuples();
  if (rows == 0 && values == 0) return;
  if (rows == 0 || values == 0 || values % rows != 0) {
    document.fail(attribute, "has " + std::to_string(values) + " values for " +
                                 std::to_string(rows) + of_what);
  }
  array->SetNumberOfComponents(static_cast<int>(values / rows));
}

// Its rows as some of so many; the others are no numbers, or 0.
vtkSmartPointer<vtkDataArray> spread(vtkDataArray* array, const std::vector<vtkIdType>& row_of,
                                     vtkIdType rows) {
  const auto width = static_cast<std::size_t>(array->GetNumberOfComponents());
  auto out = new_numbers(array->GetDataType(), static_cast<std::uint64_t>(rows) * width);
  out->SetName(array->GetName());
  with_number_type(array->GetDataType(), [&](auto zero) {
    using Value = decltype(zero);
    const auto* from = numbers_of<Value>(array);
    auto* const to = numbers_of<Value>(out);
    std::fill_n(to, static_cast<std::size_t>(rows) * width,
                std::numeric_limits<Value>::quiet_NaN());
    for (const vtkIdType row : row_of) {
      std::copy_n(from, width, to + static_cast<std::size_t>(row) * width);
      from += width;
    }
  });
  out->SetNumberOfComponents(static_cast<int>(width));
  return out;
}

std::string name_of_attribute(pugi::xml_node attribute) {
  return xdmf_attribute(attribute, {"Name"}, "unnamed");
}

}  // namespace

void XdmfGrids::add(pugi::xml_node grid, const std::string& name) {
  grids_.push_back({grid, name, points_of(grid), &cells_of(grid)});
}

// From the one with most cells on, so that those with some of its cells find it.
std::vector<XdmfBlock> XdmfGrids::blocks() {
  std::vector<std::size_t> order(grids_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return grids_[a].cells->cells->GetNumberOfCells() > grids_[b].cells->cells->GetNumberOfCells();
  });
  std::vector<XdmfBlock> blocks;
  for (const std::size_t grid : order) place(grid, &blocks);
  std::sort(blocks.begin(), blocks.end(),
            [](const XdmfBlock& a, const XdmfBlock& b) { return a.place < b.place; });
  return blocks;
}

void XdmfGrids::place(std::size_t index, std::vector<XdmfBlock>* blocks) {
  const Grid& grid = grids_[index];
  const XdmfCells& cells = *grid.cells;
  for (const XdmfBlock& block : *blocks) {
    if (grid.points != block.grid->GetPoints()) continue;
    Target target{block.grid, cells.cells->GetNumberOfCells(), {}};
    if (!are_equal(cells, block)) {
      target.cell_of = find_cells(block.grid->GetCells(), block.types, cells.cells, cells.types);
      if (target.cell_of.empty()) continue;
    }
    return add_arrays(grid.node, target);
  }
  const auto out = vtkSmartPointer<vtkUnstructuredGrid>::New();
  out->SetPoints(grid.points);
  out->SetCells(cells.types, cells.cells);
  blocks->push_back({index, grid.name, out, cells.types});
  add_arrays(grid.node, {out, out->GetNumberOfCells(), {}});
}

void XdmfGrids::add_own_arrays(pugi::xml_node collection) { add_arrays(collection, {}); }

// Of the items in it, with what else tells two elements apart.
std::string XdmfGrids::key_of(pugi::xml_node node) const {
  std::string key;
  for (const pugi::xml_attribute attribute : node.attributes()) {
    if (!is_xdmf_word(attribute.name(), "Name")) key += std::string(attribute.value()) + " ";
  }
  for (const pugi::xml_node item : document_.children(node, "DataItem")) {
    key += items_->key(item) + "\n";
  }
  return key;
}

vtkSmartPointer<vtkPoints> XdmfGrids::points_of(pugi::xml_node grid) {
  const pugi::xml_node geometry = document_.child(grid, "Geometry");
  if (!geometry) document_.fail(grid, "has no Geometry");
  vtkSmartPointer<vtkPoints>& points = points_[key_of(geometry)];
  if (points != nullptr) return points;
  const vtkSmartPointer<vtkDataArray> rows = coordinates_of(geometry);
  for (const auto& [key, known] : points_) {
    if (known != nullptr && have_equal_bytes(known->GetData(), rows)) return points = known;
  }
  points = vtkSmartPointer<vtkPoints>::New();
  points->SetData(rows);
  return points;
}

// Rows of three.
vtkSmartPointer<vtkDataArray> XdmfGrids::coordinates_of(pugi::xml_node geometry) {
  const std::string type = xdmf_attribute(geometry, {"GeometryType", "Type"}, "XYZ");
  const bool is_split = is_xdmf_word(type, "X_Y_Z") || is_xdmf_word(type, "X_Y");
  const bool is_flat = is_xdmf_word(type, "XY") || is_xdmf_word(type, "X_Y");
  if (!is_split && !is_flat && !is_xdmf_word(type, "XYZ")) {
    document_.fail(geometry, "is of type " + type +
                                 ", which is not read: XYZ, XY, X_Y_Z and X_Y are; let ParaView "
                                 "save a structured grid as .vts or .vti");
  }
  const std::vector<pugi::xml_node> items = document_.children(geometry, "DataItem");
  const std::size_t wanted = !is_split ? 1 : is_flat ? 2 : 3;
  if (items.size() != wanted) {
    document_.fail(geometry, "is of type " + type + " and has " + std::to_string(items.size()) +
                                 " DataItems, expected " + std::to_string(wanted));
  }
  std::vector<vtkSmartPointer<vtkDataArray>> arrays;
  for (const pugi::xml_node item : items) {
    arrays.push_back(items_->read(item));
    if (arrays.back()->GetDataType() != arrays[0]->GetDataType() ||
        arrays.back()->GetNumberOfTuples() != arrays[0]->GetNumberOfTuples()) {
      document_.fail(geometry, "has coordinates of different types or numbers");
    }
  }
  const vtkIdType width = is_split ? 1 : is_flat ? 2 : 3;
  if (arrays[0]->GetNumberOfTuples() % width != 0) {
    document_.fail(geometry, "has " + std::to_string(arrays[0]->GetNumberOfTuples()) +
                                 " coordinates, which are no rows of " + std::to_string(width));
  }
  vtkSmartPointer<vtkDataArray> array = arrays[0];
  if (is_split) array = interleaved(arrays, is_flat ? 1 : 0);
  if (is_flat && !is_split) array = lifted(array);
  array->SetNumberOfComponents(3);
  return array;
}

const XdmfCells& XdmfGrids::cells_of(pugi::xml_node grid) {
  const pugi::xml_node topology = document_.child(grid, "Topology");
  if (!topology) document_.fail(grid, "has no Topology");
  XdmfCells& cells = cells_[key_of(topology)];
  if (cells.cells == nullptr) cells = read_xdmf_cells(document_, topology, items_);
  return cells;
}

void XdmfGrids::add_arrays(pugi::xml_node grid, const Target& target) {
  for (const pugi::xml_node attribute : document_.children(grid, "Attribute")) {
    add_array(attribute, target);
  }
  for (const pugi::xml_node set : document_.children(grid, "Set")) {
    leave_out("set '" + name_of_attribute(set) + "'");
  }
}

void XdmfGrids::add_array(pugi::xml_node attribute, const Target& target) {
  vtkUnstructuredGrid* const grid = target.grid;
  const std::string name = name_of_attribute(attribute);
  const std::string center = xdmf_attribute(attribute, {"Center"}, "Node");
  const bool of_all = is_xdmf_word(center, "Grid");
  const bool of_points = is_xdmf_word(center, "Node") && grid != nullptr;
  const bool of_cells = is_xdmf_word(center, "Cell") && grid != nullptr;
  if (is_xdmf_word(xdmf_attribute(attribute, {"ItemType"}), "FiniteElementFunction")) {
    if (grid != nullptr && target.cell_of.empty()) return add_function(attribute, name, grid);
    return leave_out("function '" + name + "' of some cells");
  }
  if (!of_all && !of_points && !of_cells) return leave_out("array '" + name + "' (" + center + ")");
  const pugi::xml_node item = document_.child(attribute, "DataItem");
  if (!item) document_.fail(attribute, "has no DataItem");
  std::string why;
  const vtkSmartPointer<vtkDataArray> array = items_->read_if_known(item, &why);
  if (array == nullptr) return leave_out("array '" + name + "', whose DataItem " + why);
  array->SetName(name.c_str());
  if (of_points) return add_point_rows(attribute, grid, array);
  if (of_cells) return add_cell_rows(attribute, target, array);
  keep(grid != nullptr ? grid->GetFieldData() : field_data_.Get(), array, "field");
}

void XdmfGrids::add_function(pugi::xml_node attribute, const std::string& name,
                             vtkUnstructuredGrid* grid) {
  const XdmfFunction function = read_xdmf_function(document_, attribute, grid, items_);
  if (function.values == nullptr)
    return leave_out("function '" + name + "' (" + function.what + ")");
  function.values->SetName(name.c_str());
  if (function.of_points) return add_point_rows(attribute, grid, function.values);
  add_cell_rows(attribute, {grid, grid->GetNumberOfCells(), {}}, function.values);
}

void XdmfGrids::add_point_rows(pugi::xml_node attribute, vtkUnstructuredGrid* grid,
                               vtkDataArray* array) {
  make_rows(document_, attribute, array, grid->GetNumberOfPoints(), " points");
  keep_rows(attribute, grid->GetPointData(), array);
}

void XdmfGrids::add_cell_rows(pugi::xml_node attribute, const Target& target,
                              vtkSmartPointer<vtkDataArray> array) {
  make_rows(document_, attribute, array, target.cells, " cells");
  if (!target.cell_of.empty()) {
    array = spread(array, target.cell_of, target.grid->GetNumberOfCells());
  }
  keep_rows(attribute, target.grid->GetCellData(), array);
}

void XdmfGrids::keep_rows(pugi::xml_node attribute, vtkDataSetAttributes* data,
                          vtkDataArray* array) {
  keep(data, array, vtkPointData::SafeDownCast(data) != nullptr ? "point" : "cell");
  const std::string type = xdmf_attribute(attribute, {"AttributeType", "Type"});
  if (is_xdmf_word(type, "GlobalID") && data->GetGlobalIds() == nullptr) {
    data->SetActiveAttribute(array->GetName(), vtkDataSetAttributes::GLOBALIDS);
  }
}

// Unless there is another one of that name.
void XdmfGrids::keep(vtkFieldData* data, vtkDataArray* array, const std::string& what) {
  vtkDataArray* const known = data->GetArray(array->GetName());
  if (known == nullptr) {
    data->AddArray(array);
  } else if (!have_equal_bytes(known, array)) {
    leave_out("another " + what + " array '" + array->GetName() + "' of the same grid");
  }
}

void XdmfGrids::leave_out(const std::string& what) {
  if (told_.insert(what).second) left_out_.push_back(what);
}

}  // namespace tetfusion
