#include "kernel/sheets/sheets.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <utility>

#include "kernel/point3.h"
#include "kernel/quadrics/quadric.h"
#include "kernel/sheets/feature_angle.h"
#include "mesh/faces.h"
#include "mesh/regions/region_numbers.h"

namespace tetfusion {

namespace {

// An edge that is bent by as much as the feature angle is sharp however its points are rounded.
constexpr double kRounding = 0.01;  // degrees

// Of the three faces at each corner, the other two corners: from outside the corner, from, to go
// round the right way.
constexpr auto kEdgesOpposite = [] {
  std::array<std::array<std::pair<std::uint8_t, std::uint8_t>, 3>, 4> edges{};
  for (std::size_t at = 0; at < 4; ++at) {
    std::size_t count = 0;
    for (const auto& face : kFaceCorners) {
      for (std::size_t i = 0; i < 3; ++i) {
        if (face[i] == at) edges[at][count++] = {face[(i + 1) % 3], face[(i + 2) % 3]};
      }
    }
  }
  return edges;
}();

// Numbers regions in the order in which they come up.
template <class Real>
void number_regions(const WorkMesh<Real>& mesh, std::span<const std::uint32_t> columns,
                    Vector<std::uint32_t>* regions) {
  regions->assign(mesh.tets.size(), 0);
  for (const std::uint32_t c : columns) {
    const Column& column = mesh.cell_columns[c];
    const Vector<std::uint64_t> keys = region_keys(column.type, column.rows);
    RegionNumbers numbers;
    for (std::size_t t = 0; t < keys.size(); ++t) {
      (*regions)[t] = numbers.number((*regions)[t], keys[t]);
    }
  }
}

}  // namespace

bool SheetFan::turn_to(VertexId u) {
  const auto at = std::find(ring.begin(), ring.end(), u);
  if (at == ring.end()) return false;
  std::rotate(sharp.begin(), sharp.begin() + (at - ring.begin()), sharp.end());
  std::rotate(ring.begin(), at, ring.end());
  return true;
}

template <class Real>
void Sheets<Real>::begin(const WorkMesh<Real>* mesh, LiveBalls* balls,
                         std::span<const std::uint32_t> region_columns, double feature_angle) {
  mesh_ = mesh;
  balls_ = balls;
  const auto cosine = [](double angle) {
    return std::cos(std::max(angle - kRounding, 0.0) / 180 * std::numbers::pi);
  };
  feature_cosine_ = cosine(feature_angle);
  line_cosine_ = cosine(std::min(feature_angle, kFeatureAngle));
  kept_fans_.resize(kKeptFans);
  for (KeptFan& kept : kept_fans_) kept.vertex = kNoVertex;
  region_.clear();
  mixed_.assign(mesh->vertex_count(), 0);
  if (region_columns.empty()) return;
  number_regions(*mesh, region_columns, &region_);
  Vector<std::uint32_t> first;
  first.assign(mesh->vertex_count(), kNoVertex);
  for (std::size_t t = 0; t < mesh->tets.size(); ++t) {
    for (const VertexId v : mesh->tets[t]) {
      if (first[v] == kNoVertex) first[v] = region_[t];
      if (first[v] != region_[t]) mixed_[v] = 1;
    }
  }
}

// Most faces have a corner that is on no sheet. Most others are there twice, with the same region
// on both sides: these find one another in a table of places by their keys. What is left is sorted.
template <class Real>
const std::vector<SheetEdge>& Sheets<Real>::edges_opposite(VertexId v) {
  faces_.clear();
  for (const std::uint32_t entry : balls_->of(v, mesh_->incidence[v], mesh_->tets)) {
    const Tet& tet = mesh_->tets[entry >> 2];
    std::array<bool, 4> may_be{};
    for (std::size_t i = 0; i < 4; ++i) may_be[i] = may_be_on_sheet(tet[i]);
    for (const auto& [from, to] : kEdgesOpposite[entry & 3u]) {
      if (!may_be[from] || !may_be[to]) continue;
      const SheetEdge edge{tet[from], tet[to], true};
      faces_.push_back({edge_key(edge.from, edge.to), edge, region_of(entry >> 2), true});
    }
  }
  const std::size_t places = std::bit_ceil(2 * faces_.size() + 1);
  table_.assign(places, kNoFace);
  for (std::uint32_t i = 0; i < faces_.size(); ++i) {
    Face& face = faces_[i];
    std::size_t place = (face.key * 0x9E3779B97F4A7C15u >> 32) & (places - 1);
    while (table_[place] != kNoFace && faces_[table_[place]].key != face.key) {
      place = (place + 1) & (places - 1);
    }
    const std::uint32_t other = std::exchange(table_[place], i);
    if (other == kNoFace || !faces_[other].open || faces_[other].region != face.region) continue;
    face.open = faces_[other].open = false;
  }
  std::erase_if(faces_, [](const Face& face) { return !face.open; });
  std::sort(faces_.begin(), faces_.end(), [](const Face& a, const Face& b) {
    return a.key != b.key ? a.key < b.key : a.region < b.region;
  });
  edges_.clear();
  for (std::size_t i = 0; i < faces_.size();) {
    const bool twice = i + 1 < faces_.size() && faces_[i + 1].key == faces_[i].key;
    if (!twice || faces_[i].region != faces_[i + 1].region) {
      edges_.push_back(faces_[i].edge);
      edges_.back().is_outer = !twice;
    }
    i += twice ? 2 : 1;
  }
  return edges_;
}

template <class Real>
template <class Note>
void Sheets<Real>::for_each_outer(VertexId v, Note note) {
  for (const SheetEdge& e : edges_opposite(v)) {
    if (e.is_outer && e.from > v && e.to > v) note(v, e.from, e.to);
  }
}

template <class Real>
void Sheets<Real>::note_facing(VertexId v, bool marks_are_known, FacingGrid* grid) {
  const std::uint8_t wanted = marks_are_known ? kOnBoundary : kOnBoundary | kOnInterface;
  const auto is_marked = [&](VertexId u) { return (mesh_->marks[u] & wanted) != 0; };
  if (!is_marked(v)) return;
  for_each_outer(v, [&](VertexId a, VertexId b, VertexId c) {
    if (is_marked(b) && is_marked(c)) grid->note(at(a), at(b), at(c));
  });
}

template <class Real>
void Sheets<Real>::note_facing(VertexId v, BoundaryTriangles* triangles) {
  if ((mesh_->marks[v] & kOnBoundary) == 0) return;
  for_each_outer(v, [&](VertexId a, VertexId b, VertexId c) {
    const auto all = mesh_->marks[a] & mesh_->marks[b] & mesh_->marks[c];
    if ((all & kOnBoundary) == 0 || (all & kOnInterface) != 0) return;
    triangles->note({a, b, c}, {at(a), at(b), at(c)});
  });
}

template <class Real>
bool Sheets<Real>::find_fan(VertexId v, SheetFan* fan) {
  KeptFan& kept = kept_fan(v);
  if (kept.vertex == v) return kept.give(fan);
  const bool is_one = look_for_fan(v, fan);
  kept.take(v, *fan, is_one);
  return is_one;
}

template <class Real>
void Sheets<Real>::KeptFan::take(VertexId v, const SheetFan& fan, bool is_one) {
  if (is_one && fan.size() > kLargestKept) return;
  vertex = v;
  size = is_one ? static_cast<std::uint32_t>(fan.size()) : 0;
  sharp = 0;
  for (std::uint32_t i = 0; i < size; ++i) {
    ring[i] = fan.ring[i];
    sharp |= std::uint32_t{fan.sharp[i]} << i;
  }
}

template <class Real>
bool Sheets<Real>::KeptFan::give(SheetFan* fan) const {
  fan->ring.assign(ring.begin(), ring.begin() + size);
  fan->sharp.resize(size);
  for (std::uint32_t i = 0; i < size; ++i) fan->sharp[i] = sharp >> i & 1u;
  fan->sharp_edges = static_cast<std::size_t>(std::popcount(sharp));
  return size > 0;
}

template <class Real>
bool Sheets<Real>::look_for_fan(VertexId v, SheetFan* fan) {
  edges_opposite(v);
  fan->ring.clear();
  if (edges_.size() < 3) return false;
  VertexId at = edges_[0].from;
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const auto leaves = [&](const SheetEdge& e) { return e.from == at; };
    const auto next = std::find_if(edges_.begin(), edges_.end(), leaves);
    if (next == edges_.end() || std::find_if(next + 1, edges_.end(), leaves) != edges_.end()) {
      return false;
    }
    if (i > 0 && at == fan->ring[0]) return false;  // a smaller round
    fan->ring.push_back(at);
    at = next->to;
  }
  if (at != fan->ring[0]) return false;
  mark_edges(v, fan);
  return true;
}

