// What is to be said of a mesh, however it was looked at: whole (inspect.h), or in chunks.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mesh/inspection/inspect.h"
#include "mesh/inspection/mesh_counts.h"

namespace tetfusion {

struct InspectionSummary : MeshCounts {
  std::uint64_t points = 0;  // that cells use
  std::uint64_t tets = 0;
  std::uint64_t lower_vertices = 0, lower_lines = 0, lower_triangles = 0;
  std::uint64_t unused_points = 0;     // used by no cell
  std::uint64_t merged_points = 0;     // copies in other pieces of the file
  std::uint64_t differing_points = 0;  // of these, with other values in some array
  LargestDifference largest_difference;
  std::uint64_t ghost_cells = 0;  // another piece's cells, left out
  std::uint64_t coincident_points = 0;

  std::uint64_t components = 0;          // of the cells, connected by faces
  std::uint64_t surface_components = 0;  // of the boundary, connected by vertices

  double volume = 0;
  std::array<double, 3> lower{}, upper{};  // the box of the points

  // The first kFirstIds of each kind, as the file counts cells and points. Fewer where it was not
  // found out which they are.
  std::array<std::vector<std::uint64_t>, kDefectKinds> samples;
  const std::vector<std::uint64_t>& first(Defect kind) const {
    return samples[static_cast<std::size_t>(kind)];
  }
  // Where each of them is: the centre of a cell, or a point.
  std::array<std::vector<std::array<double, 3>>, kDefectKinds> places;
  const std::vector<std::array<double, 3>>& places_of(Defect kind) const {
    return places[static_cast<std::size_t>(kind)];
  }

  std::uint64_t lower_cells() const { return lower_vertices + lower_lines + lower_triangles; }

  void count_lower(const LowerCells& cells);
};

inline constexpr bool is_of_points(Defect kind) { return kind >= Defect::kNonmanifoldEdge; }

// Where a sample of that kind is: cell or point `id` of the mesh.
std::array<double, 3> place_of(const Geometry& mesh, Defect kind, std::uint32_t id);

// `inspection` is that of the geometry.
InspectionSummary summarize(const Geometry& geometry, const Inspection& inspection);

}  // namespace tetfusion
