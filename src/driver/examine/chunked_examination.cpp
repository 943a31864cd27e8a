#include "driver/examine/chunked_examination.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <utility>
#include <vector>

#include "base/blocks.h"
#include "base/resources.h"
#include "base/tasks.h"
#include "base/union_find.h"
#include "driver/arrays/steering.h"
#include "driver/import/chunk_loader.h"
#include "driver/import/scatter.h"
#include "driver/import/stream_coincident.h"
#include "driver/rounds/rounds.h"
#include "mesh/faces.h"
#include "mesh/inspection/chunk_inspection.h"
#include "mesh/inspection/inspect.h"
#include "mesh/inspection/interface_inspection.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kCellWindow = std::uint64_t{1} << 19;
constexpr std::uint64_t kPointWindow = std::uint64_t{1} << 18;
// Of a point, beside what scattering needs: flags, and two forests one after the other.
constexpr std::uint64_t kExtraPointBytes = 5;
// Of an odd cell: itself, its sides, and inspecting a mesh of all of them; 130 measured.
constexpr std::uint64_t kOddCellBytes = 140;

void unite_corners(const std::array<VertexId, 3>& triangle, UnionFind* sets) {
  sets->unite(triangle[0], triangle[1]);
  sets->unite(triangle[0], triangle[2]);
}

template <class Real>
class Examiner {
 public:
  Examiner(const MeshDescription& mesh, const MeshStream& stream, const RunContext& context,
           MemoryBudget* budget)
      : description_(mesh),
        stream_(stream),
        context_(context),
        budget_(budget),
        points_(stream.points()) {}

  Examination run(std::uint64_t chunk_tets, Scratch* scratch);

 private:
  // A cell that uses a point with which something is wrong.
  struct OddCell {
    Tet tet;
    std::uint64_t row;
  };
  struct Share {
    ChunkFindings findings;
    QualityMeter quality;
    Box box;
    std::uint64_t tets = 0;
  };

  void judge_chunks(const ScatteredMesh<Real>& from);
  Share judge_chunk(WorkMesh<Real>* mesh, UnionFind* surfaces);
  void take(const InterfaceVerdict& verdict);
  void count_points(const LowerPart<Real>& lower);
  bool is_good(VertexId v) const { return (flags_[v] & (kBrokenVertex | kUnusedVertex)) == 0; }
  void look_at_cells();
  void count_components(UnionFind* sets);
  // The odd cells alone, as a mesh. Its points with which something is wrong come first.
  struct OddPart {
    Geometry mesh;
    Vector<VertexId> ids;  // of its points
    VertexId odd_points = 0;
  };
  OddPart odd_part() const;
  void find_samples();
  Vector<Vec3<Real>> positions_of(const Vector<VertexId>& ascending) const;
  void find_coincident();

  const MeshDescription& description_;
  const MeshStream& stream_;
  const RunContext& context_;
  MemoryBudget* budget_;
  const std::uint64_t points_;
  // One a point, as Inspection::vertex_flags; kCarriedVertex for points of cells of lower
  // dimension.
  Vector<std::uint8_t> flags_;
  Vector<OddCell> odd_;
  MemoryBudget::Reservation odd_memory_;
  FirstIds coincident_;
  Examination out_;
};

template <class Real>
Examination Examiner<Real>::run(std::uint64_t chunk_tets, Scratch* scratch) {
  const auto memory = budget_->reserve(points_ * kExtraPointBytes, "what is known of each point");
  ScatterSettings settings;
  settings.chunk_tets = chunk_tets;
  const CarriedArrays nothing{MeshDescription{}};
  Steering no_steering;
  PhaseClock clock;
  out_.mesh.merged_points = stream_.merged_points();
  out_.mesh.differing_points = stream_.differing_points();
  out_.mesh.largest_difference = stream_.largest_difference();
  {
    ScatteredMesh<Real> scattered =
        scatter_mesh<Real>({stream_, nothing, &no_steering}, settings, WorkMesh<Real>(),
                           {context_, &clock, budget_, scratch});
    context_.report_size(scattered.tet_count);
    out_.mesh.ghost_cells = scattered.ghost_cells;
    flags_.assign(points_, kUnusedVertex);
    judge_chunks(scattered);
    count_points(scattered.lower);
  }
  look_at_cells();
  find_samples();
  find_coincident();
  return std::move(out_);
}

