// Which cell of a mesh has the same points as a given one, in whatever order.
#pragma once

#include <vtkCellArray.h>
#include <vtkUnsignedCharArray.h>

#include <vector>

namespace tetfusion {

// For each cell of the second list the one of the first that has its type and points; empty where
// one has none, or two have the same. The ids may be any.
std::vector<vtkIdType> find_cells(vtkCellArray* among, vtkUnsignedCharArray* types_among,
                                  vtkCellArray* wanted, vtkUnsignedCharArray* types_wanted);

}  // namespace tetfusion
