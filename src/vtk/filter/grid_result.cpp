#include "vtk/filter/grid_result.h"

#include <vtkBitArray.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkFieldData.h>
#include <vtkIdList.h>
#include <vtkInformation.h>
#include <vtkLookupTable.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>
#include <vtkPoints.h>
#include <vtkTypeInt32Array.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>

namespace {

void hand_over(tetfusion::OwnedValues* values, vtkDataArray* array) {
  const auto size = static_cast<vtkIdType>(values->size());
  if (size > 0)
    array->SetVoidArray(values->release(), size, 0, vtkAbstractArray::VTK_DATA_ARRAY_FREE);
}

void describe_like(vtkDataArray* original, vtkDataArray* array) {
  array->SetName(original->GetName());
  array->SetNumberOfComponents(original->GetNumberOfComponents());
  if (original->HasAComponentName()) {
    for (int c = 0; c < original->GetNumberOfComponents(); ++c) {
      if (original->GetComponentName(c) != nullptr) {
        array->SetComponentName(c, original->GetComponentName(c));
      }
    }
  }
  if (original->GetLookupTable() != nullptr) array->SetLookupTable(original->GetLookupTable());
  if (original->HasInformation()) array->CopyInformation(original->GetInformation());
}

vtkSmartPointer<vtkDataArray> make_array(vtkDataArray* original) {
  auto array = vtk::TakeSmartPointer(vtkDataArray::CreateDataArray(original->GetDataType()));
  describe_like(original, array);
  return array;
}

// Bits come as bytes, and become bits again.
void fill_array(tetfusion::OwnedValues* values, vtkDataArray* array) {
  auto* const bits = vtkBitArray::SafeDownCast(array);
  if (bits == nullptr) {
    hand_over(values, array);
    return;
  }
  const auto* const bytes = static_cast<const unsigned char*>(values->data());
  bits->SetNumberOfValues(static_cast<vtkIdType>(values->size()));
  for (std::size_t i = 0; i < values->size(); ++i) {
    bits->SetValue(static_cast<vtkIdType>(i), bytes[i] != 0 ? 1 : 0);
  }
}

// That of Options::original_ids, which the input does not have.
vtkSmartPointer<vtkDataArray> make_original_ids() {
  auto array = vtk::TakeSmartPointer(vtkDataArray::CreateDataArray(VTK_TYPE_INT64));
  array->SetName("OriginalPointIds");
  return array;
}

using Arrays = std::vector<vtkSmartPointer<vtkDataArray>>;

// `results` are those of the originals, one each. Of several with one name VTK keeps the last.
void mark_active(const Arrays& originals, const Arrays& results, vtkDataSetAttributes* from,
                 vtkDataSetAttributes* to) {
  for (int kind = 0; kind < vtkDataSetAttributes::NUM_ATTRIBUTES; ++kind) {
    const auto at = std::find(originals.begin(), originals.end(), from->GetAbstractAttribute(kind));
    if (at == originals.end()) continue;
    const vtkAbstractArray* result = results[static_cast<std::size_t>(at - originals.begin())];
    for (int i = 0; i < to->GetNumberOfArrays(); ++i) {
      if (to->GetAbstractArray(i) == result) to->SetActiveAttribute(i, kind);
    }
  }
}

void fill_attributes(const CarriedArrays& carried, vtkDataSetAttributes* from,
                     std::vector<tetfusion::OwnedArray>* arrays, vtkDataSetAttributes* to) {
  Arrays results;
  for (std::size_t i = 0; i < arrays->size(); ++i) {
    const auto array =
        i < carried.originals.size() ? make_array(carried.originals[i]) : make_original_ids();
    fill_array(&(*arrays)[i].values, array);
    to->AddArray(array);
    results.emplace_back(array);
  }
  mark_active(carried.originals, results, from, to);
}

template <class Ids>
void fill_cells(tetfusion::OwnedMesh* mesh, vtkUnsignedCharArray* types,
                vtkUnstructuredGrid* output) {
  vtkNew<Ids> offsets, connectivity;
  hand_over(&mesh->offsets, offsets);
  hand_over(&mesh->connectivity, connectivity);
  vtkNew<vtkCellArray> cells;
  cells->SetData(offsets.Get(), connectivity.Get());
  output->SetCells(types, cells);
}

void empty_like(vtkDataSetAttributes* from, vtkDataSetAttributes* to) {
  Arrays originals, results;
  for (int i = 0; i < from->GetNumberOfArrays(); ++i) {
    auto* array = from->GetArray(i);
    if (array == nullptr || is_ghost_mark(array)) continue;
    originals.emplace_back(array);
    results.emplace_back(make_array(array));
    to->AddArray(results.back());
  }
  mark_active(originals, results, from, to);
}

}  // namespace

