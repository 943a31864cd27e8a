#include "vtk/filter/grid_view.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <optional>
#include <set>
#include <span>

#include "vtk/versions/vtk_versions.h"

namespace {

template <class T>
constexpr tetfusion::Type kTypeOf = tetfusion::type_of<T>();

std::optional<tetfusion::Type> type_of(int vtk_type) {
  switch (vtk_type) {
    case VTK_CHAR:
    case VTK_SIGNED_CHAR:
      return tetfusion::Type::kInt8;
    case VTK_UNSIGNED_CHAR:
      return tetfusion::Type::kUInt8;
    case VTK_SHORT:
      return kTypeOf<short>;
    case VTK_UNSIGNED_SHORT:
      return kTypeOf<unsigned short>;
    case VTK_INT:
      return kTypeOf<int>;
    case VTK_UNSIGNED_INT:
      return kTypeOf<unsigned int>;
    case VTK_LONG:
      return kTypeOf<long>;
    case VTK_UNSIGNED_LONG:
      return kTypeOf<unsigned long>;
    case VTK_LONG_LONG:
      return kTypeOf<long long>;
    case VTK_UNSIGNED_LONG_LONG:
      return kTypeOf<unsigned long long>;
    case VTK_ID_TYPE:
      return kTypeOf<vtkIdType>;
    case VTK_FLOAT:
      return tetfusion::Type::kFloat32;
    case VTK_DOUBLE:
      return tetfusion::Type::kFloat64;
    default:
      return std::nullopt;
  }
}

// Names are the library's key to arrays: all have one, and no two have the same. Of several with
// one name the first has it; no other name is one that some array has.
class FreeNames {
 public:
  explicit FreeNames(vtkDataSetAttributes* attributes) {
    for (int i = 0; i < attributes->GetNumberOfArrays(); ++i) {
      if (const char* name = attributes->GetArrayName(i)) given_.insert(name);
    }
  }
  std::string name(const char* name, int index) {
    std::string own = name != nullptr ? name : "";
    if (!own.empty() && taken_.insert(own).second) return own;
    if (own.empty()) own = "array_" + std::to_string(index);
    while (given_.contains(own) || !taken_.insert(own).second) own += '_';
    return own;
  }

 private:
  std::set<std::string> given_, taken_;
};

std::string name_among(const CarriedArrays& carried, const vtkAbstractArray* array) {
  for (std::size_t i = 0; i < carried.originals.size(); ++i) {
    if (carried.originals[i] == array) return carried.arrays[i].name;
  }
  return "";
}

}  // namespace

bool is_ghost_mark(vtkAbstractArray* array) {
  if (array->GetName() == nullptr) return false;
  const std::string name = array->GetName();
  return name == vtkDataSetAttributes::GhostArrayName() || name == "vtkGhostLevels";
}

std::vector<std::uint8_t> ghost_flags(vtkUnstructuredGrid* grid) {
  std::vector<std::uint8_t> flags;
  const vtkIdType cells = grid->GetNumberOfCells();
  for (const bool levels : {false, true}) {
    const char* const name = levels ? "vtkGhostLevels" : vtkDataSetAttributes::GhostArrayName();
    vtkDataArray* const marks = grid->GetCellData()->GetArray(name);
    if (marks == nullptr || marks->GetNumberOfComponents() != 1 ||
        marks->GetNumberOfTuples() != cells || marks->GetDataType() == VTK_FLOAT ||
        marks->GetDataType() == VTK_DOUBLE) {
      continue;
    }
    flags.resize(static_cast<std::size_t>(cells));
    for (vtkIdType c = 0; c < cells; ++c) {
      const auto mark = static_cast<std::int64_t>(marks->GetComponent(c, 0));
      std::uint8_t& flag = flags[static_cast<std::size_t>(c)];
      if (!levels) flag = static_cast<std::uint8_t>(mark);
      if (levels && mark > 0) flag |= vtkDataSetAttributes::DUPLICATECELL;
    }
  }
  return flags;
}

GridView::GridView(vtkUnstructuredGrid* grid) {
  take_points(grid);
  take_cells(grid);
  points_ = carry(grid->GetPointData(), "point");
  cells_ = carry(grid->GetCellData(), "cell");
  mesh_.point_arrays = points_.arrays;
  mesh_.cell_arrays = cells_.arrays;
  mesh_.active_scalars = name_among(points_, grid->GetPointData()->GetScalars());
}

std::string GridView::name_of(const vtkAbstractArray* array) const {
  const std::string name = name_among(points_, array);
  return name.empty() ? name_among(cells_, array) : name;
}

tetfusion::Values GridView::values_of(vtkDataArray* array) {
  auto type = type_of(array->GetDataType());
  if (!type || !array->HasStandardMemoryLayout()) {
    if (type) {
      copies_.push_back(tetfusion::vtk_version::in_standard_layout(array));
    } else {  // bits become bytes
      copies_.push_back(vtk::TakeSmartPointer(vtkDataArray::CreateDataArray(VTK_UNSIGNED_CHAR)));
      copies_.back()->DeepCopy(array);
    }
    array = copies_.back();
    type = type_of(array->GetDataType());
  }
  return {*type, array->GetVoidPointer(0), static_cast<std::size_t>(array->GetNumberOfValues())};
}

CarriedArrays GridView::carry(vtkDataSetAttributes* attributes, const char* kind) {
  CarriedArrays carried;
  FreeNames names(attributes);
  for (int i = 0; i < attributes->GetNumberOfArrays(); ++i) {
    vtkAbstractArray* any = attributes->GetAbstractArray(i);
    if (is_ghost_mark(any)) continue;
    auto* array = vtkDataArray::SafeDownCast(any);
    const std::string name = names.name(any->GetName(), i);
    const bool is_taken =
        array != nullptr && (type_of(array->GetDataType()) || array->GetDataType() == VTK_BIT);
    if (!is_taken) {
      left_out_.push_back(std::string(kind) + " array '" + name + "' (" +
                          any->GetDataTypeAsString() + ")");
      continue;
    }
    carried.originals.emplace_back(array);
    carried.arrays.push_back(
        {name, static_cast<std::uint32_t>(array->GetNumberOfComponents()), values_of(array)});
  }
  return carried;
}

void GridView::take_points(vtkUnstructuredGrid* grid) {
  vtkPoints* points = grid->GetPoints();
  if (points == nullptr) return;
  vtkDataArray* coordinates = points->GetData();
  const int type = coordinates->GetDataType();
  if (type != VTK_FLOAT && type != VTK_DOUBLE) {
    copies_.push_back(vtkSmartPointer<vtkDoubleArray>::New());
    copies_.back()->DeepCopy(coordinates);
    coordinates = copies_.back();
  }
  mesh_.points = values_of(coordinates);
}

void GridView::take_cells(vtkUnstructuredGrid* grid) {
  vtkCellArray* cells = grid->GetCells();
  vtkDataArray* types = tetfusion::vtk_version::cell_types(grid);
  if (cells == nullptr || types == nullptr) return;
  mesh_.connectivity = values_of(cells->GetConnectivityArray());
  mesh_.offsets = values_of(cells->GetOffsetsArray());
  const tetfusion::Values bytes = values_of(types);
  mesh_.types = {static_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
  ghosts_ = ghost_flags(grid);
  mesh_.ghosts = ghosts_;
}
