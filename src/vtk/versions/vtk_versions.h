// What versions of VTK from 9.1 on say in different ways. Nothing else asks for the version.
#pragma once

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
#if VTK_VERSION_NUMBER < VTK_VERSION_CHECK(9, 7, 0)
  copy->SetNumberOfComponents(array->GetNumberOfComponents());
  copy->SetNumberOfTuples(array->GetNumberOfTuples());
  if (array->GetArrayType() == vtkAbstractArray::SoADataArrayTemplate) {
    if (array->GetNumberOfValues() > 0) array->ExportToVoidPointer(copy->GetVoidPointer(0));
  } else if (copy->GetDataType() == VTK_FLOAT || copy->GetDataType() == VTK_DOUBLE) {
    copy->DeepCopy(array);
  } else {  // DeepCopy() goes through doubles, and not all arrays can be exported
    for (vtkIdType i = 0; i < array->GetNumberOfValues(); ++i) {
      copy->SetVariantValue(i, array->GetVariantValue(i));
    }
  }
#else
  copy->DeepCopy(array);
#endif
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
