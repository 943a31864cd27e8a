#include "mesh/inspection/inspect.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/blocks.h"
#include "base/error.h"
#include "base/pool.h"
#include "base/sums.h"
#include "base/union_find.h"
#include "mesh/faces.h"
#include "mesh/inspection/cell_states.h"
#include "mesh/inspection/clusters.h"
#include "mesh/inspection/coincident.h"
#include "mesh/inspection/surface.h"
#include "mesh/inspection/vertex_ranges.h"

namespace tetfusion {

namespace {

constexpr std::size_t kCellBlock = 1 << 16;

struct CellFindings {
  std::uint64_t rewound = 0;
  std::uint64_t degenerate = 0;
  FirstIds degenerate_samples;
  CompensatedSum six_volumes;
};

// Adds to a number to which other threads add at the same time.
void add_to(std::int32_t* sum, std::int32_t x) {
  std::atomic_ref<std::int32_t>(*sum).fetch_add(x, std::memory_order_relaxed);
}

// Of a range of vertices.
struct FaceFindings {
  std::uint64_t duplicates = 0;
  std::uint64_t foldovers = 0;
  std::uint64_t overfull = 0;
  FirstIds duplicate_samples, foldover_samples, overfull_samples;
  Vector<Triangle> boundary;
  VertexId begin = 0;
  Vector<std::int32_t> sums;  // what is to be added to the sums of the range's own vertices

  // The larger neighbours of a vertex of the range. Most lie in the range too.
  void add_neighbours(VertexId v, std::span<const VertexId> neighbours,
                      Vector<std::int32_t>* all_sums) {
    sums[v - begin] += 2 * static_cast<std::int32_t>(neighbours.size());
    for (const VertexId w : neighbours) {
      if (w - begin < sums.size()) {
        sums[w - begin] += 2;
      } else {
        add_to(&(*all_sums)[w], 2);
      }
    }
  }
};

class Inspector {
 public:
  explicit Inspector(Geometry& geometry)
      : geometry_(geometry), tets_(geometry.tets), points_(point_count(geometry.points)) {}

  Inspection run() {
    if (points_ + tets_.size() > std::numeric_limits<std::uint32_t>::max()) {
      throw Error(
          ErrorCode::kBadInput,
          "the mesh has more than 4,294,967,295 points and tetrahedra together; cut it into "
          "smaller ones");
    }
    out_.vertex_flags.assign(points_, 0);
    sums_.assign(points_, 0);
    judge_cells();
    ranges_.emplace(points_, tets_);
    judge_faces();
    judge_surface();
    if (out_.foldover_faces > 0) find_inverted();
    judge_balls();
    count_components();
    mark_carried();
    find_coincident();
    measure_box();
    return std::move(out_);
  }

 private:
  FirstIds& samples(Defect kind) { return out_.samples[static_cast<std::size_t>(kind)]; }

  // Sets a flag; any thread, any vertex.
  void mark(VertexId v, std::uint8_t flag) {
    const std::atomic_ref<std::uint8_t> flags(out_.vertex_flags[v]);
    if ((flags.load(std::memory_order_relaxed) & flag) == 0) {
      flags.fetch_or(flag, std::memory_order_relaxed);
    }
  }
  void mark_cell(TetId t, std::uint8_t flag) {
    for (const VertexId v : tets_[t]) mark(v, flag);
  }
  bool is_marked(VertexId v, std::uint8_t flag) {
    const std::atomic_ref<std::uint8_t> flags(out_.vertex_flags[v]);
    return (flags.load(std::memory_order_relaxed) & flag) != 0;
  }

  template <class F>
  void for_each_range(F f);
  void judge_cells();
  void judge_faces();
  void judge_star(VertexId v, FaceMatcher* matcher, FaceFindings* found);
  void judge_face(VertexId v, std::span<const FaceSide> sides, FaceFindings* found);
  void find_duplicates(std::span<const FaceSide> sides, FaceFindings* found);
  void join_face_findings(std::vector<FaceFindings>* blocks);
  bool ball_is_sound(VertexId v) const;
  bool is_good(VertexId v) const { return good_[v] != 0; }
  std::uint32_t element_of(TetId t) const;
  template <class F>
  UnionFind connect_cells(F join);
  void find_inverted();
  void judge_surface();
  void judge_balls();
  void count_components();
  void mark_carried();
  void find_coincident();
  void measure_box();