void fill_grid(const GridView& view, vtkUnstructuredGrid* input, tetfusion::OwnedMesh mesh,
               vtkUnstructuredGrid* output) {
  vtkNew<vtkPoints> points;
  points->SetDataType(mesh.points.type() == tetfusion::Type::kFloat32 ? VTK_FLOAT : VTK_DOUBLE);
  hand_over(&mesh.points, points->GetData());
  output->SetPoints(points);
  vtkNew<vtkUnsignedCharArray> types;
  hand_over(&mesh.types, types);
  if (mesh.connectivity.type() == tetfusion::Type::kInt32) {
    fill_cells<vtkTypeInt32Array>(&mesh, types, output);
  } else {
    fill_cells<vtkTypeInt64Array>(&mesh, types, output);
  }
  fill_attributes(view.point_arrays(), input->GetPointData(), &mesh.point_arrays,
                  output->GetPointData());
  fill_attributes(view.cell_arrays(), input->GetCellData(), &mesh.cell_arrays,
                  output->GetCellData());
  output->GetFieldData()->ShallowCopy(input->GetFieldData());
}

void fill_grid_as_it_is(vtkDataSet* input, bool original_ids, vtkUnstructuredGrid* output) {
  const vtkIdType points = input->GetNumberOfPoints();
  if (input->IsA("vtkUnstructuredGrid")) {
    output->ShallowCopy(input);
  } else {
    vtkNew<vtkPoints> copies;
    if (auto* const set = vtkPointSet::SafeDownCast(input); set != nullptr && points > 0) {
      copies->ShallowCopy(set->GetPoints());
    } else {
      copies->SetDataTypeToDouble();
      for (vtkIdType p = 0; p < points; ++p) copies->InsertNextPoint(input->GetPoint(p));
    }
    output->SetPoints(copies);
    output->Allocate(input->GetNumberOfCells());
    vtkNew<vtkIdList> corners;
    for (vtkIdType c = 0; c < input->GetNumberOfCells(); ++c) {
      input->GetCellPoints(c, corners);
      output->InsertNextCell(input->GetCellType(c), corners);
    }
    output->GetPointData()->ShallowCopy(input->GetPointData());
    output->GetCellData()->ShallowCopy(input->GetCellData());
    output->GetFieldData()->ShallowCopy(input->GetFieldData());
  }
  if (!original_ids) return;
  const auto ids = make_original_ids();
  ids->SetNumberOfTuples(points);
  for (vtkIdType p = 0; p < points; ++p) ids->SetTuple1(p, static_cast<double>(p));
  output->GetPointData()->AddArray(ids);
}

void fill_empty_grid(vtkDataSet* input, bool original_ids, vtkUnstructuredGrid* output) {
  vtkNew<vtkPoints> points;
  auto* const set = vtkPointSet::SafeDownCast(input);
  if (set != nullptr && set->GetPoints() != nullptr) {
    points->SetDataType(set->GetPoints()->GetDataType());
  }
  output->SetPoints(points);
  empty_like(input->GetPointData(), output->GetPointData());
  if (original_ids) output->GetPointData()->AddArray(make_original_ids());
  empty_like(input->GetCellData(), output->GetCellData());
  output->GetFieldData()->ShallowCopy(input->GetFieldData());
}
