// A slow and obvious judge of meshes. It shares nothing with src/mesh but the plain structs: signs
// in long double, faces in a std::map.
#pragma once

#include <array>
#include <cstdint>
#include <set>

#include "mesh/geometry.h"

namespace tetfusion::testing {

struct BruteReport {
  std::uint64_t positive = 0;  // cells by the sign of their volume as they are wound
  std::uint64_t negative = 0;
  std::uint64_t zero = 0;
  std::uint64_t duplicates = 0;  // cells with the four vertices of an earlier one
  std::uint64_t foldover = 0;    // faces whose two cells, of different apex, lie on the same side
  std::uint64_t overfull = 0;    // faces with more than two cells
  std::uint64_t nonmanifold_edges = 0;         // of the boundary: not two triangles
  std::uint64_t nonmanifold_vertices = 0;      // of the boundary: not one closed fan of triangles
  std::uint64_t components = 0;                // connected by faces
  std::set<std::array<VertexId, 3>> boundary;  // ids ascending in each
  long double volume = 0;                      // of all cells, whatever their winding

  bool conforming() const { return foldover == 0 && overfull == 0 && duplicates == 0; }
  bool valid() const { return conforming() && negative == 0 && zero == 0; }
};

// Cells that name a vertex twice have zero volume and no faces.
BruteReport brute_check(const Geometry& mesh);

}  // namespace tetfusion::testing
