// The library's result as a grid.
#pragma once

#include <vtkUnstructuredGrid.h>

#include "vtk/filter/grid_view.h"

// Hands the memory of `mesh` to `output`, with what the arrays of `input` have besides values:
// names, types, names of components, lookup tables, and which of them are active. `view` is of the
// input.
void fill_grid(const GridView& view, vtkUnstructuredGrid* input, tetfusion::OwnedMesh mesh,
               vtkUnstructuredGrid* output);

// The same for a mesh without cells.
void fill_empty_grid(vtkDataSet* input, bool original_ids, vtkUnstructuredGrid* output);

// The same for a surface, or what else has no volume, which stays as it is.
void fill_grid_as_it_is(vtkDataSet* input, bool original_ids, vtkUnstructuredGrid* output);
