// Which fusions have to be undone before which others, so that a part of the mesh can be refined
// alone.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/vector.h"
#include "io/files/paged_array.h"
#include "mesh/fusion_log.h"
#include "refine/refinable_mesh.h"

namespace tetfusion {

// A fusion needs those that have changed a tetrahedron of its star since: moved, made a corner of
// it another one, or deleted it. Then the star is what the fusion left, and what comes back in its
// place has the same surface, whatever becomes of the rest (README.md).
class FusionNeeds {
 public:
  // `folder` as in PagedBytes.
  FusionNeeds(std::uint64_t points, std::uint64_t cells, const std::string& folder = {});
  // Bytes that it takes, about.
  static std::uint64_t bytes_for(const ProgressiveCounts& counts);
  void let_go() const;

  // Fusions in the order of the file, each when all up to it have been undone; `star` is that of
  // the mesh (RefinableMesh::star()).
  void add(const FusionRecord& record, bool row_changed, std::span<const TetId> star);

  // When all have been added: 1 for each that has to be undone, so that every tetrahedron of the
  // original with a point inside comes back.
  Vector<std::uint8_t> of_region(const RefinableMesh& original,
                                 std::span<const std::uint8_t> inside) const;

 private:
  void need(std::uint32_t one_more) {
    if (one_more != 0) own_.push_back(one_more - 1);
  }

  PagedArray<std::uint32_t> of_tet_, of_point_;  // one more than the last fusion that changed it
  PagedArray<std::uint64_t> ends_;               // of each fusion's, in needs_
  PagedArray<std::uint32_t> needs_;
  std::vector<std::uint32_t> own_;
};

}  // namespace tetfusion