template <class Real>
void Sheets<Real>::mark_edges(VertexId v, SheetFan* fan) {
  const auto to = [&](VertexId u) {
    const Vec3<Real>&p = mesh_->positions[v], &q = mesh_->positions[u];
    return Point3{double{q.x} - p.x, double{q.y} - p.y, double{q.z} - p.z};
  };
  const std::size_t n = fan->size();
  bends_.resize(n);
  Point3 spoke = to(fan->ring[n - 1]);
  Point3 next = to(fan->ring[0]);
  Point3 before = cross(spoke, next);
  for (std::size_t i = 0; i < n; ++i) {
    spoke = next;
    next = to(fan->at(i + 1));
    const Point3 normal = cross(spoke, next);
    const double most = std::sqrt(dot(normal, normal)) * std::sqrt(dot(before, before));
    bends_[i] = dot(normal, before) / most;
    before = normal;
  }
  const auto mark = [&](double cosine) {
    fan->sharp.resize(n);
    for (std::size_t i = 0; i < n; ++i) fan->sharp[i] = bends_[i] > cosine ? 0 : 1;
    fan->sharp_edges = static_cast<std::size_t>(std::ranges::count(fan->sharp, 1));
  };
  mark(line_cosine_);
  if (feature_cosine_ == line_cosine_) return;
  if (fan->sharp_edges == 2) {
    const auto first = std::ranges::find(fan->sharp, 1) - fan->sharp.begin();
    const auto last = std::ranges::find(fan->sharp.rbegin(), fan->sharp.rend(), 1);
    const Point3 a = to(fan->ring[static_cast<std::size_t>(first)]);
    const Point3 b = to(fan->ring[static_cast<std::size_t>(fan->sharp.rend() - last - 1)]);
    if (dot(a, b) < -line_cosine_ * std::sqrt(dot(a, a)) * std::sqrt(dot(b, b))) return;
  }
  mark(feature_cosine_);
}

