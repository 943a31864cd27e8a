#include "mesh/inspection/chunk_inspection.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "base/sums.h"
#include "base/union_find.h"
#include "mesh/faces.h"
#include "mesh/inspection/cell_states.h"
#include "mesh/inspection/inspect.h"
#include "mesh/inspection/surface.h"

namespace tetfusion {

namespace {

class ChunkInspector {
 public:
  ChunkInspector(const ChunkToInspect& chunk, Vector<Tet>* tets) : chunk_(chunk), tets_(tets) {}

  ChunkFindings run() {
    out_.vertex_flags.assign(points(), 0);
    sums_.assign(points(), 0);
    judge_cells();
    number_interface();
    judge_faces();
    judge_surface();
    regular_ = is_regular();
    find_clusters();
    if (!regular_) judge_balls();
    report();
    return std::move(out_);
  }

 private:
  std::size_t points() const { return chunk_.point_ids.size(); }
  bool is_free(VertexId v) const { return chunk_.on_interface[v] == kOwn; }
  void mark_cell(TetId t, std::uint8_t flag) {
    for (const VertexId v : (*tets_)[t]) out_.vertex_flags[v] |= flag;
  }

  void judge_cells();
  void number_interface();
  void judge_faces();
  void judge_free_star(VertexId v);
  void judge_interface_star(VertexId v);
  void judge_star_slowly(VertexId v);
  void judge_free_face(VertexId v, std::span<const FaceSide> sides);
  void judge_interface_face(VertexId v, std::span<const FaceSide> sides);
  void find_duplicates(std::span<const FaceSide> sides);
  void add_boundary(const Triangle& t);
  void add_side(const Triangle& t, TetId cell, VertexId apex);
  void add_pair(const Triangle& t, TetId a, TetId b);
  void find_neighbours();
  std::uint32_t element_of(TetId t) const;
  std::uint32_t cluster_of(TetId t);
  void count_clusters();
  void find_clusters();
  void report_clusters(const Vector<Fold>& folds, const Vector<std::uint8_t>& open);
  void judge_surface();
  bool ball_is_sound(VertexId v) const;
  bool is_regular() const;
  void judge_balls();
  void report();

