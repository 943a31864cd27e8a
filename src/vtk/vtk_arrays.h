// The arrays of all pieces of a file as one table, and their values.
#pragma once

#include <vtkAbstractArray.h>
#include <vtkFieldData.h>
#include <vtkSmartPointer.h>

#include <string>
#include <vector>

#include "base/vector.h"
#include "io/source/differing_copies.h"
#include "mesh/data_array.h"
#include "mesh/geometry.h"
#include "vtk/vtk_pieces.h"

namespace tetfusion {

struct ArrayTable {
  AttributeSet set;
  // For each array of the set its part in each piece that brings rows; of points, where that piece
  // lacks it, that of the next one with the same points, else null. For field data the one array.
  std::vector<std::vector<vtkAbstractArray*>> parts;
  // What MeshSource cannot hold: "point array 'label' (String)".
  std::vector<std::string> left_out;
};

// The point or cell arrays. vtkGhostType is not among them. Where pieces have an array in types of
// the same kind, the wider one is that of all. Throws Error(kBadInput) if an array does not have a
// row for each point or cell, or differs otherwise between pieces.
ArrayTable collect_arrays(const std::string& path, const PieceList& list, Association association);

// Field data: of arrays with one name the first one.
ArrayTable collect_field_data(const std::vector<vtkSmartPointer<vtkFieldData>>& fields);

bool some_piece_lacks(const ArrayTable& table, std::size_t index);

// The values of array `index`. Where a piece lacks the array, a point has the value of its first
// copy in a piece that has it; other floating-point values are NaN, integers 0. `copy_of` is
// PointUse's, or empty where nothing is to be taken from copies.
DataArray read_values(const PieceList& list, const ArrayTable& table, Association association,
                      std::size_t index, const Vector<VertexId>& copy_of = {});

// What copies have, in some array of the points, other values of than the points have that they are
// merged into. `copy_of` and `used` are PointUse's.
CopyDifferences find_differences(const PieceList& list, const ArrayTable& points,
                                 const Vector<VertexId>& copy_of, const Vector<std::uint8_t>& used);

}  // namespace tetfusion