template <class Real>
SheetFeature Sheets<Real>::feature(VertexId v) {
  if ((mesh_->marks[v] & kOnBoundary) == 0 && !is_between_regions(v)) return SheetFeature::kNone;
  if (!find_fan(v, &fan_) || fan_.sharp_edges == 1 || fan_.sharp_edges > 2) {
    return SheetFeature::kCorner;
  }
  return fan_.sharp_edges == 2 ? SheetFeature::kLine : SheetFeature::kSmooth;
}

template <class Real>
void Sheets<Real>::add_planes(VertexId v, double unit, float* quadric) {
  const auto to = [&](VertexId u) {
    const Vec3<Real>&p = mesh_->positions[v], &q = mesh_->positions[u];
    return Point3{(double{q.x} - p.x) * unit, (double{q.y} - p.y) * unit,
                  (double{q.z} - p.z) * unit};
  };
  for (const SheetEdge& e : edges_opposite(v)) {
    const Point3 normal = cross(to(e.from), to(e.to));  // as long as twice the area
    const double length = std::sqrt(dot(normal, normal));
    if (!(length > 0)) continue;
    std::size_t at = kQuadricA;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = i; k < 3; ++k) {
        quadric[at++] += static_cast<float>(normal[i] * normal[k] / length);
      }
    }
    quadric[kQuadricW] += static_cast<float>(length);
  }
}

template <class Real>
bool Sheets<Real>::may_contract(VertexId a, const SheetFan& fan, VertexId b,
                                const SheetFan* other) {
  if (!links_.are_apart(*mesh_, balls_, a, b)) return false;
  if (other == nullptr) {
    const auto& edges = edges_opposite(b);
    return may_contract_on_sheet(fan, [&](const auto& is_it) {
      return std::ranges::any_of(edges, [&](const SheetEdge& e) { return is_it(e.from, e.to); });
    });
  }
  return may_contract_on_sheet(fan, [&](const auto& is_it) {
    for (std::size_t i = 0; i < other->size(); ++i) {
      if (is_it(other->ring[i], other->at(i + 1))) return true;
    }
    return false;
  });
}

// On the sheet the link of the edge is two vertices.
template <class Real>
template <class AnyEdge>
bool Sheets<Real>::may_contract_on_sheet(const SheetFan& fan, const AnyEdge& any_edge_of_other) {
  // Triangles that a and b have over the same edge would fall together.
  for (std::size_t i = 0; i < fan.size(); ++i) {
    const VertexId from = fan.ring[i], to = fan.at(i + 1);
    const auto is_over_it = [&](VertexId p, VertexId q) {
      return (p == from && q == to) || (p == to && q == from);
    };
    if (any_edge_of_other(is_over_it)) return false;
  }
  return std::ranges::count_if(fan.ring, [&](VertexId u) {
           return any_edge_of_other([&](VertexId p, VertexId q) { return p == u || q == u; });
         }) == 2;
}

template class Sheets<float>;
template class Sheets<double>;

}  // namespace tetfusion
