#include "mesh/inspect.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "base/error.h"
#include "mesh/blocks.h"
#include "mesh/coincident.h"
#include "mesh/faces.h"
#include "mesh/predicates.h"
#include "mesh/sums.h"
#include "mesh/surface.h"
#include "mesh/union_find.h"
#include "mesh/vertex_tets.h"

namespace tetfusion {

namespace {

constexpr std::size_t kCellBlock = 1 << 16;
constexpr std::size_t kVertexBlock = 1 << 12;

enum CellState : std::uint8_t { kSound = 0, kNoVolume = 1, kRewound = 2 };

// Distinct vertices round one vertex.
class Neighbours {
 public:
  void clear() {
    count_ = 0;
    ++epoch_;
  }
  void add(VertexId v) {
    if (2 * count_ >= slots_.size()) grow();
    count_ += put(v) ? 1 : 0;
  }
  std::size_t count() const { return count_; }

 private:
  bool put(VertexId v) {
    const std::uint64_t wanted = epoch_ << 32 | v;
    for (std::size_t i = v * 0x9E3779B1u;; ++i) {
      std::uint64_t& slot = slots_[i & (slots_.size() - 1)];
      if (slot == wanted) return false;
      if (slot >> 32 != epoch_) {
        slot = wanted;
        return true;
      }
    }
  }
  void grow() {
    const Vector<std::uint64_t> old = std::move(slots_);
    slots_.assign(std::max<std::size_t>(128, 2 * old.size()), 0);
    for (const std::uint64_t slot : old) {
      if (slot >> 32 == epoch_) put(static_cast<VertexId>(slot));
    }
  }

  Vector<std::uint64_t> slots_;  // epoch << 32 | vertex; a power of two of them
  std::uint64_t epoch_ = 1;      // slots of other epochs are free
  std::size_t count_ = 0;
};

struct CellFindings {
  std::uint64_t rewound = 0;
  std::uint64_t degenerate = 0;
  FirstIds degenerate_samples;
  CompensatedSum six_volumes;
};

struct FaceFindings {
  std::uint64_t duplicates = 0;
  std::uint64_t foldovers = 0;
  std::uint64_t overfull = 0;
  FirstIds duplicate_samples, foldover_samples, overfull_samples;
  Vector<Triangle> boundary;
};

class Inspector {
 public:
  explicit Inspector(Geometry& geometry) : geometry_(geometry), tets_(geometry.tets) {}

