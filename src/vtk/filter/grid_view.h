// A grid as the library wants meshes.
#pragma once

#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <cstdint>
#include <string>
#include <vector>

#include "tetfusion.h"

// Is the array called like those that mark ghosts?
bool is_ghost_mark(vtkAbstractArray* array);

// Flags of each cell, as tetfusion::Mesh::ghosts has them: by the arrays that the command obeys, of
// any integers, those of older programs (vtkGhostLevels) included. Empty where there are none.
std::vector<std::uint8_t> ghost_flags(vtkUnstructuredGrid* grid);

// The arrays of the points, or of the cells, that the library takes.
struct CarriedArrays {
  std::vector<vtkSmartPointer<vtkDataArray>> originals;  // in the grid
  std::vector<tetfusion::Array> arrays;                  // one for each
};

// Refers to the grid's memory where that is laid out as the library wants it, and holds copies of
// the rest. The grid must stay as it is. Ghost marks are not among the arrays.
class GridView {
 public:
  explicit GridView(vtkUnstructuredGrid* grid);

  const tetfusion::Mesh& mesh() const { return mesh_; }
  const CarriedArrays& point_arrays() const { return points_; }
  const CarriedArrays& cell_arrays() const { return cells_; }
  // What the library calls the array, which need not have a name; empty where it is not carried.
  std::string name_of(const vtkAbstractArray* array) const;
  // Arrays that are no numbers: "point array 'label' (string)".
  const std::vector<std::string>& left_out() const { return left_out_; }

 private:
  tetfusion::Values values_of(vtkDataArray* array);
  CarriedArrays carry(vtkDataSetAttributes* attributes, const char* kind);
  void take_points(vtkUnstructuredGrid* grid);
  void take_cells(vtkUnstructuredGrid* grid);

  tetfusion::Mesh mesh_;
  CarriedArrays points_, cells_;
  std::vector<std::string> left_out_;
  std::vector<vtkSmartPointer<vtkDataArray>> copies_;
  std::vector<std::uint8_t> ghosts_;
};