  const ChunkToInspect& chunk_;
  Vector<Tet>* const tets_;
  ChunkFindings out_;
  bool regular_ = true;  // see is_regular()
  CellStates states_;
  FaceMatcher matcher_;
  Vector<std::uint32_t> interface_number_;
  Vector<std::int32_t> sums_;  // of each vertex: twice its neighbours, less its cells
  Vector<Triangle> boundary_;
  Vector<std::uint32_t> boundary_at_;   // as in Surface::offsets
  Vector<std::array<TetId, 2>> pairs_;  // neighbours
  Vector<std::array<TetId, 2>> folds_;
  Vector<TetId> open_;                // cells with a side that others may share
  DisjointSets sets_;                 // of what stands for cells: points, and after them cells
  Vector<std::uint32_t> cluster_at_;  // the cluster's number, at the root of its set
  Vector<Cluster> clusters_;
};

void ChunkInspector::judge_cells() {
  states_.resize(tets_->size());
  CompensatedSum six_volumes;
  const auto judge = [&](const auto& p) {
    for (TetId t = 0; t < tets_->size(); ++t) {
      const double six_volume = states_.judge(p, t, &(*tets_)[t]);
      if (states_.has_volume(t)) {
        six_volumes.add(six_volume);
        out_.rewound += states_.is_rewound(t) ? 1 : 0;
      } else {
        ++out_.degenerate;
        mark_cell(t, kBrokenVertex);
      }
    }
  };
  std::visit(judge, *chunk_.points);
  out_.volume = six_volumes.value() / 6;
}

void ChunkInspector::number_interface() {
  interface_number_.resize(points());
  for (std::size_t v = 0; v < points(); ++v) {
    if (chunk_.on_interface[v] == kOwn) continue;
    interface_number_[v] = static_cast<std::uint32_t>(out_.interface.points.size());
    out_.interface.points.push_back(
        {chunk_.point_ids[v], 0, 0, chunk_.on_interface[v] == kSharedLast, false});
  }
}

void ChunkInspector::judge_faces() {
  matcher_.load(*tets_, {}, 0, static_cast<VertexId>(points()), points());
  sets_.reset(points() + tets_->size());
  for (VertexId v = 0; v < points(); ++v) {
    sums_[v] -= static_cast<std::int32_t>(matcher_.cell_count(v));
    // A cell without volume may be wound either way, and may not be matched for what it is.
    if ((out_.vertex_flags[v] & kBrokenVertex) != 0 || !matcher_.match(v)) {
      judge_star_slowly(v);
    } else if (is_free(v)) {
      judge_free_star(v);
    } else {
      judge_interface_star(v);
    }
  }
}

void ChunkInspector::judge_free_star(VertexId v) {
  matcher_.for_each_single([&](VertexId m, VertexId l) { add_boundary({v, m, l}); });
  const auto neighbours = matcher_.neighbours();
  sums_[v] += 2 * static_cast<std::int32_t>(neighbours.size());
  std::uint32_t root = sets_.find(v);
  for (const VertexId w : neighbours) {
    sums_[w] += 2;
    if (is_free(w)) root = sets_.unite_root(root, w);
  }
}

void ChunkInspector::judge_interface_star(VertexId v) {
  std::uint64_t shared = 0;  // neighbours on the interface too
  const auto neighbours = matcher_.neighbours();
  for (std::size_t i = 0; i < neighbours.size(); ++i) {
    const VertexId w = neighbours[i];
    if (is_free(w)) {
      sums_[v] += 2;
      sums_[w] += 2;
    } else {
      shared |= std::uint64_t{1} << i;
    }
  }
  matcher_.for_each_single([&](VertexId m, VertexId l) {
    if (is_free(m) || is_free(l)) return add_boundary({v, m, l});
    matcher_.for_each_cell_of_face(v, m, l, [&](TetId t, VertexId apex) {
      add_side({v, m, l}, t, apex);
    });
  });
  if (shared == 0) return;
  matcher_.for_each_pair(shared, [&](VertexId m, VertexId l) {
    std::array<TetId, 2> cells{};
    std::size_t n = 0;
    matcher_.for_each_cell_of_face(v, m, l, [&](TetId t, VertexId) { cells[n++] = t; });
    add_pair({v, m, l}, cells[0], cells[1]);
  });
  std::uint64_t on_faces = 0;  // neighbours with which v shares a face that lies on the interface
  matcher_.for_each_cell(v, [&](TetId, const Tet& t) {
    std::uint32_t on_interface = 0;
    for (const VertexId w : t) on_interface += is_free(w) ? 0 : 1;
    if (on_interface < 3) return;
    for (const VertexId w : t) {
      if (w > v && !is_free(w)) on_faces |= std::uint64_t{1} << matcher_.number_of(w);
    }
    if (on_interface == 4 && t[0] == v) {
      out_.interface.cells.push_back({interface_number_[t[0]], interface_number_[t[1]],
                                      interface_number_[t[2]], interface_number_[t[3]]});
    }
  });
  for (std::size_t i = 0; i < neighbours.size(); ++i) {
    if (((shared & ~on_faces) >> i & 1) != 0) {
      out_.interface.edges.push_back({interface_number_[v], interface_number_[neighbours[i]]});
    }
  }
}

void ChunkInspector::judge_star_slowly(VertexId v) {
  matcher_.for_each_face(v, [&](std::span<const FaceSide> sides) {
    if (is_free(v) || is_free(sides[0].middle()) || is_free(sides[0].largest())) {
      judge_free_face(v, sides);
    } else {
      judge_interface_face(v, sides);
    }
  });
  for (const VertexId w : matcher_.larger_neighbours(v)) {
    if (is_free(v) || is_free(w)) {
      sums_[v] += 2;
      sums_[w] += 2;
    } else {
      out_.interface.edges.push_back({interface_number_[v], interface_number_[w]});
    }
    if (is_free(v) && is_free(w)) sets_.unite_root(sets_.find(v), w);
  }
  if (is_free(v)) return;
  matcher_.for_each_cell(v, [&](TetId, const Tet& t) {
    if (t[0] != v || is_free(t[1]) || is_free(t[2]) || is_free(t[3])) return;
    out_.interface.cells.push_back({interface_number_[t[0]], interface_number_[t[1]],
                                    interface_number_[t[2]], interface_number_[t[3]]});
  });
}

// Wound outwards, and with a free vertex, so that no other chunk knows of it.
void ChunkInspector::add_boundary(const Triangle& t) {
  for (const VertexId w : t) out_.vertex_flags[w] |= kBoundaryVertex;
  boundary_.push_back(t);
  ++out_.boundary_faces;
}

void ChunkInspector::add_side(const Triangle& t, TetId cell, VertexId apex) {
  out_.interface.sides.push_back(
      {{interface_number_[t[0]], interface_number_[t[1]], interface_number_[t[2]]},
       chunk_.point_ids[apex],
       states_.has_volume(cell) ? cell : InterfaceFindings::kFlat});
  if (states_.has_volume(cell)) open_.push_back(cell);
}

void ChunkInspector::add_pair(const Triangle& t, TetId a, TetId b) {
  out_.interface.sides.push_back(
      {{interface_number_[t[0]], interface_number_[t[1]], interface_number_[t[2]]},
       kNoVertex,
       InterfaceFindings::kPair});
  if (states_.has_volume(a) && states_.has_volume(b)) pairs_.push_back({a, b});
}

// Duplicates have the same vertices: if one is free, they are all here.
void ChunkInspector::find_duplicates(std::span<const FaceSide> sides) {
  for_each_copy(sides, [&](TetId t) {
    const Tet& tet = (*tets_)[t];
    if (std::none_of(tet.begin(), tet.end(), [&](VertexId v) { return is_free(v); })) return;
    ++out_.duplicate_tets;
    mark_cell(t, kBrokenVertex);
  });
}

void ChunkInspector::judge_free_face(VertexId v, std::span<const FaceSide> sides) {
  Triangle face{v, sides[0].middle(), sides[0].largest()};
  if (sides.size() == 1) {
    if (sides[0].odd != 0) std::swap(face[1], face[2]);
    return add_boundary(face);
  }
  find_duplicates(sides);
  if (sides.size() > 2) {
    ++out_.overfull_faces;
    for (const VertexId w : face) out_.vertex_flags[w] |= kBrokenVertex;
  } else if (states_.fold(sides[0], sides[1])) {
    ++out_.foldover_faces;
    mark_cell(sides[0].tet, kBrokenVertex);
    mark_cell(sides[1].tet, kBrokenVertex);
  }
}

void ChunkInspector::judge_interface_face(VertexId v, std::span<const FaceSide> sides) {
  const Triangle face{v, sides[0].middle(), sides[0].largest()};
  find_duplicates(sides);
  if (sides.size() == 2 && sides[0].odd != sides[1].odd) {
    return add_pair(face, sides[0].tet, sides[1].tet);
  }
  for (const FaceSide& side : sides) {
    Triangle wound = face;
    if (side.odd != 0) std::swap(wound[1], wound[2]);
    add_side(wound, side.tet, side.apex);
  }
}

// All neighbours and all folds, of cells that have volume.
void ChunkInspector::find_neighbours() {
  pairs_.clear();
  for (VertexId v = 0; v < points(); ++v) {
    matcher_.for_each_face(v, [&](std::span<const FaceSide> sides) {
      if (sides.size() != 2) return;
      const FaceSide &a = sides[0], &b = sides[1];
      if (!states_.has_volume(a.tet) || !states_.has_volume(b.tet)) return;
      const bool is_shared = !is_free(v) && !is_free(a.middle()) && !is_free(a.largest());
      if (is_shared && a.odd == b.odd) return;
      (states_.fold(a, b) ? folds_ : pairs_).push_back({a.tet, b.tet});
    });
  }
}

// What stands for the cell in sets_.
std::uint32_t ChunkInspector::element_of(TetId t) const {
  if (regular_) {
    for (const VertexId v : (*tets_)[t]) {
      if (is_free(v)) return v;
    }
  }
  return static_cast<std::uint32_t>(points()) + t;
}

std::uint32_t ChunkInspector::cluster_of(TetId t) { return cluster_at_[sets_.find(element_of(t))]; }

// Numbers the sets of cells, and sums them up.
void ChunkInspector::count_clusters() {
  cluster_at_.assign(points() + tets_->size(), kNoVertex);
  clusters_.clear();
  // Most cells are of the cluster of the cell before.
  std::uint32_t root = kNoVertex;
  Cluster sum;
  const auto add_sum = [&] {
    if (root != kNoVertex) clusters_[cluster_at_[root]].add(sum);
    sum = {};
  };
  for (TetId t = 0; t < tets_->size(); ++t) {
    const std::uint32_t its_root = sets_.find(element_of(t));
    if (its_root != root) {
      add_sum();
      root = its_root;
      if (cluster_at_[root] == kNoVertex) {
        cluster_at_[root] = static_cast<std::uint32_t>(clusters_.size());
        clusters_.push_back({});
      }
    }
    const std::uint64_t id = chunk_.cell_ids.empty() ? t : chunk_.cell_ids[t];
    sum.add({1, states_.is_rewound(t) ? 1u : 0u, id});
  }
  add_sum();
}

void ChunkInspector::find_clusters() {
  if (!regular_) {
    sets_.reset(points() + tets_->size());
    find_neighbours();
  }
  for (const auto& [a, b] : pairs_) sets_.unite(element_of(a), element_of(b));
  count_clusters();
  Vector<Fold> folds;
  UnionFind groups(clusters_.size());  // of clusters that are folded to each other
  for (const auto& [a, b] : folds_) {
    folds.push_back({cluster_of(a), cluster_of(b)});
    groups.unite(folds.back()[0], folds.back()[1]);
  }
  Vector<std::uint8_t> open(clusters_.size(), 0);
  for (const TetId t : open_) open[groups.find(cluster_of(t))] = 1;
  for (std::uint32_t c = 0; c < open.size(); ++c) open[c] = open[groups.find(c)];
  report_clusters(folds, open);
}

// Of the clusters that are open; what is not is settled here.
void ChunkInspector::report_clusters(const Vector<Fold>& folds, const Vector<std::uint8_t>& open) {
  const Vector<std::uint8_t> inverted = find_inverted_clusters(clusters_, folds);
  Vector<std::uint32_t> reported(clusters_.size());
  auto& out = out_.interface;
  bool any_small = false;
  for (std::uint32_t c = 0; c < clusters_.size(); ++c) {
    if (open[c] != 0) {
      reported[c] = static_cast<std::uint32_t>(out.clusters.size());
      out.clusters.push_back(clusters_[c]);
    } else if (inverted[c] != 0) {
      out_.inverted += clusters_[c].cells;
      out_.rewound -= clusters_[c].rewound;
    }
    any_small |= clusters_[c].cells <= kMaxBrokenCluster && (open[c] != 0 || inverted[c] != 0);
  }
  for (const Fold& fold : folds) {
    if (open[fold[0]] != 0) out.folds.push_back({reported[fold[0]], reported[fold[1]]});
  }
  for (auto& side : out.sides) {
    if (side.cluster < InterfaceFindings::kPair) side.cluster = reported[cluster_of(side.cluster)];
  }
  for (TetId t = 0; t < tets_->size() && any_small; ++t) {
    const std::uint32_t c = cluster_of(t);
    if (clusters_[c].cells > kMaxBrokenCluster) continue;
    if (open[c] != 0) {
      for (const VertexId v : (*tets_)[t]) {
        out.members.push_back({reported[c], chunk_.point_ids[v]});
      }
    } else if (inverted[c] != 0) {
      mark_cell(t, kBrokenVertex);
    }
  }
  std::sort(out.members.begin(), out.members.end());
  out.members.erase(std::unique(out.members.begin(), out.members.end()), out.members.end());
}

void ChunkInspector::judge_surface() {
  const Surface surface = judge_surface_part({chunk_.on_interface, true}, boundary_);
  out_.boundary_vertices = surface.vertices;
  out_.boundary_edges = surface.edges;
  out_.nonmanifold_edges = surface.nonmanifold_edges;
  out_.nonmanifold_vertices = surface.nonmanifold_vertices.size();
  for (const VertexId v : surface.nonmanifold_vertices) out_.vertex_flags[v] |= kBrokenVertex;
  boundary_at_ = surface.offsets;
}

bool ChunkInspector::ball_is_sound(VertexId v) const {
  const auto triangles = static_cast<std::int32_t>(boundary_at_[v + 1] - boundary_at_[v]);
  return sums_[v] == sum_of_sound_ball(triangles) || matcher_.cell_count(v) == 0;
}

// Whether nothing is wrong with any free vertex: all cells round it are then connected by faces
// that use it.
bool ChunkInspector::is_regular() const {
  for (VertexId v = 0; v < points(); ++v) {
    if (!is_free(v)) continue;
    if ((out_.vertex_flags[v] & kBrokenVertex) != 0 || !ball_is_sound(v)) return false;
  }
  return true;
}

// Balls are judged only where nothing else is wrong.
void ChunkInspector::judge_balls() {
  for (VertexId v = 0; v < points(); ++v) {
    if (!is_free(v) || (out_.vertex_flags[v] & kBrokenVertex) != 0 || ball_is_sound(v)) continue;
    out_.vertex_flags[v] |= kBrokenVertex;
    ++out_.nonmanifold_vertices;
    out_.interface.unsound_balls.push_back(chunk_.point_ids[v]);
  }
}

void ChunkInspector::report() {
  auto& out = out_.interface;
  out.cell_count = tets_->size();
  out.cells_have_ids = !chunk_.cell_ids.empty();
  for (VertexId v = 0; v < points(); ++v) {
    const bool is_used = matcher_.cell_count(v) > 0 || (out_.vertex_flags[v] & kBrokenVertex) != 0;
    if (is_free(v)) {
      if (!is_used) out_.vertex_flags[v] = kUnusedVertex;
      continue;
    }
    auto& point = out.points[interface_number_[v]];
    point.flags = out_.vertex_flags[v];
    point.sum = sums_[v];
    point.is_used = is_used;
  }
  for (const Triangle& t : boundary_) {
    const Triangle by_id{chunk_.point_ids[t[0]], chunk_.point_ids[t[1]], chunk_.point_ids[t[2]]};
    if (chunk_.wants_boundary) out_.boundary.push_back(by_id);
    if (!is_free(t[0]) || !is_free(t[1]) || !is_free(t[2])) out.triangles.push_back(by_id);
  }
}

}  // namespace

ChunkFindings inspect_chunk(const ChunkToInspect& chunk, Vector<Tet>* tets) {
  return ChunkInspector(chunk, tets).run();
}

}  // namespace tetfusion
