#include "mesh/inspection/interface_inspection.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "mesh/inspection/inspect.h"
#include "mesh/inspection/surface.h"

namespace tetfusion {

namespace {

std::array<std::uint32_t, 2> ends_of(std::uint64_t edge) {
  return {static_cast<std::uint32_t>(edge >> 32), static_cast<std::uint32_t>(edge)};
}

std::size_t hash(VertexId id) { return std::size_t{id} * 0x9E3779B97F4A7C15u >> 32; }

// The same face begins with the same point, and then runs one way or the other.
std::array<std::uint32_t, 3> from_smallest(std::array<std::uint32_t, 3> face) {
  std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
  return face;
}

template <class T>
void append(const Vector<T>& from, Vector<T>* to) {
  to->insert(to->end(), from.begin(), from.end());
}

}  // namespace

std::uint32_t InterfaceInspection::find(VertexId id) const {
  if (slots_.empty()) return kNoVertex;
  for (std::size_t i = hash(id);; ++i) {
    const std::uint32_t number = slots_[i & (slots_.size() - 1)];
    if (number == kNoVertex || points_[number].id == id) return number;
  }
}

void InterfaceInspection::grow_slots() {
  slots_.assign(std::max<std::size_t>(1024, 2 * slots_.size()), kNoVertex);
  for (std::uint32_t number = 0; number < points_.size(); ++number) {
    std::size_t i = hash(points_[number].id);
    while (slots_[i & (slots_.size() - 1)] != kNoVertex) ++i;
    slots_[i & (slots_.size() - 1)] = number;
  }
}

std::uint32_t InterfaceInspection::find_or_add(VertexId id) {
  if (2 * (points_.size() + 1) > slots_.size()) grow_slots();
  for (std::size_t i = hash(id);; ++i) {
    std::uint32_t& number = slots_[i & (slots_.size() - 1)];
    if (number == kNoVertex) {
      number = static_cast<std::uint32_t>(points_.size());
      points_.push_back({id, 0, 0, false, false});
    }
    if (points_[number].id == id) return number;
  }
}

void InterfaceInspection::add(ChunkFindings* findings) {
  verdict_ += *findings;
  volume_.add(findings->volume);
  const InterfaceFindings from = std::move(findings->interface);
  findings->interface = {};
  const Vector<std::uint32_t> number = add_points(from);
  add_cells(from, number);
  for (Side side : from.sides) {
    for (std::uint32_t& p : side.face) p = number[p];
    side.face = from_smallest(side.face);
    if (side.cluster < InterfaceFindings::kPair) {
      side.cluster += static_cast<std::uint32_t>(clusters_.size() - from.clusters.size());
    }
    sides_.push_back(side);
  }
  for (const auto& [a, b] : from.edges) {
    edges_.push_back(edge_key(number[a], number[b]));
  }
  append(from.triangles, &triangles_);
  append(from.unsound_balls, &unsound_balls_);
  if (sides_.size() >= settle_at_) {
    settle(false);
    settle_at_ = std::max(least_to_settle_, 2 * sides_.size());
  }
}

// Returns the number of each.
Vector<std::uint32_t> InterfaceInspection::add_points(const InterfaceFindings& from) {
  Vector<std::uint32_t> number(from.points.size());
  for (std::size_t p = 0; p < number.size(); ++p) {
    number[p] = find_or_add(from.points[p].id);
    auto& point = points_[number[p]];
    if (point.is_last) {
      throw std::logic_error("a chunk has a point that an earlier one called kSharedLast");
    }
    point.sum += from.points[p].sum;
    point.flags |= from.points[p].flags;
    point.is_last = from.points[p].is_last;
    point.is_used |= from.points[p].is_used;
  }
  return number;
}

// Cells and clusters of them.
void InterfaceInspection::add_cells(const InterfaceFindings& from,
                                    const Vector<std::uint32_t>& number) {
  for (auto cell : from.cells) {
    for (std::uint32_t& p : cell) p = number[p];
    std::sort(cell.begin(), cell.end());
    cells_.push_back(cell);
  }
  const auto first = static_cast<std::uint32_t>(clusters_.size());
  for (Cluster cluster : from.clusters) {
    if (!from.cells_have_ids) cluster.first += cell_count_;
    clusters_.push_back(cluster);
  }
  joined_.grow(clusters_.size());
  for (const auto& [a, b] : from.folds) folds_.push_back({a + first, b + first});
  for (const auto& m : from.members) members_.push_back({m.cluster + first, m.id});
  cell_count_ += from.cell_count;
}

// Sets a flag that the vertex's chunk did not see a reason for.
void InterfaceInspection::mark(VertexId id, std::uint8_t flag) {
  const std::uint32_t number = find(id);
  if (number != kNoVertex) {
    points_[number].flags |= flag;
  } else {
    verdict_.overrides.push_back(id);
  }
}

InterfaceVerdict InterfaceInspection::finish() {
  settle(true);
  if (verdict_.foldover_faces > 0) find_inverted();
  judge_surface();
  judge_balls();
  write_points();
  verdict_.volume = volume_.value();
  return std::move(verdict_);
}

// Judges the faces and cells of which one point is the last time in a chunk: no other chunk has
// them.
void InterfaceInspection::settle(bool everything) {
  const auto is_settled = [&](const auto& points) {
    return everything || std::any_of(points.begin(), points.end(),
                                     [&](std::uint32_t p) { return points_[p].is_last; });
  };
  const auto cells_end = std::partition(cells_.begin(), cells_.end(), is_settled);
  settle_cells(static_cast<std::size_t>(cells_end - cells_.begin()));
  const auto sides_end = std::partition(sides_.begin(), sides_.end(),
                                        [&](const Side& side) { return is_settled(side.face); });
  settle_faces(static_cast<std::size_t>(sides_end - sides_.begin()));

  // Each pair of points once.
  std::sort(edges_.begin(), edges_.end());
  edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
  const auto edges_end = std::partition(
      edges_.begin(), edges_.end(), [&](std::uint64_t edge) { return is_settled(ends_of(edge)); });
  for (auto edge = edges_.begin(); edge != edges_end; ++edge) {
    for (const std::uint32_t p : ends_of(*edge)) points_[p].sum += 2;
  }
  edges_.erase(edges_.begin(), edges_end);
}

// The first so many of cells_.
void InterfaceInspection::settle_cells(std::size_t count) {
  const auto end = cells_.begin() + static_cast<std::ptrdiff_t>(count);
  std::sort(cells_.begin(), end);
  for (std::size_t i = 1; i < count; ++i) {
    if (cells_[i] != cells_[i - 1]) continue;
    ++verdict_.duplicate_tets;
    for (const std::uint32_t p : cells_[i]) points_[p].flags |= kBrokenVertex;
  }
  cells_.erase(cells_.begin(), end);
}

// The first so many of sides_.
void InterfaceInspection::settle_faces(std::size_t count) {
  const auto key = [](const Side& side) {
    return std::pair(std::uint64_t{side.face[0]} << 32 | std::min(side.face[1], side.face[2]),
                     std::max(side.face[1], side.face[2]));
  };
  const auto sides_end = sides_.begin() + static_cast<std::ptrdiff_t>(count);
  std::sort(sides_.begin(), sides_end,
            [&](const Side& a, const Side& b) { return key(a) < key(b); });
  for (std::size_t begin = 0, end; begin < count; begin = end) {
    const auto its_key = key(sides_[begin]);
    end = begin + 1;
    while (end < count && key(sides_[end]) == its_key) ++end;
    judge_face({sides_.data() + begin, end - begin});
    const auto [smallest, middle] = ends_of(its_key.first);
    edges_.push_back(its_key.first);
    edges_.push_back(edge_key(middle, its_key.second));
    edges_.push_back(edge_key(smallest, its_key.second));
  }
  sides_.erase(sides_.begin(), sides_end);
}

void InterfaceInspection::judge_face(std::span<const Side> sides) {
  const Side &a = sides[0], &b = sides[sides.size() - 1];
  const bool any_pair = std::any_of(sides.begin(), sides.end(), [](const Side& side) {
    return side.cluster == InterfaceFindings::kPair;
  });
  if (sides.size() == 1) {
    if (any_pair) return;
    ++verdict_.boundary_faces;
    faces_.push_back(a.face);
    for (const std::uint32_t p : a.face) points_[p].flags |= kBoundaryVertex;
  } else if (sides.size() > 2 || any_pair) {
    ++verdict_.overfull_faces;
    for (const std::uint32_t p : a.face) points_[p].flags |= kBrokenVertex;
  } else if (a.cluster != InterfaceFindings::kFlat && b.cluster != InterfaceFindings::kFlat) {
    if (a.face != b.face || a.apex == b.apex) {
      joined_.unite(a.cluster, b.cluster);
      return;
    }
    ++verdict_.foldover_faces;
    folds_.push_back({a.cluster, b.cluster});
    for (const std::uint32_t p : a.face) points_[p].flags |= kBrokenVertex;
    mark(a.apex, kBrokenVertex);
    mark(b.apex, kBrokenVertex);
  }
}

void InterfaceInspection::find_inverted() {
  for (std::uint32_t c = 0; c < clusters_.size(); ++c) {
    const std::uint32_t root = joined_.find(c);
    if (root == c) continue;  // the smallest of the set: the others are added to it
    clusters_[root].add(clusters_[c]);
    clusters_[c] = {};
  }
  for (auto& [a, b] : folds_) {
    a = joined_.find(a);
    b = joined_.find(b);
  }
  const Vector<std::uint8_t> inverted = find_inverted_clusters(clusters_, folds_);
  for (std::uint32_t c = 0; c < clusters_.size(); ++c) {
    if (inverted[c] == 0) continue;
    verdict_.inverted += clusters_[c].cells;
    verdict_.rewound -= clusters_[c].rewound;
  }
  for (const auto& member : members_) {
    const std::uint32_t root = joined_.find(member.cluster);
    if (inverted[root] != 0 && clusters_[root].cells <= kMaxBrokenCluster) {
      mark(member.id, kBrokenVertex);
    }
  }
}

// The points on the interface come first, then the free ones of the triangles.
void InterfaceInspection::judge_surface() {
  for (const Triangle& t : faces_) {
    verdict_.boundary.push_back({points_[t[0]].id, points_[t[1]].id, points_[t[2]].id});
  }
  Vector<VertexId> others;
  for (const Triangle& t : triangles_) {
    for (const VertexId id : t) {
      if (find(id) == kNoVertex) others.push_back(id);
    }
  }
  std::sort(others.begin(), others.end());
  others.erase(std::unique(others.begin(), others.end()), others.end());
  for (Triangle t : triangles_) {
    for (VertexId& id : t) {
      const std::uint32_t number = find(id);
      const auto other = std::lower_bound(others.begin(), others.end(), id) - others.begin();
      id = number != kNoVertex ? number : static_cast<VertexId>(points_.size() + other);
    }
    faces_.push_back(t);
  }
  Vector<std::uint8_t> foreign(points_.size(), 0);
  foreign.resize(points_.size() + others.size(), 1);
  const Surface surface = judge_surface_part({foreign, false}, faces_);
  verdict_.boundary_vertices += surface.vertices;
  verdict_.boundary_edges += surface.edges;
  verdict_.nonmanifold_edges += surface.nonmanifold_edges;
  verdict_.nonmanifold_vertices += surface.nonmanifold_vertices.size();
  for (const VertexId p : surface.nonmanifold_vertices) points_[p].flags |= kBrokenVertex;
  triangles_at_.resize(points_.size());
  for (std::size_t p = 0; p < points_.size(); ++p) {
    triangles_at_[p] = surface.offsets[p + 1] - surface.offsets[p];
  }
}

void InterfaceInspection::judge_balls() {
  for (std::size_t p = 0; p < points_.size(); ++p) {
    if ((points_[p].flags & kBrokenVertex) != 0) continue;
    if (!points_[p].is_used) {
      points_[p].flags |= kUnusedVertex;
      continue;
    }
    const auto triangles = static_cast<std::int32_t>(triangles_at_[p]);
    if (points_[p].sum == sum_of_sound_ball(triangles)) continue;
    points_[p].flags |= kBrokenVertex;
    ++verdict_.nonmanifold_vertices;
  }
  auto& overrides = verdict_.overrides;
  std::sort(overrides.begin(), overrides.end());
  overrides.erase(std::unique(overrides.begin(), overrides.end()), overrides.end());
  // Balls are judged only where nothing else is wrong.
  for (const VertexId id : unsound_balls_) {
    if (std::binary_search(overrides.begin(), overrides.end(), id)) --verdict_.nonmanifold_vertices;
  }
}

void InterfaceInspection::write_points() {
  std::sort(points_.begin(), points_.end(),
            [](const auto& a, const auto& b) { return a.id < b.id; });
  for (const auto& point : points_) {
    verdict_.ids.push_back(point.id);
    verdict_.flags.push_back(point.flags);
  }
}

}  // namespace tetfusion