template <class Real>
void Examiner<Real>::judge_chunks(const ScatteredMesh<Real>& from) {
  std::vector<ChunkLoader<Real>> loaders;
  std::vector<WorkMesh<Real>> meshes(static_cast<std::size_t>(thread_count()));
  const Box cut_box = without_outliers<Real>(from.box, from.samples);
  for (const WorkMesh<Real>& mesh : meshes) loaders.emplace_back(mesh, cut_box);
  UnionFind surfaces(points_);
  InterfaceInspection between;
  QualityMeter quality;
  Box box;
  InOrder<Share> join([&](Share share) {
    between.add(&share.findings);
    quality.add(share.quality);
    box.add(share.box);
    out_.mesh.tets += share.tets;
  });
  std::atomic<std::size_t> done{0};
  run_tasks(from.chunks, thread_count(), [&](std::size_t c, std::size_t w) {
    context_.check();
    const auto chunk = static_cast<std::uint32_t>(c);
    const auto memory =
        budget_->wait_for(chunk_memory(from.tets->bytes(chunk) + from.points->bytes(chunk)),
                          "a chunk to be looked at");
    loaders[w].load(chunk, *from.tets, *from.points, &meshes[w]);
    from.tets->forget(chunk);
    from.points->forget(chunk);
    join.put(c, judge_chunk(&meshes[w], &surfaces));
    context_.report("inspecting", 0.12, 0.7, ++done, from.chunks);
  });
  const InterfaceVerdict verdict = between.finish();
  for (const auto& triangle : verdict.boundary) unite_corners(triangle, &surfaces);
  take(verdict);
  out_.mesh.lower = {box.lo.x, box.lo.y, box.lo.z};
  out_.mesh.upper = {box.hi.x, box.hi.y, box.hi.z};
  out_.quality = quality.quality();
  for (std::uint64_t v = 0; v < points_; ++v) {
    const bool is_boundary = (flags_[v] & kBoundaryVertex) != 0;
    if (is_boundary && surfaces.is_root(static_cast<VertexId>(v))) ++out_.mesh.surface_components;
  }
}

template <class Real>
typename Examiner<Real>::Share Examiner<Real>::judge_chunk(WorkMesh<Real>* mesh,
                                                           UnionFind* surfaces) {
  Share share;
  share.findings = inspect_as_marked(mesh, true);
  for (std::size_t v = 0; v < mesh->vertex_count(); ++v) {
    if (sharing_of(mesh->marks[v]) != kOwn) continue;
    flags_[mesh->point_ids[v]] = share.findings.vertex_flags[v];
  }
  for (const auto& triangle : share.findings.boundary) unite_corners(triangle, surfaces);
  share.findings.boundary = {};
  share.findings.vertex_flags = {};
  for (const Vec3<Real>& p : mesh->positions) share.box.add({p.x, p.y, p.z});
  share.quality.add(std::move(mesh->positions), mesh->tets);
  share.tets = mesh->tets.size();
  return share;
}

template <class Real>
void Examiner<Real>::take(const InterfaceVerdict& verdict) {
  static_cast<MeshCounts&>(out_.mesh) = verdict;
  out_.mesh.volume = verdict.volume;
  for (std::size_t i = 0; i < verdict.ids.size(); ++i) flags_[verdict.ids[i]] = verdict.flags[i];
  for (const VertexId id : verdict.overrides) flags_[id] |= kBrokenVertex;
}

// Those that tetrahedra use, and those that only cells of lower dimension do.
template <class Real>
void Examiner<Real>::count_points(const LowerPart<Real>& lower) {
  InspectionSummary& mesh = out_.mesh;
  mesh.count_lower(lower.cells);
  for (const VertexId v : lower.vertices) flags_[v] |= kCarriedVertex;
  for (std::size_t i = 0; i < lower.loose_ids.size(); ++i) {
    const Vec3<Real>& p = lower.loose_positions[i];
    const std::array<double, 3> x{p.x, p.y, p.z};
    for (std::size_t k = 0; k < 3; ++k) {
      mesh.lower[k] = std::min(mesh.lower[k], x[k]);
      mesh.upper[k] = std::max(mesh.upper[k], x[k]);
    }
  }
  for (const std::uint8_t flags : flags_) {
    if ((flags & kUnusedVertex) == 0 || (flags & kCarriedVertex) != 0) ++mesh.points;
  }
  mesh.unused_points = points_ - mesh.points + stream_.dropped_points();
}

