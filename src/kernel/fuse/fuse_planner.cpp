#include "kernel/fuse/fuse_planner.h"

#include <algorithm>
#include <array>

namespace tetfusion {

namespace {

// Where the best position is not allowed, others may cost so much more.
constexpr float kSlack = 1.3F;
// cheapest_step(): from 0.003 to 0.3 all does about the same.
constexpr float kPushPull = 0.01F;
// refit_position(): where a shape is in the way, half of the step, and again.
constexpr int kHalvings = 2;
// On the edge.
constexpr std::array<float, 3> kElsewhere{0.5F, 0.0F, 1.0F};

Offset along_edge(const MergedQuadric& merged, float t) {
  return {t * merged.edge[0], t * merged.edge[1], t * merged.edge[2]};
}

bool is_by_shape(Reject reason) { return reason == Reject::kFlip || reason == Reject::kQuality; }

}  // namespace

template <class Real>
void FusePlanner<Real>::begin(const FuseLimits& limits, std::span<const SteeringField> fields,
                              WorkMesh<Real>* mesh, FuseVertices<Real>* vertices,
                              EdgeCosts<Real>* edge_costs) {
  limits_ = &limits;
  mesh_ = mesh;
  vertices_ = vertices;
  edge_costs_ = edge_costs;
  cavity_.begin(mesh, &vertices->balls(), limits.min_quality, limits.unit);
  values_.begin(limits, fields, mesh, &vertices->balls(), edge_costs);
  thorough_ = limits.thorough;
  slides_ = 0;
  slid_ = 0;
  not_slid_ = 0;
  if (!limits.sheets_move()) return;
  sheet_fusion_.begin(
      mesh, &vertices->sheets(),
      {limits.unit,
       limits.max_deviation,
       {limits.deviation_before, limits.facing, &triangles_, values_.have_bounds()}});
  if (limits.facing == nullptr) return;
  triangles_.begin(*limits.facing);
  for (VertexId v = 0; v < mesh->vertex_count(); ++v) {
    vertices->sheets().note_facing(v, &triangles_);
  }
}

template <class Real>
auto FusePlanner<Real>::plan(VertexId v, VertexId partner, std::uint64_t most_deleted) -> Verdict {
  const bool fixed = (*vertices_)[partner].kind != (*vertices_)[v].kind;
  joining_ = {v, partner, fixed, {}, {}, {}};
  kept_ = fixed ? partner : std::min(v, partner);
  if (const Verdict refused =
          vertices_->is_on_sheet(v) ? find_position_on_sheet() : find_position()) {
    return refused;
  }
  if (cavity_.deleted().size() > most_deleted) return FuseRefusal{Reject::kQuota};
  if (!fixed && !values_.may_refuse()) values_.choose(joining_, merged_, cavity_);
  return std::nullopt;
}

// The best one, else pushed off what speaks against it, else on the edge.
template <class Real>
auto FusePlanner<Real>::find_position() -> Verdict {
  const auto& [v, partner, fixed, position, affected, deleted] = joining_;
  if (!fixed) edge_costs_->merge(v, partner, &merged_);
  Verdict refused =
      ask(fixed ? mesh_->positions[partner] : edge_costs_->position_at(v, merged_.best));
  if (!refused) return std::nullopt;
  const TetId obstacle = is_by_shape(refused->reason) ? cavity_.refused_by() : kNoTet;
  if (!fixed) {
    const float most = most_elsewhere();
    if (const auto pushed = push(refused->reason, most)) refused = ask(*pushed);
    if (!refused) return std::nullopt;
    // What is on the edge may be allowed another time, even if nothing has changed at the best.
    if (refused->dear == 0 && sliding_pays()) return slide(*refused, most);
  }
  refused->until_changed = obstacle;
  return refused;
}

// The best one, else on the edge. (To be pushed off a tetrahedron would lead off the sheet.)
template <class Real>
auto FusePlanner<Real>::find_position_on_sheet() -> Verdict {
  const auto& [v, partner, fixed, position, affected, deleted] = joining_;
  const Along along = vertices_->along(v);
  if (!sheet_fusion_.choose(v, partner, fixed, along)) return FuseRefusal{Reject::kSurface};
  if (fixed) return ask(mesh_->positions[partner]);
  edge_costs_->merge_on_sheet(v, partner, along, &merged_);
  Verdict refused = ask(sheet_fusion_.flattened(edge_costs_->position_at(v, merged_.best)));
  const float most = most_elsewhere();
  for (const float t : kElsewhere) {
    if (!refused) return std::nullopt;
    if (sheet_fusion_.may_never()) break;
    if (!(value_at(merged_.reduced, along_edge(merged_, t)) <= most)) continue;
    refused = ask(sheet_fusion_.on_edge(t));
  }
  return refused;
}

// Of a pair of whom both move: what they cost is the value of their merged quadric over this.
template <class Real>
float FusePlanner<Real>::weight() const {
  return vertices_->is_on_sheet(joining_.v) ? 1 : merged_.sum[kQuadricW];
}

// That value, where it is the largest that is still allowed at another position than the best.
template <class Real>
float FusePlanner<Real>::most_elsewhere() const {
  return std::min(kSlack * std::max(value_at(merged_.reduced, merged_.best), 1e-12F * weight()),
                  vertices_->threshold_for(joining_.v, joining_.partner) * weight());
}

// Off the tetrahedron that speaks against the position, by the way that costs least.
template <class Real>
std::optional<Vec3<Real>> FusePlanner<Real>::push(Reject reason, float most) const {
  if (!is_by_shape(reason)) return std::nullopt;
  const auto [direction, distance] = cavity_.obstacle();
  const Vec3<Real>& from = mesh_->positions[joining_.v];
  const Reduced& reduced = merged_.reduced;
  Offset u = edge_costs_->offset(from, joining_.position);
  const Offset step = cheapest_step(reduced, direction, distance, kPushPull);
  for (std::size_t i = 0; i < 3; ++i) u[i] += step[i];
  if (!(value_at(reduced, u) <= most)) return std::nullopt;
  return edge_costs_->position_at(joining_.v, u);
}

// Where little comes of it, as on a Delaunay mesh, only now and then, until the turns are over.
template <class Real>
bool FusePlanner<Real>::sliding_pays() {
  constexpr std::uint64_t kFirst = 1024, kWorth = 100, kNowAndThen = 8;
  return thorough_ || slides_ < kFirst + kWorth * slid_ || ++not_slid_ % kNowAndThen == 0;
}

// Along the edge, away from what speaks against a position; at its ends one of the two stays where
// it is, as suits layers and lattices. Else the refusal, which costs as much as the last of them.
template <class Real>
auto FusePlanner<Real>::slide(FuseRefusal refusal, float most) -> Verdict {
  for (const float t : kElsewhere) {
    const Offset u = along_edge(merged_, t);
    if (!(value_at(merged_.reduced, u) <= most)) continue;
    ++slides_;
    const Verdict refused = ask(edge_costs_->position_at(joining_.v, u));
    if (!refused) {
      ++slid_;
      return std::nullopt;
    }
    refusal.dear = refused->dear;
  }
  return refusal;
}

// May the two be one at this position?
template <class Real>
auto FusePlanner<Real>::ask(const Vec3<Real>& position) -> Verdict {
  joining_.position = position;
  const auto reason = cavity_.collect(joining_.v, joining_.partner, joining_.fixed, position);
  if (reason) return FuseRefusal{*reason};
  joining_.affected = cavity_.affected();
  joining_.deleted = cavity_.deleted();
  return judge();
}

// The same, of a cavity that keeps its shapes.
template <class Real>
auto FusePlanner<Real>::judge() -> Verdict {
  const auto& [v, partner, fixed, position, affected, deleted] = joining_;
  const bool on_sheet = vertices_->is_on_sheet(v);
  if (on_sheet && !sheet_fusion_.allows(position)) return FuseRefusal{Reject::kSurface};
  const float factor = vertices_->cost_factor(v, partner);
  if (const auto dear = values_.find_loss(joining_, merged_, cavity_, factor)) {
    return FuseRefusal{Reject::kError, *dear};
  }
  if (values_.may_refuse()) {
    if (const auto reason = values_.judge(joining_, merged_, cavity_)) return FuseRefusal{*reason};
  }
  // Round what is locked the mesh may be broken, and at the boundary it may overlap itself.
  const bool may_be_broken =
      fixed && !on_sheet && (mesh_->marks[partner] & (kLocked | kOnBoundary)) != 0;
  if (may_be_broken && !links_.are_apart(*mesh_, &vertices_->balls(), v, partner)) {
    return FuseRefusal{Reject::kLocked};
  }
  return std::nullopt;
}

template <class Real>
std::optional<Vec3<Real>> FusePlanner<Real>::refit_position(VertexId v) {
  std::optional<Vec3<Real>> position = values_.wished_position();
  if (!position) return std::nullopt;
  const Vec3<Real>& here = mesh_->positions[v];
  for (int i = 0; i <= kHalvings; ++i) {
    if (!cavity_.collect(v, kNoVertex, true, *position)) {
      kept_ = v;
      if (!values_.refit_at(*position, cavity_)) return std::nullopt;
      values_.apply_refit();
      return position;
    }
    *position = {(position->x + here.x) / 2, (position->y + here.y) / 2,
                 (position->z + here.z) / 2};
  }
  return std::nullopt;
}

template <class Real>
Interpolation FusePlanner<Real>::interpolation() const {
  Interpolation interpolation = values_.interpolation();
  interpolation.to = kept_;
  return interpolation;
}

template <class Real>
double FusePlanner<Real>::error(float cost) const {
  const auto& [v, partner, fixed, position, affected, deleted] = joining_;
  if (!fixed) {
    const Offset u = edge_costs_->offset(mesh_->positions[v], position);
    const float here = value_at(merged_.reduced, u) / weight() * vertices_->cost_factor(v, partner);
    cost = std::max(cost, here);
  }
  return values_.error(cost);
}

template <class Real>
void FusePlanner<Real>::apply() {
  values_.apply(kept_);
  if (!vertices_->is_on_sheet(joining_.v)) return;
  mesh_->deviations[kept_] = sheet_fusion_.deviation();
  sheet_fusion_.note_fused(kept_);
}

template class FusePlanner<float>;
template class FusePlanner<double>;

}  // namespace tetfusion
