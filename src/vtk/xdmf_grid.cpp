#include "vtk/xdmf_grid.h"

#include <vtkCellData.h>
#include <vtkPointData.h>

#include <algorithm>
#include <cstddef>
#include <cstring>

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

bool are_equal(const XdmfCells& a, vtkUnstructuredGrid* b) {
  vtkCellArray* const cells = b->GetCells();
  if (a.cells == cells) return true;
  if (a.cells->GetNumberOfCells() != cells->GetNumberOfCells()) return false;
  for (vtkIdType c = 0; c < cells->GetNumberOfCells(); ++c) {
    if (a.types->GetValue(c) != b->GetCellType(c)) return false;
  }
  return have_equal_bytes(a.cells->GetOffsetsArray(), cells->GetOffsetsArray()) &&
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

std::string name_of_attribute(pugi::xml_node attribute) {
  return xdmf_attribute(attribute, {"Name"}, "unnamed");
}

}  // namespace

void XdmfGrids::add(pugi::xml_node grid, const std::string& name) {
  const vtkSmartPointer<vtkPoints> points = points_of(grid);
  const XdmfCells& cells = cells_of(grid);
  for (const XdmfBlock& block : blocks_) {
    vtkPoints* const known = block.grid->GetPoints();
    if (!are_equal(cells, block.grid) || !have_equal_bytes(points->GetData(), known->GetData())) {
      continue;
    }
    return add_arrays(grid, block.grid);
  }
  const auto out = vtkSmartPointer<vtkUnstructuredGrid>::New();
  out->SetPoints(points);
  out->SetCells(cells.types, cells.cells);
  blocks_.push_back({name, out});
  add_arrays(grid, out);
}

void XdmfGrids::add_own_arrays(pugi::xml_node collection) { add_arrays(collection, nullptr); }

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
  const std::string type = xdmf_attribute(geometry, {"GeometryType", "Type"}, "XYZ");
  std::vector<vtkSmartPointer<vtkDataArray>> arrays;
  for (const pugi::xml_node item : document_.children(geometry, "DataItem")) {
    arrays.push_back(items_->read(item));
  }
  const bool is_split = is_xdmf_word(type, "X_Y_Z") || is_xdmf_word(type, "X_Y");
  const bool is_flat = is_xdmf_word(type, "XY") || is_xdmf_word(type, "X_Y");
  if (!is_split && !is_flat && !is_xdmf_word(type, "XYZ")) {
    document_.fail(geometry, "is of type " + type +
                                 ", which is not read: XYZ, XY, X_Y_Z and X_Y are; let ParaView "
                                 "save a structured grid as .vts or .vti");
  }
  const std::size_t wanted = !is_split ? 1 : is_flat ? 2 : 3;
  if (arrays.size() != wanted) {
    document_.fail(geometry, "is of type " + type + " and has " + std::to_string(arrays.size()) +
                                 " DataItems, expected " + std::to_string(wanted));
  }
  for (const auto& array : arrays) {
    if (array->GetDataType() == arrays[0]->GetDataType() &&
        array->GetNumberOfTuples() == arrays[0]->GetNumberOfTuples()) {
      continue;
    }
    document_.fail(geometry, "has coordinates of different types or numbers");
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
  for (const auto& [key, known] : points_) {
    if (known != nullptr && have_equal_bytes(known->GetData(), array)) return points = known;
  }
  points = vtkSmartPointer<vtkPoints>::New();
  points->SetData(array);
  return points;
}

const XdmfCells& XdmfGrids::cells_of(pugi::xml_node grid) {
  const pugi::xml_node topology = document_.child(grid, "Topology");
  if (!topology) document_.fail(grid, "has no Topology");
  XdmfCells& cells = cells_[key_of(topology)];
  if (cells.cells == nullptr) cells = read_xdmf_cells(document_, topology, items_);
  return cells;
}

void XdmfGrids::add_arrays(pugi::xml_node grid, vtkUnstructuredGrid* out) {
  for (const pugi::xml_node attribute : document_.children(grid, "Attribute")) {
    add_array(attribute, out);
  }
  for (const pugi::xml_node set : document_.children(grid, "Set")) {
    leave_out("set '" + name_of_attribute(set) + "'");
  }
}

void XdmfGrids::add_array(pugi::xml_node attribute, vtkUnstructuredGrid* out) {
  const std::string name = name_of_attribute(attribute);
  const std::string center = xdmf_attribute(attribute, {"Center"}, "Node");
  const bool is_function =
      is_xdmf_word(xdmf_attribute(attribute, {"ItemType"}), "FiniteElementFunction");
  if (is_function && out != nullptr) return add_function(attribute, name, out);
  const bool of_points = is_xdmf_word(center, "Node");
  const bool of_cells = is_xdmf_word(center, "Cell");
  const bool of_all = is_xdmf_word(center, "Grid");
  if (!of_all && (out == nullptr || (!of_points && !of_cells))) {
    leave_out("array '" + name + "' (" + center + ")");
    return;
  }
  const pugi::xml_node item = document_.child(attribute, "DataItem");
  if (!item) document_.fail(attribute, "has no DataItem");
  const vtkSmartPointer<vtkDataArray> array = items_->read(item);
  array->SetName(name.c_str());
  if (of_points) add_rows(attribute, out->GetPointData(), out->GetNumberOfPoints(), array);
  if (of_cells) add_rows(attribute, out->GetCellData(), out->GetNumberOfCells(), array);
  if (of_all) keep(out != nullptr ? out->GetFieldData() : field_data_.Get(), array, "field");
}

void XdmfGrids::add_function(pugi::xml_node attribute, const std::string& name,
                             vtkUnstructuredGrid* out) {
  const XdmfFunction function = read_xdmf_function(document_, attribute, out, items_);
  if (function.values == nullptr) {
    leave_out("function '" + name + "' (" + function.what + ")");
    return;
  }
  function.values->SetName(name.c_str());
  if (function.of_points) {
    add_rows(attribute, out->GetPointData(), out->GetNumberOfPoints(), function.values);
  } else {
    add_rows(attribute, out->GetCellData(), out->GetNumberOfCells(), function.values);
  }
}

void XdmfGrids::add_rows(pugi::xml_node attribute, vtkDataSetAttributes* data, vtkIdType rows,
                         vtkDataArray* array) {
  const vtkIdType values = array->GetNumberOfTuples();
  if (rows == 0 && values == 0) return;
  const bool is_of_points = vtkPointData::SafeDownCast(data) != nullptr;
  if (rows == 0 || values == 0 || values % rows != 0) {
    document_.fail(attribute, "has " + std::to_string(values) + " values for " +
                                  std::to_string(rows) + (is_of_points ? " points" : " cells"));
  }
  array->SetNumberOfComponents(static_cast<int>(values / rows));
  keep(data, array, is_of_points ? "point" : "cell");
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
