// Two neighbours that are to become one.
#pragma once

#include <cstdint>
#include <span>

#include "mesh/work_mesh.h"

namespace tetfusion {

template <class Real>
struct Joining {
  VertexId v = kNoVertex, partner = kNoVertex;
  bool fixed = false;  // the partner stays where it is, and as it is
  Vec3<Real> position{};
  std::span<const std::uint32_t> affected;  // tet << 2 | corner of the vertex that moves
  std::span<const TetId> deleted;
};

}  // namespace tetfusion
