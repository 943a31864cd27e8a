// Which of the original's cells a result still has to have, and how large cells are.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "base/run_context.h"
#include "base/vector.h"
#include "compare/point.h"
#include "io/mesh_source.h"
#include "io/mesh_stream.h"

namespace tetfusion {

// Sets inside[i] to 1 where the point `first` + i, at positions[i], is in a region.
using MarkPoints =
    std::function<void(const MeshStream& stream, std::uint64_t first,
                       std::span<const Vec3<double>> positions, std::uint8_t* inside)>;

// What tells tetrahedra apart by the places of their corners, in any order; ascending.
Vector<std::uint64_t> cell_keys(const Geometry& mesh);

struct OriginalCellFacts {
  std::uint64_t inside = 0;   // cells all of whose points are marked
  std::uint64_t missing = 0;  // those of them that are not among the keys
  Point first_missing{};      // its centre
  double largest_volume = 0;  // of any cell
};

// Reads the original in windows. `mark` may be empty: nothing is inside. A bit a point is in
// memory.
OriginalCellFacts survey_cells(MeshSource* original, const MarkPoints& mark,
                               const Vector<std::uint64_t>& keys, const RunContext& context);

// 0 if there is none.
double largest_volume(const Geometry& mesh);

}  // namespace tetfusion