  Inspection run() {
    const std::size_t points = point_count(geometry_.points);
    out_.vertex_flags.assign(points, 0);
    judge_cells();
    build_vertex_tets(points, tets_, &vertex_tets_);
    judge_faces();
    if (out_.foldover_faces > 0) find_inverted();
    judge_surface_and_balls();
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
  bool has_volume(TetId t) const { return (states_[t] & kNoVolume) == 0; }

  void judge_cells();
  void judge_faces();
  void judge_face(VertexId v, std::span<const FaceSide> sides, FaceFindings* found);
  void find_duplicates(std::span<const FaceSide> sides, FaceFindings* found);
  bool folds(const FaceSide& a, const FaceSide& b) const;
  void join_face_findings(std::vector<FaceFindings>* blocks);
  void find_inverted();
  void judge_surface_and_balls();
  void judge_balls(const Surface& surface);
  bool ball_is_sound(VertexId v, std::size_t boundary_triangles, Neighbours* neighbours) const;
  void mark_carried();
  void find_coincident();
  void measure_box();

  Geometry& geometry_;
  Vector<Tet>& tets_;
  Vector<std::uint8_t> states_;  // CellState bits
  VertexTets vertex_tets_;
  Inspection out_;
};

void Inspector::judge_cells() {
  states_.resize(tets_.size());
  std::vector<CellFindings> blocks(block_count(tets_.size(), kCellBlock));
  const auto judge = [&](const auto& points) {
    for_each_block(tets_.size(), kCellBlock,
                   [&](std::size_t b, std::size_t begin, std::size_t end) {
                     CellFindings& found = blocks[b];
                     for (std::size_t t = begin; t < end; ++t) {
                       const Determinant det = determinant(points, tets_[t]);
                       const int sign = names_vertex_twice(tets_[t]) ? 0 : det.sign();
                       states_[t] = sign > 0 ? kSound : (sign < 0 ? kRewound : kNoVolume);
                       if (sign == 0) {
                         ++found.degenerate;
                         found.degenerate_samples.add(static_cast<TetId>(t));
                         mark_cell(static_cast<TetId>(t), kBrokenVertex);
                         continue;
                       }
                       found.six_volumes.add(std::abs(det.value));
                       if (sign < 0) {
                         std::swap(tets_[t][2], tets_[t][3]);
                         ++found.rewound;
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

// Do two cells of a face lie on the same side of it? The copies of one cell do not count: they are
// duplicates.
bool Inspector::folds(const FaceSide& a, const FaceSide& b) const {
  return a.odd == b.odd && has_volume(a.tet()) && has_volume(b.tet()) &&
         tets_[a.tet()][a.corner()] != tets_[b.tet()][b.corner()];
}

// A cell is met here with the face that lacks its largest vertex; so are its copies, and they have
// the same.
void Inspector::find_duplicates(std::span<const FaceSide> sides, FaceFindings* found) {
  // Sorted, because hostile files have faces with very many cells.
  std::vector<std::pair<VertexId, TetId>> apexes;
  for (const FaceSide& side : sides) {
    const VertexId apex = tets_[side.tet()][side.corner()];
    if (apex >= side.largest()) apexes.emplace_back(apex, side.tet());
  }
  std::sort(apexes.begin(), apexes.end());
  for (std::size_t i = 1; i < apexes.size(); ++i) {
    if (apexes[i].first != apexes[i - 1].first) continue;
    ++found->duplicates;
    found->duplicate_samples.add(apexes[i].second);
    mark_cell(apexes[i].second, kBrokenVertex);
  }
}

void Inspector::judge_face(VertexId v, std::span<const FaceSide> sides, FaceFindings* found) {
  const FaceSide& first = sides[0];
  if (sides.size() == 1) {
    Triangle t{v, first.middle(), first.largest()};
    for (const VertexId w : t) mark(w, kBoundaryVertex);
    if (first.odd != 0) std::swap(t[1], t[2]);
    found->boundary.push_back(t);
    return;
  }
  find_duplicates(sides, found);
  if (sides.size() > 2) {
    ++found->overfull;
    found->overfull_samples.add(first.tet());
    for (const VertexId w : {v, first.middle(), first.largest()}) mark(w, kBrokenVertex);
  } else if (folds(first, sides[1])) {
    ++found->foldovers;
    found->foldover_samples.add(first.tet());
    mark_cell(first.tet(), kBrokenVertex);
    mark_cell(sides[1].tet(), kBrokenVertex);
  }
}

void Inspector::judge_faces() {
  const std::size_t points = out_.vertex_flags.size();
  std::vector<FaceFindings> blocks(block_count(points, kVertexBlock));
  UnionFind parts(tets_.size());
  for_each_block(points, kVertexBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
    FaceMatcher matcher;
    for (std::size_t i = begin; i < end; ++i) {
      const auto v = static_cast<VertexId>(i);
      if (vertex_tets_.of(v).empty()) mark(v, kUnusedVertex);
      matcher.for_each_face(v, tets_, vertex_tets_, [&](std::span<const FaceSide> sides) {
        judge_face(v, sides, &blocks[b]);
        for (std::size_t s = 1; s < sides.size(); ++s) parts.unite(sides[0].tet(), sides[s].tet());
      });
    }
  });
  join_face_findings(&blocks);
  for (TetId t = 0; t < tets_.size(); ++t) out_.components += parts.is_root(t) ? 1 : 0;
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

// After rewinding, the cells of a sound mesh lie on both sides of their faces. Give every cell a
// colour that changes at fold-over faces only: in each part of the mesh, the colour of the fewer
// cells is the inverted one; of two that are as many, the one with more cells that had to be
// rewound, then the one without the first cell. Rare, and so on one thread: the colours then do not
// depend on chance where they contradict each other.
void Inspector::find_inverted() {
  ColourUnionFind colours(tets_.size());
  FaceMatcher matcher;
  for (std::size_t v = 0; v < out_.vertex_flags.size(); ++v) {
    matcher.for_each_face(static_cast<VertexId>(v), tets_, vertex_tets_,
                          [&](std::span<const FaceSide> sides) {
                            if (sides.size() != 2) return;
                            const TetId a = sides[0].tet(), b = sides[1].tet();
                            if (!has_volume(a) || !has_volume(b)) return;
                            colours.unite(a, b, folds(sides[0], sides[1]));
                          });
  }
  struct Part {
    std::array<std::uint32_t, 2> cells{};
    std::array<std::uint32_t, 2> rewound{};
    std::uint32_t inverted_colour() const {
      if (cells[0] != cells[1]) return cells[1] < cells[0] ? 1 : 0;
      return rewound[0] > rewound[1] ? 0 : 1;
    }
  };
  Vector<Part> parts(tets_.size(), Part{});
  for (TetId t = 0; t < tets_.size(); ++t) {
    const auto root = colours.find(t);
    ++parts[root.id].cells[root.other ? 1 : 0];
    if ((states_[t] & kRewound) != 0) ++parts[root.id].rewound[root.other ? 1 : 0];
  }
  for (TetId t = 0; t < tets_.size(); ++t) {
    const auto root = colours.find(t);
    const Part& part = parts[root.id];
    if (part.cells[1] == 0 || part.inverted_colour() != (root.other ? 1u : 0u)) continue;
    ++out_.inverted;
    if ((states_[t] & kRewound) != 0) --out_.rewound;
    samples(Defect::kInverted).add(t);
    mark_cell(t, kBrokenVertex);
  }
}

void Inspector::judge_surface_and_balls() {
  const Surface surface = judge_surface(out_.vertex_flags.size(), out_.boundary_triangles);
  out_.boundary_vertices = surface.vertices;
  out_.boundary_edges = surface.edges;
  out_.surface_components = surface.components;
  out_.nonmanifold_edges = surface.nonmanifold_edges;
  samples(Defect::kNonmanifoldEdge) = surface.nonmanifold_edge_samples;
  // Balls first: they are judged only where nothing else is wrong, and that includes the surface.
  out_.nonmanifold_vertices = surface.nonmanifold_vertices.size();
  for (const VertexId v : surface.nonmanifold_vertices) {
    mark(v, kBrokenVertex);
    samples(Defect::kNonmanifoldVertex).add(v);
  }
  judge_balls(surface);
}

// The link of a sound vertex, the surface of its ball, is a sphere, or a disc for a boundary
// vertex: its Euler number is 2 or 1. With n cells and b boundary triangles round the vertex the
// link has n triangles and (3 n + b) / 2 edges, as long as no face has more than two cells.
bool Inspector::ball_is_sound(VertexId v, std::size_t boundary_triangles,
                              Neighbours* neighbours) const {
  const auto ball = vertex_tets_.of(v);
  neighbours->clear();
  for (const std::uint32_t entry : ball) {
    const Tet& t = tets_[entry >> 2];
    for (std::uint32_t k = 1; k < 4; ++k) neighbours->add(t[(entry + k) & 3]);
  }
  const std::size_t euler = boundary_triangles > 0 ? 1 : 2;
  return 2 * neighbours->count() == 2 * euler + ball.size() + boundary_triangles;
}

void Inspector::judge_balls(const Surface& surface) {
  const std::size_t points = out_.vertex_flags.size();
  struct Found {
    std::uint64_t count = 0;
    FirstIds samples;
  };
  std::vector<Found> blocks(block_count(points, kVertexBlock));
  for_each_block(points, kVertexBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
    Neighbours neighbours;
    for (std::size_t i = begin; i < end; ++i) {
      const auto v = static_cast<VertexId>(i);
      if ((out_.vertex_flags[v] & (kBrokenVertex | kUnusedVertex)) != 0) continue;
      if (ball_is_sound(v, surface.offsets[i + 1] - surface.offsets[i], &neighbours)) continue;
      mark(v, kBrokenVertex);
      ++blocks[b].count;
      blocks[b].samples.add(v);
    }
  });
  for (const Found& found : blocks) {
    out_.nonmanifold_vertices += found.count;
    samples(Defect::kNonmanifoldVertex).add(found.samples);
  }
}

void Inspector::mark_carried() {
  for (const VertexId v : geometry_.lower.connectivity) mark(v, kCarriedVertex);
}

void Inspector::find_coincident() {
  for (const auto& [later, earlier] : coincident_points(geometry_.points)) {
    ++out_.coincident_points;
    samples(Defect::kCoincidentPoint).add(later);
    mark(later, kCoincidentVertex);
    mark(earlier, kCoincidentVertex);
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
