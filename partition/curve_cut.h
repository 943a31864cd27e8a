// Where a macroLoD is cut into chunks: pieces of a Hilbert curve that hold about the same number of
// tetrahedra. Each round shifts the curve, so that what lay on an interface lies inside a chunk the
// next time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

struct CurveCut {
  std::uint32_t chunks = 1;
  Vector<std::uint32_t> chunk_of_vertex;

  // A tetrahedron belongs to the chunk of its smallest vertex: there are six times fewer vertices
  // than tetrahedra to find a place on the curve for.
  std::uint32_t chunk_of(const Tet& t) const {
    return chunk_of_vertex[std::min({t[0], t[1], t[2], t[3]})];
  }
};

// Cuts into ceil(tets / chunk_tets) chunks; chunk_tets > 0. A chunk may turn out a quarter larger
// or smaller, and where points coincide one may be empty. A function of the arguments alone,
// whatever the number of threads.
template <class Real>
CurveCut cut_curve(const Vector<Vec3<Real>>& positions, std::span<const Tet> tets,
                   std::uint64_t chunk_tets, std::uint32_t round);

}  // namespace tetfusion
