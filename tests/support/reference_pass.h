// The greedy pass once more, written straight from the paper (Chopra & Meyer 2002, section 3), with
// no adjacency and no memory: every question is answered by a look at all tetrahedra. Slow,
// obvious, and sharing no code with the kernel.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace tetfusion::testing {

struct ReferenceMesh {
  std::vector<std::array<double, 3>> points;
  std::vector<double> scalars;    // one a point
  std::vector<bool> on_boundary;  // one a point
  std::vector<std::array<std::uint32_t, 4>> tets;
};

struct ReferenceLimits {
  bool boundary_tets_stay = false;  // the rule "tets", else "vertices"
  double scalar_tolerance = std::numeric_limits<double>::infinity();  // absolute
  double stretch_factor = std::numeric_limits<double>::infinity();
  double aspect_ratio = std::numeric_limits<double>::infinity();
};

struct ReferenceResult {
  ReferenceMesh mesh;  // ids as before; points that no tetrahedron uses any more stay
  std::uint64_t fused = 0;
  // Candidates that were refused.
  std::uint64_t boundary = 0, scalar = 0, flip = 0, stretch = 0, aspect = 0;
};

ReferenceResult reference_pass(const ReferenceMesh& mesh, const ReferenceLimits& limits);

}  // namespace tetfusion::testing
