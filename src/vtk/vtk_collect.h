// What VTK's readers give, taken apart.
#pragma once

#include <vtkAbstractArray.h>
#include <vtkAlgorithm.h>
#include <vtkDataObject.h>
#include <vtkFieldData.h>
#include <vtkSmartPointer.h>

#include <string>

#include "vtk/vtk_load.h"
#include "vtk/vtk_trap.h"

namespace tetfusion {

// Adds the data sets of `data`, which may be composite, as pieces of blocks, and its field data.
// Throws Error(kBadInput) where there is none, or something else.
void collect(vtkDataObject* data, const std::string& path, LoadedFile* out);

// The same for what is one block of that name, whatever it is made of. Nothing: it is none.
void add_block(vtkDataObject* data, const std::string& name, const std::string& path,
               LoadedFile* out);

// The same, asking VTK's reader for one piece after the other.
void collect_pieces(vtkAlgorithm* reader, int pieces, const std::string& path,
                    const TrapScope& trap, LoadedFile* out);

// Says of each cell which block it is of, where several blocks have cells: these are most often
// materials, and the patches of a boundary. The name is one whose interfaces are kept. The blocks'
// names go beside it.
void mark_blocks(LoadedFile* file);

// With that array alone.
vtkSmartPointer<vtkFieldData> field_data_of(vtkAbstractArray* array);

}  // namespace tetfusion