// Once more, now that it is known which points are sound: all cells round one of them are connected
// by faces. The others are few, and so are their cells.
template <class Real>
void Examiner<Real>::look_at_cells() {
  UnionFind sets(points_);
  const std::size_t windows = block_count(stream_.cells(), kCellWindow);
  std::vector<Vector<OddCell>> found(windows);
  const std::uint64_t most = budget_->free() / kOddCellBytes;  // beyond that they are counted
  std::atomic<std::size_t> done{0};
  std::atomic<std::uint64_t> count{0};
  for_each_block(
      stream_.cells(), kCellWindow, [&](std::size_t w, std::size_t begin, std::size_t end) {
        context_.check();
        CellWindow cells;
        stream_.read_cells(begin, end - begin, &cells);
        for (std::size_t i = 0; i < cells.tets.size(); ++i) {
          const Tet& t = cells.tets[i];
          VertexId good = kNoVertex;
          bool is_odd = false;
          for (const VertexId v : t) {
            is_odd |= !is_good(v);
            if (!is_good(v)) continue;
            if (good != kNoVertex) sets.unite(good, v);
            good = v;
          }
          if (!is_odd || ++count > most) continue;
          found[w].push_back({t, cells.tet_rows.empty() ? begin + i : cells.tet_rows[i]});
        }
        context_.report("inspecting", 0.7, 0.9, ++done, windows);
      });
  odd_memory_ = budget_->reserve(count * kOddCellBytes, "what is odd about the mesh");
  for (Vector<OddCell>& cells : found) {
    odd_.insert(odd_.end(), cells.begin(), cells.end());
    cells = {};
  }
  count_components(&sets);
}

// A cell without a sound point stands for itself; what it is connected with by faces is looked for
// among the odd ones.
template <class Real>
void Examiner<Real>::count_components(UnionFind* sets) {
  struct Side {
    std::array<VertexId, 3> face;
    std::uint32_t element;
  };
  std::vector<Side> sides;
  auto elements = static_cast<std::uint32_t>(points_);
  for (const OddCell& cell : odd_) {
    const auto good =
        std::find_if(cell.tet.begin(), cell.tet.end(), [&](VertexId v) { return is_good(v); });
    const std::uint32_t element = good != cell.tet.end() ? *good : elements++;
    if (names_vertex_twice(cell.tet)) continue;  // it has no faces
    for (const auto& corners : kFaceCorners) {
      std::array<VertexId, 3> face{cell.tet[corners[0]], cell.tet[corners[1]],
                                   cell.tet[corners[2]]};
      if (is_good(face[0]) || is_good(face[1]) || is_good(face[2])) continue;
      std::sort(face.begin(), face.end());
      sides.push_back({face, element});
    }
  }
  std::sort(sides.begin(), sides.end(),
            [](const Side& a, const Side& b) { return a.face < b.face; });
  sets->grow(elements);
  for (std::size_t i = 1; i < sides.size(); ++i) {
    if (sides[i].face == sides[i - 1].face) sets->unite(sides[i].element, sides[i - 1].element);
  }
  std::uint64_t components = 0;
  for (std::uint32_t e = 0; e < elements; ++e) {
    if ((e >= points_ || is_good(e)) && sets->is_root(e)) ++components;
  }
  out_.mesh.components = components;
}

template <class Real>
auto Examiner<Real>::odd_part() const -> OddPart {
  Vector<VertexId> ids;
  for (const OddCell& cell : odd_) ids.insert(ids.end(), cell.tet.begin(), cell.tet.end());
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  const Vector<Vec3<Real>> positions = positions_of(ids);
  Vector<VertexId> places(ids.size());
  OddPart part;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (!is_good(ids[i])) places[i] = part.odd_points++;
  }
  VertexId next = part.odd_points;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (is_good(ids[i])) places[i] = next++;
  }

  Vector<Vec3<Real>> points(ids.size());
  part.ids.resize(ids.size());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    points[places[i]] = positions[i];
    part.ids[places[i]] = ids[i];
  }
  part.mesh.points = std::move(points);
  for (const OddCell& cell : odd_) {
    Tet tet;
    for (std::size_t k = 0; k < 4; ++k) {
      tet[k] = places[static_cast<std::size_t>(
          std::lower_bound(ids.begin(), ids.end(), cell.tet[k]) - ids.begin())];
    }
    part.mesh.tets.push_back(tet);
  }
  return part;
}

