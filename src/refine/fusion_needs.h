// Which fusions have to be undone before which others, so that a part of the mesh can be refined
// alone.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "base/vector.h"
#include "mesh/fusion_log.h"
#include "refine/refinable_mesh.h"

namespace tetfusion {

// A fusion needs those that have changed a tetrahedron of its star since: moved, made a corner of
// it another one, or deleted it. Then the star is what the fusion left, and what comes back in its
// place has the same surface, whatever becomes of the rest (README.md).
class FusionNeeds {
 public:
  FusionNeeds(std::uint64_t points, std::uint64_t cells);

  // Fusions in the order of the file, each when all up to it have been undone; `star` is that of
  // the mesh (RefinableMesh::star()).
  void add(const FusionRecord& record, bool row_changed, std::span<const TetId> star);

  // When all have been added: 1 for each that has to be undone, so that every tetrahedron of the
  // original with a point inside comes back.
  Vector<std::uint8_t> of_region(const RefinableMesh& original,
                                 std::span<const std::uint8_t> inside) const;

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  void need(std::uint32_t fusion) {
    if (fusion != kNone) own_.push_back(fusion);
  }

  Vector<std::uint32_t> of_tet_, of_point_;  // the last fusion that has changed it
  Vector<std::uint64_t> ends_;               // of each fusion's, in needs_
  Vector<std::uint32_t> needs_;
  std::vector<std::uint32_t> own_;
};

}  // namespace tetfusion