  Geometry& geometry_;
  Vector<Tet>& tets_;
  const std::size_t points_;
  CellStates states_;
  std::optional<CellsByRange> ranges_;
  Pool<FaceMatcher> matchers_;
  Vector<std::int32_t> sums_;         // of each vertex: twice its neighbours, less its cells
  Vector<std::uint32_t> surface_at_;  // Surface::offsets
  // 1: all cells round the vertex are connected by faces that use it. For connect_cells().
  Vector<std::uint8_t> good_;
  Inspection out_;
};

// Calls f(range, begin, end, matcher) for each range of vertices that has cells, side by side.
template <class F>
void Inspector::for_each_range(F f) {
  for_each_block(points_, CellsByRange::kRangeVertices,
                 [&](std::size_t r, std::size_t begin, std::size_t end) {
                   auto matcher = matchers_.borrow();
                   f(r, static_cast<VertexId>(begin), static_cast<VertexId>(end), &*matcher);
                 });
}

void Inspector::judge_cells() {
  states_.resize(tets_.size());
  std::vector<CellFindings> blocks(block_count(tets_.size(), kCellBlock));
  const auto judge = [&](const auto& points) {
    for_each_block(tets_.size(), kCellBlock,
                   [&](std::size_t b, std::size_t begin, std::size_t end) {
                     CellFindings& found = blocks[b];
                     for (std::size_t i = begin; i < end; ++i) {
                       const auto t = static_cast<TetId>(i);
                       const double six_volume = states_.judge(points, t, &tets_[t]);
                       if (states_.has_volume(t)) {
                         found.six_volumes.add(six_volume);
                         found.rewound += states_.is_rewound(t) ? 1 : 0;
                       } else {
                         ++found.degenerate;
                         found.degenerate_samples.add(t);
                         mark_cell(t, kBrokenVertex);
                       }
                     }
                   });
  };
  std::visit(judge, geometry_.points);
  CompensatedSum six_volumes;
  for (const CellFindings& found : blocks) {
    out_.rewound += found.rewound;
    out_.degenerate += found.degenerate;
    samples(Defect::kDegenerate).add(found.degenerate_samples);
    six_volumes.add(found.six_volumes);
  }
  out_.volume = six_volumes.value() / 6;
}

void Inspector::find_duplicates(std::span<const FaceSide> sides, FaceFindings* found) {
  for_each_copy(sides, [&](TetId t) {
    ++found->duplicates;
    found->duplicate_samples.add(t);
    mark_cell(t, kBrokenVertex);
  });
}

void Inspector::judge_face(VertexId v, std::span<const FaceSide> sides, FaceFindings* found) {
  const FaceSide& first = sides[0];
  if (sides.size() == 1) {
    Triangle t{v, first.middle(), first.largest()};
    if (first.odd != 0) std::swap(t[1], t[2]);
    found->boundary.push_back(t);
    return;
  }
  find_duplicates(sides, found);
  if (sides.size() > 2) {
    ++found->overfull;
    found->overfull_samples.add(first.tet);
    for (const VertexId w : {v, first.middle(), first.largest()}) mark(w, kBrokenVertex);
  } else if (states_.fold(first, sides[1])) {
    ++found->foldovers;
    found->foldover_samples.add(first.tet);
    mark_cell(first.tet, kBrokenVertex);
    mark_cell(sides[1].tet, kBrokenVertex);
  }
}

// A cell without volume may be wound either way, and is not matched for what it is: its vertices
// are broken, and take the slow way.
void Inspector::judge_star(VertexId v, FaceMatcher* matcher, FaceFindings* found) {
  if (is_marked(v, kBrokenVertex) || !matcher->match(v)) {
    matcher->for_each_face(v,
                           [&](std::span<const FaceSide> sides) { judge_face(v, sides, found); });
    found->add_neighbours(v, matcher->larger_neighbours(v), &sums_);
    return;
  }
  const std::size_t first = found->boundary.size();
  matcher->for_each_single([&](VertexId m, VertexId l) { found->boundary.push_back({v, m, l}); });
  if (found->boundary.size() > first) {  // in the order of the slow way
    std::sort(found->boundary.begin() + static_cast<std::ptrdiff_t>(first), found->boundary.end(),
              [](const Triangle& a, const Triangle& b) {
                return std::minmax(a[1], a[2]) < std::minmax(b[1], b[2]);
              });
  }
  found->add_neighbours(v, matcher->neighbours(), &sums_);
}

void Inspector::judge_faces() {
  std::vector<FaceFindings> blocks(block_count(points_, CellsByRange::kRangeVertices));
  for_each_range([&](std::size_t r, VertexId begin, VertexId end, FaceMatcher* matcher) {
    FaceFindings& found = blocks[r];
    found.begin = begin;
    found.sums.assign(end - begin, 0);
    if (!ranges_->of(r).empty()) {
      matcher->load(tets_, ranges_->of(r), begin, end, points_);
      for (VertexId v = begin; v < end; ++v) {
        const std::uint32_t cells = matcher->cell_count(v);
        found.sums[v - begin] -= static_cast<std::int32_t>(cells);
        if (cells > 0) {
          judge_star(v, matcher, &found);
        } else if (!is_marked(v, kBrokenVertex)) {
          mark(v, kUnusedVertex);
        }
      }
    } else {
      for (VertexId v = begin; v < end; ++v) mark(v, kUnusedVertex);
    }
    for (const Triangle& t : found.boundary) {
      for (const VertexId v : t) mark(v, kBoundaryVertex);
    }
    for (VertexId v = begin; v < end; ++v) add_to(&sums_[v], found.sums[v - begin]);
    found.sums = {};
  });
  join_face_findings(&blocks);
}

void Inspector::join_face_findings(std::vector<FaceFindings>* blocks) {
  std::size_t triangles = 0;
  for (const FaceFindings& found : *blocks) triangles += found.boundary.size();
  if (triangles > std::numeric_limits<std::uint32_t>::max() / 3) {
    throw Error(
        ErrorCode::kBadInput,
        "the mesh has more than 1,431,655,765 boundary triangles; cut it into smaller ones");
  }
  out_.boundary_faces = triangles;
  out_.boundary_triangles.reserve(triangles);
  for (FaceFindings& found : *blocks) {
    out_.duplicate_tets += found.duplicates;
    out_.foldover_faces += found.foldovers;
    out_.overfull_faces += found.overfull;
    samples(Defect::kDuplicate).add(found.duplicate_samples);
    samples(Defect::kFoldoverFace).add(found.foldover_samples);
    samples(Defect::kOverfullFace).add(found.overfull_samples);
    out_.boundary_triangles.insert(out_.boundary_triangles.end(), found.boundary.begin(),
                                   found.boundary.end());
    found.boundary = {};
  }
}

bool Inspector::ball_is_sound(VertexId v) const {
  return sums_[v] ==
         sum_of_sound_ball(static_cast<std::int32_t>(surface_at_[v + 1] - surface_at_[v]));
}

// What stands for a cell where cells are connected: a good vertex of it, or itself.
std::uint32_t Inspector::element_of(TetId t) const {
  for (const VertexId v : tets_[t]) {
    if (is_good(v)) return v;
  }
  return static_cast<std::uint32_t>(points_) + t;
}

// The components of the mesh, as sets of what stands for cells. Only faces without good vertices
// are looked at: join(sides) says whether the first two, or all, are connected.
template <class F>
UnionFind Inspector::connect_cells(F join) {
  good_.resize(points_);
  for_each_block(points_, kCellBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto v = static_cast<VertexId>(i);
      const bool is_odd = (out_.vertex_flags[v] & (kBrokenVertex | kUnusedVertex)) != 0;
      good_[v] = !is_odd && ball_is_sound(v) ? 1 : 0;
    }
  });
  UnionFind sets(points_ + tets_.size());
  for_each_block(tets_.size(), kCellBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      // Most are connected already.
      std::uint32_t root = kNoVertex;
      for (const VertexId v : tets_[t]) {
        if (!is_good(v)) continue;
        if (root == kNoVertex) {
          root = sets.find(v);
        } else if (sets.find(v) != root) {
          sets.unite(root, v);
        }
      }
    }
  });
  for_each_range([&](std::size_t r, VertexId begin, VertexId end, FaceMatcher* matcher) {
    bool loaded = false;
    for (VertexId v = begin; v < end; ++v) {
      if (is_good(v) || (out_.vertex_flags[v] & kUnusedVertex) != 0) continue;
      if (!loaded) matcher->load(tets_, ranges_->of(r), begin, end, points_);
      loaded = true;
      matcher->for_each_face(v, [&](std::span<const FaceSide> sides) {
        if (is_good(sides[0].middle()) || is_good(sides[0].largest()) || !join(sides)) return;
        for (std::size_t s = 1; s < sides.size(); ++s) {
          sets.unite(element_of(sides[0].tet), element_of(sides[s].tet));
        }
      });
    }
  });
  return sets;
}