// All that is wrong lies at odd cells. The rim of their mesh, which has nothing to say, is of sound
// points, which are never sampled.
template <class Real>
void Examiner<Real>::find_samples() {
  if (odd_.empty()) return;
  OddPart part = odd_part();
  const Inspection inspection = inspect(part.mesh);
  const auto take = [&](Defect kind, std::uint32_t id, std::uint64_t in_file) {
    const auto k = static_cast<std::size_t>(kind);
    out_.mesh.samples[k].push_back(in_file);
    out_.mesh.places[k].push_back(place_of(part.mesh, kind, id));
  };
  const auto take_cells = [&](Defect kind, std::uint64_t in_part, std::uint64_t in_all) {
    if (in_part != in_all) return;
    for (const std::uint32_t t : inspection.first(kind).ids()) take(kind, t, odd_[t].row);
  };
  const InspectionSummary& all = out_.mesh;
  take_cells(Defect::kDegenerate, inspection.degenerate, all.degenerate);
  take_cells(Defect::kInverted, inspection.inverted, all.inverted);
  take_cells(Defect::kDuplicate, inspection.duplicate_tets, all.duplicate_tets);
  take_cells(Defect::kFoldoverFace, inspection.foldover_faces, all.foldover_faces);
  take_cells(Defect::kOverfullFace, inspection.overfull_faces, all.overfull_faces);
  if (description_.pieces != 1) return;
  for (const Defect kind : {Defect::kNonmanifoldEdge, Defect::kNonmanifoldVertex}) {
    for (const std::uint32_t v : inspection.first(kind).ids()) {
      if (v < part.odd_points) take(kind, v, part.ids[v]);
    }
  }
}

template <class Real>
Vector<Vec3<Real>> Examiner<Real>::positions_of(const Vector<VertexId>& ascending) const {
  Vector<Vec3<Real>> result, window;
  for (auto next = ascending.begin(); next != ascending.end();) {
    const std::uint64_t first = *next / kPointWindow * kPointWindow;
    window.resize(std::min(kPointWindow, points_ - first));
    stream_.read_points(first, window.size(), std::as_writable_bytes(std::span(window)));
    for (; next != ascending.end() && *next < first + window.size(); ++next) {
      result.push_back(window[*next - first]);
    }
  }
  return result;
}

template <class Real>
void Examiner<Real>::find_coincident() {
  tetfusion::find_coincident<Real>(
      stream_, context_,
      [&](std::size_t v) {
        return (flags_[v] & (kUnusedVertex | kCarriedVertex)) != kUnusedVertex;
      },
      [&](std::uint64_t turn, std::uint64_t turns) {
        context_.report("inspecting", 0.9, 1, turn, turns);
      },
      [&](VertexId later, VertexId) {
        ++out_.mesh.coincident_points;
        coincident_.add(later);
      });
  if (description_.pieces != 1) return;
  constexpr auto kKind = static_cast<std::size_t>(Defect::kCoincidentPoint);
  const std::vector<std::uint32_t>& ids = coincident_.ids();
  out_.mesh.samples[kKind].assign(ids.begin(), ids.end());
  for (const Vec3<Real>& p : positions_of(Vector<VertexId>(ids.begin(), ids.end()))) {
    out_.mesh.places[kKind].push_back({p.x, p.y, p.z});
  }
}

}  // namespace

MemoryNeeds needs_of_examination(const MeshDescription& mesh, const MeshStream& stream,
                                 std::uint64_t chunk_tets, int threads) {
  MeshDescription bare;
  bare.point_type = mesh.point_type;
  bare.points = mesh.points;
  bare.cells = mesh.cells;
  MemoryNeeds needs =
      estimate_needs(bare, {}, chunk_tets, threads, {stream.bytes(), stream.lower_cells()});
  for (std::uint64_t* bytes : {&needs.out_of_core, &needs.in_core}) {
    *bytes += kExtraPointBytes * mesh.points;
  }
  needs.scratch = needs.pieces;
  return needs;
}

Examination examine_chunks(const MeshDescription& mesh, const MeshStream& stream,
                           std::uint64_t chunk_tets, const RunContext& context,
                           MemoryBudget* budget, Scratch* scratch) {
  const auto run = [&]<class Real>(Real) {
    return Examiner<Real>(mesh, stream, context, budget).run(chunk_tets, scratch);
  };
  Examination found = mesh.point_type == ValueType::kFloat32 ? run(float{}) : run(double{});
  scratch->check();
  return found;
}

}  // namespace tetfusion
