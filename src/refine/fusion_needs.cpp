#include "refine/fusion_needs.h"

#include <algorithm>

#include "mesh/split_cells.h"

namespace tetfusion {

FusionNeeds::FusionNeeds(std::uint64_t points, std::uint64_t cells, const std::string& folder)
    : of_tet_(folder, cells), of_point_(folder, points), ends_(folder, 0), needs_(folder, 0) {}

// A fusion needs ten others, about.
std::uint64_t FusionNeeds::bytes_for(const ProgressiveCounts& counts) {
  return (counts.cells + counts.points) * 4 + counts.fusions * (8 + 60);
}

void FusionNeeds::let_go() const {
  of_tet_.let_go();
  of_point_.let_go();
  ends_.let_go();
  needs_.let_go();
}

void FusionNeeds::add(const FusionRecord& record, bool row_changed, std::span<const TetId> star) {
  const auto self = static_cast<std::uint32_t>(ends_.size() + 1);
  own_.clear();
  for (std::size_t i = 0; i < star.size(); ++i) {
    need(of_tet_[star[i]]);
    if (row_changed || record.star[i] != 0) of_tet_[star[i]] = self;
  }
  need(of_point_[record.kept]);
  of_point_[record.kept] = self;
  for (const VertexId v : record.elsewhere) need(of_point_[v]);
  for (const VertexId v : record.points) of_point_[v] = self;
  for (const TetId t : record.tets) of_tet_[t] = self;
  std::sort(own_.begin(), own_.end());
  own_.erase(std::unique(own_.begin(), own_.end()), own_.end());
  for (const std::uint32_t fusion : own_) needs_.push_back(fusion);
  ends_.push_back(needs_.size());
}

Vector<std::uint8_t> FusionNeeds::of_region(const RefinableMesh& original,
                                            std::span<const std::uint8_t> inside) const {
  Vector<std::uint8_t> needed(ends_.size(), std::uint8_t{0});
  const auto mark = [&](std::uint32_t one_more) {
    if (one_more != 0) needed[one_more - 1] = 1;
  };
  for (std::size_t v = 0; v < of_point_.size(); ++v) {
    if (inside[v] != 0) mark(of_point_[v]);
  }
  for (std::size_t t = 0; t < of_tet_.size(); ++t) {
    if (original.type_of(t) != kVtkTetra) continue;
    const auto corners = original.corners_of(t);
    if (std::any_of(corners.begin(), corners.end(), [&](VertexId v) { return inside[v] != 0; })) {
      mark(of_tet_[t]);
    }
  }
  // What a fusion needs comes before it.
  for (std::size_t i = needed.size(); i-- > 0;) {
    if (needed[i] == 0) continue;
    for (std::uint64_t k = i == 0 ? 0 : ends_[i - 1]; k < ends_[i]; ++k) needed[needs_[k]] = 1;
  }
  return needed;
}

}  // namespace tetfusion