// After rewinding, the cells of a sound mesh lie on both sides of their faces.
void Inspector::find_inverted() {
  std::mutex mutex;
  std::vector<std::array<TetId, 2>> folded;
  UnionFind sets = connect_cells([&](std::span<const FaceSide> sides) {
    if (sides.size() != 2) return false;
    if (states_.fold(sides[0], sides[1])) {
      const std::lock_guard lock(mutex);
      folded.push_back({sides[0].tet, sides[1].tet});
      return false;
    }
    return states_.has_volume(sides[0].tet) && states_.has_volume(sides[1].tet);
  });
  Vector<std::uint32_t> number(points_ + tets_.size(), kNoVertex);
  Vector<std::uint32_t> cluster_of(tets_.size());
  Vector<Cluster> clusters;
  for (TetId t = 0; t < tets_.size(); ++t) {
    std::uint32_t& cluster = number[sets.find(element_of(t))];
    if (cluster == kNoVertex) {
      cluster = static_cast<std::uint32_t>(clusters.size());
      clusters.push_back({});
    }
    cluster_of[t] = cluster;
    clusters[cluster].add({1, states_.is_rewound(t) ? 1u : 0u, t});
  }
  Vector<Fold> folds_between;
  for (const auto& [a, b] : folded) folds_between.push_back({cluster_of[a], cluster_of[b]});
  const Vector<std::uint8_t> inverted = find_inverted_clusters(clusters, folds_between);
  for (TetId t = 0; t < tets_.size(); ++t) {
    if (inverted[cluster_of[t]] == 0) continue;
    ++out_.inverted;
    if (states_.is_rewound(t)) --out_.rewound;
    samples(Defect::kInverted).add(t);
    if (clusters[cluster_of[t]].cells <= kMaxBrokenCluster) mark_cell(t, kBrokenVertex);
  }
}

