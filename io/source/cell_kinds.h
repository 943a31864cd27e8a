// What the readers make of VTK's cell types: the one place that decides it, so that a mesh means
// the same in every format.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "io/source/mesh_source.h"
#include "mesh/geometry.h"
#include "mesh/split_cells.h"

namespace tetfusion {

// Bits of vtkGhostType for which a cell is left out: a copy of another piece's cell, one that a
// refinement has replaced, one that is hidden.
inline constexpr int kGhostCopy = 1;
inline constexpr int kGhostRefined = 8;
inline constexpr int kGhostHidden = 32;
inline constexpr int kGhostDropped = kGhostCopy | kGhostRefined | kGhostHidden;

// After ghost cells were dropped and points merged nothing is a copy any more: clears what says so
// in the values of vtkGhostType and vtkGhostLevels, and leaves other arrays as they are.
void forget_ghosts(Association association, const ArrayInfo& info, std::span<std::byte> values);

// Lagrange and Bezier cells, whose type does not say of which order they are.
inline bool is_of_any_order(std::uint8_t type) {
  return type >= kVtkLagrangeCurve && type <= kVtkBezierPyramid;
}

// What a cell with so many vertices is: one of any order that has only corners the linear cell.
// Others are what their type says.
std::uint8_t settled_type(std::uint8_t type, std::uint64_t vertices);

// The type of a curved cell without what it has beside its corners, which come first in every
// cell; of others the type itself.
std::uint8_t linear_type(std::uint8_t type);

// How many corners a cell has, curved or not; 0 where its type does not say.
inline std::size_t corners_of(std::uint8_t type) {
  return static_cast<std::size_t>(vtk_cell_size(linear_type(type)));
}

// In place of the type of a cell that is left out: a ghost cell, or a patch's.
inline constexpr std::uint8_t kLeftOut = 255;

// Whether a cell of this type is one of the patches that are dropped with these options: any that
// has no volume, whether it could be read or not.
bool is_dropped_patch(std::uint8_t type, const OpenOptions& options);

// Overwrites the types of those.
void leave_out_patches(const OpenOptions& options, std::span<std::uint8_t> types);

// How many of a cell's vertices are kept with these options, from the first on: its corners. None
// of a cell that is left out; -1 when the cell cannot be read.
int kept_vertices(std::uint8_t type, const OpenOptions& options);

// Whether a cell of this settled type may have so many vertices.
bool may_have_vertices(std::uint8_t type, std::uint64_t count);

// The parts of a cell that is split have its values, so that numbers of cells are there several
// times: where cells may be split an array marked GlobalIds is marked PedigreeIds instead, unless
// another one is.
void unmark_global_ids(const OpenOptions& options, AttributeSet* cell_data);

// Ends the sentence "cell 7 " for a cell that cannot be read with these options: "is a hexahedron
// (VTK cell type 12): use --tetrahedralize to split such cells". Polygons and polyhedra of files
// alone are split.
std::string refusal(std::uint8_t type, const OpenOptions& options, bool is_in_memory = false);

// Ends the sentence "cell 7 " for a cell with another number of vertices than its type has.
std::string wrong_vertex_count(std::uint8_t type, std::uint64_t count);

// Ends the sentence "cell 7 " for a vertex id that is out of range; `id` as the file has it.
std::string wrong_vertex(const std::string& id, std::uint64_t points);

// Cuts a quadrilateral (or pixel) like the face of a split cell that it lies on: from its smallest
// vertex. Writes its triangles and returns how many there are: 2, or fewer when it names a vertex
// twice.
int split_quadrilateral(std::uint8_t type, std::array<VertexId, 4> ids,
                        std::array<std::array<VertexId, 3>, 2>* out);

}  // namespace tetfusion
