// What VTK's readers give, taken apart.
#pragma once

#include <vtkAbstractArray.h>
#include <vtkDataObject.h>
#include <vtkFieldData.h>
#include <vtkSmartPointer.h>

#include <string>

#include "vtk/vtk_load.h"

namespace tetfusion {

// Adds the data sets of `data`, which may be composite, as pieces of blocks, and its field data.
// Throws Error(kBadInput) where there is none, or something else.
void collect(vtkDataObject* data, const std::string& path, LoadedFile* out);

// With that array alone.
vtkSmartPointer<vtkFieldData> field_data_of(vtkAbstractArray* array);

}  // namespace tetfusion
