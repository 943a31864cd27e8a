#include "kernel/sheets/near_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernel/criteria.h"
#include "kernel/sheets/local_frame.h"
#include "kernel/sheets/patch_distance.h"

namespace tetfusion {

namespace {

// As many times as far as a point is from the surface, nothing may be but what has a corner of its
// own triangle. What could come nearer later on lies within twice that; the rest is for slopes.
constexpr double kClear = 3;
// What differs by less, as a share of a distance, is the same: whoever looks for what is nearest
// may find either.
constexpr double kTie = 1e-6;

Point3 weighted(const std::array<Point3, 3>& p, const std::array<double, 3>& w) {
  Point3 sum{};
  for (std::size_t k = 0; k < 3; ++k) sum[k] = w[0] * p[0][k] + w[1] * p[1][k] + w[2] * p[2][k];
  return sum;
}

double squared(const Point3& d) { return dot(d, d); }

double to_segment(const Point3& x, const Point3& from, const Point3& to) {
  return squared(minus(x, nearest_on_segment(x, from, to)));
}

template <class Face>
bool share_corner(const Face& a, const Face& b) {
  return std::any_of(a.ids.begin(), a.ids.end(), [&](VertexId v) {
    return std::find(b.ids.begin(), b.ids.end(), v) != b.ids.end();
  });
}

}  // namespace

NearestOnTriangle3 nearest_on(const Point3& x, const std::array<Point3, 3>& corners) {
  const std::array<Point3, 3> around{minus(corners[0], x), minus(corners[1], x),
                                     minus(corners[2], x)};
  NearestOnTriangle3 best;
  const auto take = [&](const std::array<double, 3>& weights) {
    const Point3 off = weighted(around, weights);
    return NearestOnTriangle3{weights, {x[0] + off[0], x[1] + off[1], x[2] + off[2]}, squared(off)};
  };
  const Point3 normal = cross(minus(around[1], around[0]), minus(around[2], around[0]));
  const double area = dot(normal, normal);
  if (area > 0) {
    const double w0 = dot(normal, cross(around[1], around[2])) / area;
    const double w1 = dot(normal, cross(around[2], around[0])) / area;
    const double w2 = 1 - w0 - w1;
    if (w0 >= 0 && w1 >= 0 && w2 >= 0) return take({w0, w1, w2});
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const Point3 edge = minus(around[j], around[i]);
    const double length = dot(edge, edge);
    const double along = length > 0 ? std::clamp(-dot(around[i], edge) / length, 0.0, 1.0) : 0;
    std::array<double, 3> weights{};
    weights[i] = 1 - along;
    weights[j] = along;
    const NearestOnTriangle3 found = take(weights);
    if (i == 0 || found.squared < best.squared) best = found;
  }
  return best;
}

template <class Real>
void NearSurface<Real>::begin(const WorkMesh<Real>* mesh, LiveBalls* balls, double unit,
                              double max_deviation) {
  mesh_ = mesh;
  balls_ = balls;
  unit_ = unit;
  may_move_ = max_deviation > kOnSurface;
  joining_ = {};
  if (may_move_) stamp_.assign(mesh->vertex_count(), 0);
  stamped_ = 0;
}

template <class Real>
Point3 NearSurface<Real>::about_v(const Vec3<Real>& p) const {
  return LocalFrame<Real>{mesh_->positions[joining_.v], unit_}.local(p);
}

template <class Real>
void NearSurface<Real>::set(const Joining<Real>& joining) {
  if (joining.v != joining_.v || joining.partner != joining_.partner ||
      joining.fixed != joining_.fixed) {
    ring_known_ = false;
  }
  joining_ = joining;
  apex_ = joining.fixed ? joining.partner : joining.v;
  moves_ = may_move_ && is_on(joining.v);
  faces_known_ = false;
}

template <class Real>
bool NearSurface<Real>::is_in_cavity(const Tet& tet) const {
  return std::any_of(tet.begin(), tet.end(), [&](VertexId v) {
    return v == joining_.v || (v == joining_.partner && !joining_.fixed);
  });
}

// All faces whose corners lie on the boundary, of the affected tetrahedra and of those that come
// next to it.
template <class Real>
void NearSurface<Real>::know_faces() {
  if (faces_known_) return;
  faces_known_ = true;
  faces_.clear();
  outline_.clear();
  const bool apex_is_on = is_on(apex_);
  const Point3 apex = about_v(joining_.position);
  for (std::uint32_t i = 0; i < joining_.affected.size(); ++i) {
    const std::uint32_t entry = joining_.affected[i];
    const Tet& tet = mesh_->tets[entry >> 2];
    const auto& order = kCornerFirst[entry & 3u];
    std::array<VertexId, 4> ids{apex_, tet[order[1]], tet[order[2]], tet[order[3]]};
    std::array<bool, 4> on{apex_is_on, is_on(ids[1]), is_on(ids[2]), is_on(ids[3])};
    if (std::count(on.begin(), on.end(), true) < 3) continue;
    std::array<Point3, 4> at{apex, about_v(mesh_->positions[ids[1]]),
                             about_v(mesh_->positions[ids[2]]), about_v(mesh_->positions[ids[3]])};
    for (std::uint8_t k = 0; k < 4; ++k) {
      const std::array<std::size_t, 3> c{k == 0 ? 1u : 0u, k <= 1 ? 2u : 1u, k <= 2 ? 3u : 2u};
      if (!on[c[0]] || !on[c[1]] || !on[c[2]]) continue;
      faces_.push_back(
          {{ids[c[0]], ids[c[1]], ids[c[2]]}, {at[c[0]], at[c[1]], at[c[2]]}, entry >> 2, i, k});
      if (k != 0) outline_.push_back({at[c[1]], at[c[2]]});
    }
  }
  if (joining_.fixed && apex_is_on) know_faces_behind();
}

// Where a tetrahedron goes that has a face on the boundary with v, the one behind it comes to the
// surface: one of the partner's that stays as it is.
template <class Real>
void NearSurface<Real>::know_faces_behind() {
  const auto ball = balls_->of(apex_, mesh_->incidence[apex_], mesh_->tets);
  for (const TetId gone : joining_.deleted) {
    std::array<VertexId, 3> ids{apex_, kNoVertex, kNoVertex};
    std::size_t n = 1;
    for (const VertexId u : mesh_->tets[gone]) {
      if (u != joining_.v && u != apex_) ids[n++] = u;
    }
    if (!is_on(ids[1]) || !is_on(ids[2])) continue;
    const auto behind = std::find_if(ball.begin(), ball.end(), [&](std::uint32_t entry) {
      const Tet& tet = mesh_->tets[entry >> 2];
      return has_corner(tet, ids[1]) && has_corner(tet, ids[2]) && !has_corner(tet, joining_.v);
    });
    if (behind == ball.end()) continue;
    const std::array<Point3, 3> at{about_v(joining_.position), about_v(mesh_->positions[ids[1]]),
                                   about_v(mesh_->positions[ids[2]])};
    constexpr std::uint8_t kNotTheNewVertex = 1;
    faces_.push_back({ids, at, *behind >> 2, kUnaffected, kNotTheNewVertex});
    outline_.push_back({at[1], at[2]});
  }
}

template <class Real>
bool NearSurface<Real>::know_neighbours() {
  know_faces();
  if (ring_known_) return ring_is_whole_;
  ring_known_ = true;
  ring_faces_.clear();
  ring_tets_.clear();
  ring_outline_.clear();
  find_ring();
  ring_is_whole_ = std::none_of(ring_.begin(), ring_.end(),
                                [&](VertexId u) { return (mesh_->marks[u] & kOnInterface) != 0; });
  if (!ring_is_whole_) return false;
  for (const VertexId u : ring_) collect_ring(u);
  return true;
}

template <class Real>
void NearSurface<Real>::find_ring() {
  ring_.clear();
  ++stamped_;
  const auto add = [&](VertexId u) {
    if (stamp_[u] == stamped_) return;
    stamp_[u] = stamped_;
    ring_.push_back(u);
  };
  if (joining_.fixed) add(joining_.partner);
  for (const Face& face : faces_) {
    if (face.omitted == 0) continue;
    for (const VertexId u : face.ids) {
      if (u != joining_.v) add(u);
    }
  }
}

// Faces round a vertex of the ring, of tetrahedra that stay as they are, once for all vertices.
template <class Real>
void NearSurface<Real>::collect_ring(VertexId u) {
  for (const std::uint32_t entry : balls_->of(u, mesh_->incidence[u], mesh_->tets)) {
    const Tet& tet = mesh_->tets[entry >> 2];
    const auto first =
        std::find_if(tet.begin(), tet.end(), [&](VertexId v) { return stamp_[v] == stamped_; });
    if (*first != u || is_in_cavity(tet)) continue;
    const std::size_t before = ring_faces_.size();
    for (std::uint8_t k = 0; k < 4; ++k) note_ring_face(tet, entry >> 2, k);
    if (ring_faces_.size() > before) ring_tets_.push_back(entry >> 2);
  }
}

template <class Real>
void NearSurface<Real>::note_ring_face(const Tet& tet, TetId t, std::uint8_t omitted) {
  Face face{{}, {}, t, kUnaffected, omitted};
  std::size_t n = 0;
  std::array<std::size_t, 3> others{};
  std::size_t outer = 0;
  for (std::size_t c = 0; c < 4; ++c) {
    if (c == omitted) continue;
    if (!is_on(tet[c])) return;
    if (stamp_[tet[c]] != stamped_) others[outer++] = n;
    face.ids[n] = tet[c];
    face.at[n++] = about_v(mesh_->positions[tet[c]]);
  }
  if (outer == 3) return;
  if (outer == 2) ring_outline_.push_back({face.at[others[0]], face.at[others[1]]});
  ring_faces_.push_back(face);
}

template <class Real>
void NearSurface<Real>::look_at(const Point3& x, const std::vector<Face>& faces,
                                std::vector<Hit>* hits) const {
  const auto most = [&] { return (1 + 2 * kTie) * hits->front().nearest.squared; };
  for (const Face& face : faces) {
    const Hit hit{&face, nearest_on(x, face.at)};
    if (!hits->empty() && hit.nearest.squared > most()) continue;
    hits->push_back(hit);
    if (hit.nearest.squared < hits->front().nearest.squared) {
      std::swap(hits->front(), hits->back());
    }
  }
  if (hits->empty()) return;
  std::erase_if(*hits, [limit = most()](const Hit& hit) { return hit.nearest.squared > limit; });
}

template <class Real>
double NearSurface<Real>::find(const Vec3<Real>& p, std::vector<Hit>* hits) {
  know_faces();
  hits->clear();
  look_at(about_v(p), faces_, hits);
  if (hits->empty()) return std::numeric_limits<double>::infinity();
  return hits->front().nearest.squared;
}

// Where the surface stays, what was nearest is so still.
template <class Real>
bool NearSurface<Real>::settle(const Vec3<Real>& p, std::vector<Hit>* hits) {
  if (!moves_) return !hits->empty();
  const auto is_inner = [](const Hit& hit) { return hit.face->omitted != 0; };
  const auto within = [&](const Hit& hit) { return is_inner(hit) && is_within(hit); };
  if (!hits->empty() && std::all_of(hits->begin(), hits->end(), within)) return true;
  if (!know_neighbours()) return false;
  look_at(about_v(p), ring_faces_, hits);
  return !hits->empty() &&
         std::all_of(hits->begin(), hits->end(), [&](const Hit& hit) { return is_clear(hit); });
}

// The place is on the patch, or beyond it, and not near its outline.
template <class Real>
bool NearSurface<Real>::is_within(const Hit& hit) const {
  const double reach = kClear * kClear * hit.nearest.squared;
  return std::all_of(outline_.begin(), outline_.end(), [&](const Segment& s) {
    return to_segment(hit.nearest.at, s.from, s.to) > reach;
  });
}

// Nothing is near the place but what shares a corner with its triangle.
template <class Real>
bool NearSurface<Real>::is_clear(const Hit& hit) const {
  const Point3& q = hit.nearest.at;
  const double reach = kClear * kClear * hit.nearest.squared;
  const auto is_harmless = [&](const Face& face) {
    return share_corner(face, *hit.face) || nearest_on(q, face.at).squared > reach;
  };
  return std::all_of(ring_outline_.begin(), ring_outline_.end(),
                     [&](const Segment& s) { return to_segment(q, s.from, s.to) > reach; }) &&
         std::all_of(faces_.begin(), faces_.end(), is_harmless) &&
         std::all_of(ring_faces_.begin(), ring_faces_.end(), is_harmless);
}

template <class Real>
bool NearSurface<Real>::is_inside(TetId t, const Vec3<Real>& p) const {
  const Tet& tet = mesh_->tets[t];
  const auto& at = mesh_->positions;
  return std::none_of(kCornerFirst.begin(), kCornerFirst.end(), [&](const auto& order) {
    const Determinant d = determinant(p, at[tet[order[1]]], at[tet[order[2]]], at[tet[order[3]]]);
    return d.value < -d.error;
  });
}

template <class Real>
bool NearSurface<Real>::spares(TetId neighbour, const Vec3<Real>& p) const {
  if (is_inside(neighbour, p)) return true;
  const Point3 x = about_v(p);
  Hit home{nullptr, {}};
  for (const Face& face : ring_faces_) {
    if (face.tet != neighbour) continue;
    const Hit hit{&face, nearest_on(x, face.at)};
    if (home.face == nullptr || hit.nearest.squared < home.nearest.squared) home = hit;
  }
  const double near = home.nearest.squared;
  if (near <= kOnSurface * kOnSurface) return true;
  return std::all_of(faces_.begin(), faces_.end(), [&](const Face& face) {
    const NearestOnTriangle3 other = nearest_on(x, face.at);
    const bool is_further = other.squared > (1 + 2 * kTie) * near ||
                            squared(minus(other.at, home.nearest.at)) <= kTie * kTie * near;
    return is_further && (share_corner(face, *home.face) ||
                          nearest_on(home.nearest.at, face.at).squared > kClear * kClear * near);
  });
}

template class NearSurface<float>;
template class NearSurface<double>;

}  // namespace tetfusion
