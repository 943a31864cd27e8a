// Of fuse_round.h: what is particular to vertices on a sheet.
#include <algorithm>

#include "kernel/fuse_round.h"

namespace tetfusion {

namespace {

// Where the best position is not allowed, others on the edge are tried that cost at most so much
// more. (To be pushed off a tetrahedron would lead off the sheet.)
constexpr float kSlack = 1.3F;
constexpr std::array<float, 3> kElsewhere{0.5F, 0.0F, 1.0F};

}  // namespace

template <class Real>
auto FuseRound<Real>::kind_on_sheet(VertexId v) -> Kind {
  if (limits_->sheets_rest) return is_on_one(v) ? kTarget : kFree;
  switch (sheets_.place(v)) {
    case SheetPlace::kNone:
      return kFree;
    case SheetPlace::kSmooth:
      return kOnSheet;
    case SheetPlace::kLine:
      return kOnLine;
    case SheetPlace::kCorner:
      return kTarget;
  }
  return kTarget;
}

// A vertex on a sheet gets its quadric when it is first free.
template <class Real>
void FuseRound<Real>::begin_sheets() {
  sheets_.begin(mesh_, &balls_, limits_->regions);
  sheet_fusion_.begin(mesh_, &sheets_,
                      {limits_->unit, limits_->max_deviation, limits_->deviation_before,
                       limits_->facing, &triangles_, errors_.bounds()});
  if (limits_->facing != nullptr) {
    triangles_.begin(*limits_->facing);
    for (VertexId v = 0; v < mesh_->vertex_count(); ++v) sheets_.note_facing(v, &triangles_);
  }
  if (limits_->sheets_rest) return;
  const std::size_t at = quadric_size(width_);
  for (VertexId v = 0; v < mesh_->vertex_count(); ++v) {
    if (!is_on_one(v) || (mesh_->marks[v] & kOnInterface) != 0) continue;
    float* quadric = mesh_->quadrics.data() + std::size_t{v} * mesh_->quadric_width + at;
    if (quadric[kQuadricW] == 0) sheets_.add_planes(v, limits_->unit, quadric);
  }
}

// Those along edges of the sheet, or of the line.
template <class Real>
void FuseRound<Real>::find_partners_on_sheet(VertexId v) {
  partners_.clear();
  const bool is_line = state_[v].kind == kOnLine;
  if (!sheets_.find_fan(v, &fan_) || (is_line && fan_.sharp_edges != 2)) return;
  for (std::size_t i = 0; i < fan_.size(); ++i) {
    const VertexId u = fan_.ring[i];
    if (is_line && (fan_.sharp[i] == 0 || state_[u].kind == kOnSheet)) continue;
    partners_.push_back(u);
  }
}

// Finds a position that is allowed, and the cavity.
template <class Real>
bool FuseRound<Real>::plan_on_sheet(VertexId v, VertexId partner) {
  fixed_ = state_[partner].kind != state_[v].kind;
  if (!sheet_fusion_.choose(v, partner, fixed_, along(v))) {
    reject_ = Reject::kSurface;
    return false;
  }
  if (fixed_) {
    position_ = mesh_->positions[partner];
    return allows(v, partner);
  }
  const MergedQuadric& merged = edge_costs_.merge_on_sheet(v, partner, along(v));
  position_ = sheet_fusion_.flattened(edge_costs_.place(v, merged.best));
  if (allows(v, partner)) return true;
  const float most = std::min(kSlack * std::max(value_at(merged.reduced, merged.best), 1e-12F),
                              threshold_for(v, partner));
  for (const float t : kElsewhere) {
    const Offset u{t * merged.edge[0], t * merged.edge[1], t * merged.edge[2]};
    if (!(value_at(merged.reduced, u) <= most)) continue;
    position_ = sheet_fusion_.on_edge(t);
    if (allows(v, partner)) return true;
  }
  return false;
}

template auto FuseRound<float>::kind_on_sheet(VertexId) -> Kind;
template void FuseRound<float>::begin_sheets();
template void FuseRound<float>::find_partners_on_sheet(VertexId);
template bool FuseRound<float>::plan_on_sheet(VertexId, VertexId);
template auto FuseRound<double>::kind_on_sheet(VertexId) -> Kind;
template void FuseRound<double>::begin_sheets();
template void FuseRound<double>::find_partners_on_sheet(VertexId);
template bool FuseRound<double>::plan_on_sheet(VertexId, VertexId);

}  // namespace tetfusion