void Inspector::judge_surface() {
  Surface surface = tetfusion::judge_surface(points_, out_.boundary_triangles);
  out_.boundary_vertices = surface.vertices;
  out_.boundary_edges = surface.edges;
  out_.surface_components = surface.components;
  out_.nonmanifold_edges = surface.nonmanifold_edges;
  samples(Defect::kNonmanifoldEdge) = surface.nonmanifold_edge_samples;
  out_.nonmanifold_vertices = surface.nonmanifold_vertices.size();
  for (const VertexId v : surface.nonmanifold_vertices) {
    mark(v, kBrokenVertex);
    samples(Defect::kNonmanifoldVertex).add(v);
  }
  surface_at_ = std::move(surface.offsets);
}

// Balls are judged only where nothing else is wrong.
void Inspector::judge_balls() {
  for (VertexId v = 0; v < points_; ++v) {
    if ((out_.vertex_flags[v] & (kBrokenVertex | kUnusedVertex)) != 0 || ball_is_sound(v)) continue;
    mark(v, kBrokenVertex);
    ++out_.nonmanifold_vertices;
    samples(Defect::kNonmanifoldVertex).add(v);
  }
}

void Inspector::count_components() {
  UnionFind sets = connect_cells([](std::span<const FaceSide>) { return true; });
  for (TetId t = 0; t < tets_.size(); ++t) {
    const std::uint32_t element = element_of(t);
    if (element >= points_ && sets.is_root(element)) ++out_.components;
  }
  for (VertexId v = 0; v < points_; ++v) {
    if (is_good(v) && sets.is_root(v)) ++out_.components;
  }
}

void Inspector::mark_carried() {
  for (const VertexId v : geometry_.lower.connectivity) mark(v, kCarriedVertex);
}

void Inspector::find_coincident() {
  for (const auto& [later, earlier] : coincident_points(geometry_.points)) {
    ++out_.coincident_points;
    samples(Defect::kCoincidentPoint).add(later);
  }
}

void Inspector::measure_box() {
  for (const std::uint8_t flags : out_.vertex_flags) {
    out_.unused_points += (flags & kUnusedVertex) != 0 ? 1 : 0;
  }
  const auto measure = [&](const auto& points) {
    if (points.empty()) return;
    out_.lower = out_.upper = {points[0].x, points[0].y, points[0].z};
    for (const auto& p : points) {
      const std::array<double, 3> x{p.x, p.y, p.z};
      for (std::size_t k = 0; k < 3; ++k) {
        out_.lower[k] = std::min(out_.lower[k], x[k]);
        out_.upper[k] = std::max(out_.upper[k], x[k]);
      }
    }
  };
  std::visit(measure, geometry_.points);
}

}  // namespace

Inspection inspect(Geometry& geometry) { return Inspector(geometry).run(); }

}  // namespace tetfusion
