// What versions of VTK from 9.1 on say in different ways. Nothing else asks for the version.
#pragma once

#include <vtkAlgorithm.h>
#include <vtkCellArray.h>
#include <vtkDataArray.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>
#include <vtkVersionMacros.h>

#if VTK_VERSION_NUMBER < VTK_VERSION_CHECK(9, 4, 0)
#include <vtkIdTypeArray.h>
#endif
#if VTK_VERSION_NUMBER < VTK_VERSION_CHECK(9, 6, 0)
#include <vtkUnsignedCharArray.h>
#endif

namespace tetfusion::vtk_version {

// One of VTK's cell types for each cell, as unsigned chars; null where there are none. From 9.6 on
// it may be an array without memory, of cells that are all of one type.
inline vtkDataArray* cell_types(vtkUnstructuredGrid* grid) {
#if VTK_VERSION_NUMBER < VTK_VERSION_CHECK(9, 6, 0)
  return grid->GetCellTypesArray();
#else
  return grid->GetCellTypes();
#endif
}

// Was it asked to end, or, from 9.3 on, something before it in the pipeline? Since then whoever has
// asked takes that back, by SetAbortExecute(0), before it runs again.
inline bool is_aborted(vtkAlgorithm* algorithm) {
#if VTK_VERSION_NUMBER < VTK_VERSION_CHECK(9, 3, 0)
  return algorithm->GetAbortExecute() != 0;
#else
  return algorithm->CheckAbort();
#endif
}

inline bool has_polyhedra(vtkUnstructuredGrid* grid) {
#if VTK_VERSION_NUMBER < VTK_VERSION_CHECK(9, 4, 0)
  return grid->GetFaces() != nullptr;
#else
  return grid->GetPolyhedronFaces() != nullptr;
#endif
}

// Of cells' corners, types and faces.
inline unsigned long kibibytes_of_cells(vtkUnstructuredGrid* grid) {
  unsigned long sum = 0;
  const auto add = [&](auto* part) {
    if (part != nullptr) sum += part->GetActualMemorySize();
  };
  add(grid->GetCells());
  add(cell_types(grid));
#if VTK_VERSION_NUMBER < VTK_VERSION_CHECK(9, 4, 0)
  add(grid->GetFaces());
  add(grid->GetFaceLocations());
#else
  add(grid->GetPolyhedronFaces());
  add(grid->GetPolyhedronFaceLocations());
#endif
  return sum;
}

// An array with the same values and type one behind the other in memory, whatever the layout of
// this one; not of bits.
inline vtkSmartPointer<vtkDataArray> in_standard_layout(vtkDataArray* array) {
  const auto copy = vtk::TakeSmartPointer(vtkDataArray::CreateDataArray(array->GetDataType()));
  if (copy->GetDataType() == VTK_FLOAT || copy->GetDataType() == VTK_DOUBLE) {
    copy->DeepCopy(array);
    return copy;
  }
  // DeepCopy() goes through doubles, and not all arrays can be exported.
  copy->SetNumberOfComponents(array->GetNumberOfComponents());
  copy->SetNumberOfTuples(array->GetNumberOfTuples());
#if VTK_VERSION_NUMBER < VTK_VERSION_CHECK(9, 7, 0)
  if (array->GetArrayType() == vtkAbstractArray::SoADataArrayTemplate) {
    if (array->GetNumberOfValues() > 0) array->ExportToVoidPointer(copy->GetVoidPointer(0));
    return copy;
  }
#endif
  for (vtkIdType i = 0; i < array->GetNumberOfValues(); ++i) {
    copy->SetVariantValue(i, array->GetVariantValue(i));
  }
  return copy;
}

// A reader of OpenFOAM leaves polyhedra as they are. From 9.4 on it cannot do otherwise.
template <class Reader>
void keep_polyhedra(Reader* reader) {
  if constexpr (requires { reader->SetDecomposePolyhedra(false); }) {
    reader->SetDecomposePolyhedra(false);
  }
}

}  // namespace tetfusion::vtk_version
