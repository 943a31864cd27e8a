#include "verify/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/numbers.h"
#include "compare/compare.h"
#include "compare/interfaces.h"
#include "io/open_mesh.h"
#include "mesh/inspection/inspect.h"
#include "mesh/predicates.h"
#include "verify/kept_cells.h"

namespace tetfusion {

namespace {

// Of the work: inspecting the result, and comparing it.
constexpr double kInspected = 0.2;
constexpr double kCompared = 0.9;

// What `--conserve` promises of an integral, as a share of that of the absolute value.
constexpr double kIntegral64 = 1e-12;
constexpr double kIntegral32 = 1e-6;

// What rounding may do to a volume, as a share of it.
constexpr double kVolume = 1e-6;

std::string place(const Point& p) { return fmt::format("({:.9g}, {:.9g}, {:.9g})", p.x, p.y, p.z); }

Point point_of(const Geometry& mesh, VertexId v) {
  return std::visit(
      [&](const auto& points) {
        return Point{points[v].x, points[v].y, points[v].z};
      },
      mesh.points);
}

Point centre_of(const Geometry& mesh, TetId t) {
  Point sum{};
  for (const VertexId v : mesh.tets[t]) sum = sum + point_of(mesh, v);
  return 0.25 * sum;
}

class Verifier {
 public:
  Verifier(MeshSource* original, std::string path, const Promise& promise, std::uint64_t sides,
           const RunContext& context)
      : original_(original),
        path_(std::move(path)),
        promise_(promise),
        sides_(sides),
        context_(context) {}

  Verification run() {
    out_.not_verified = promise_.beyond;
    try {
      const auto result = open_mesh(path_);
      judge_description(result->description());
      inspect_result(result.get());
      // Of a mesh that is none the rest would tell nothing.
      if (readable_) compare(result.get());
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kBadInput) throw;
      fail("readable", "it cannot be read again: " + in_words(error.what()));
    }
    return std::move(out_);
  }

 private:
  void add(std::string name, double found, double allowed, bool kept, std::string sentence) {
    out_.checks.push_back(
        {std::move(name), found, allowed, kept, kept ? std::string() : std::move(sentence)});
  }
  void fail(std::string name, std::string sentence) {
    add(std::move(name), 1, 0, false, std::move(sentence));
  }
  void count(std::string name, std::uint64_t found, std::uint64_t expected, std::string_view what) {
    add(std::move(name), static_cast<double>(found), static_cast<double>(expected),
        found == expected,
        fmt::format("{}: it has {}, where {} were written", what, format_count(found),
                    format_count(expected)));
  }

  std::string in_words(std::string text) const {
    for (std::size_t at; (at = text.find(path_)) != std::string::npos;) {
      text.replace(at, path_.size(), "the result");
    }
    return text;
  }

  RunContext part(double from, double to) const {
    RunContext context;
    context.progress = [this, from, to](std::string_view, double share) {
      context_.report("verifying", from + (to - from) * share);
    };
    context.cancelled = context_.cancelled;
    return context;
  }

  void judge_description(const MeshDescription& result);
  void inspect_result(MeshSource* result);
  void judge_defect(const Geometry& mesh, const Inspection& inspection, std::string name,
                    std::string_view what, std::uint64_t found, std::uint64_t allowed,
                    std::initializer_list<Defect> kinds);
  void judge_cells(const Geometry& mesh);
  void compare(MeshSource* result);
  void judge_surface(std::string name, std::string_view what, bool identical, const Point& differs,
                     const SurfaceShares& to_result, const SurfaceShares& to_original,
                     double rounding);
  void judge_topology(const Comparison& comparison);
  void judge_regions(MeshSource* result, const Comparison& comparison);
  void judge_volumes(const ArrayComparison& a, const Comparison& comparison);
  void judge_array(const Comparison& comparison, const ArrayComparison& a);
  void judge_error(const Comparison& comparison, const PromisedError& promised);
  void judge_integral(const Comparison& comparison, const ArrayComparison& a);
  void judge_measure(VerifiedCheck check, const std::string& what, const Point* at);
  bool cells_overlap_at(const Point& p) const;
  bool is_region(const ArrayComparison& a) const {
    const auto& names = promise_.regions;
    return a.association == Association::kCell &&
           std::find(names.begin(), names.end(), a.info.name) != names.end();
  }

  bool input_overlaps() const {
    return promise_.inverted + promise_.duplicate_tets + promise_.nonconforming_faces > 0;
  }

  MeshSource* original_;
  const std::string path_;
  const Promise& promise_;
  const std::uint64_t sides_;
  const RunContext& context_;
  Verification out_;
  bool readable_ = false;
};

void Verifier::judge_description(const MeshDescription& result) {
  const ArrayMatch match = match_arrays(original_->description(), result);
  const bool same_points = result.point_type == original_->description().point_type;
  add("point type", same_points ? 0 : 1, 0, same_points,
      fmt::format("its points are {}, the input's are {}", vtk_name(result.point_type),
                  vtk_name(original_->description().point_type)));
  std::vector<std::string> missing = match.missing;
  std::erase_if(missing, [&](const std::string& name) {
    return std::find(promise_.dropped.begin(), promise_.dropped.end(), name) !=
           promise_.dropped.end();
  });
  add("missing arrays", static_cast<double>(missing.size()), 0, missing.empty(),
      fmt::format("it lacks the arrays {}", fmt::join(missing, ", ")));
  std::vector<std::string> retyped;
  for (const RetypedArray& r : match.retyped) {
    retyped.push_back(fmt::format("{} ({}, was {})", r.name, r.simplified, r.original));
  }
  add("retyped arrays", static_cast<double>(retyped.size()), 0, retyped.empty(),
      fmt::format("arrays have another type: {}", fmt::join(retyped, ", ")));
}

void Verifier::inspect_result(MeshSource* result) {
  context_.report("verifying", 0);
  Geometry mesh = result->read_geometry();
  context_.check();
  readable_ = true;
  count("points", point_count(mesh.points) + mesh.unused_points, promise_.points, "points");
  count("tets", mesh.tets.size(), promise_.tets, "tetrahedra");
  const auto& types = promise_.lower_types;
  const bool same_lower =
      std::equal(types.begin(), types.end(), mesh.lower.types.begin(), mesh.lower.types.end());
  add("lower cells", static_cast<double>(mesh.lower.size()), static_cast<double>(types.size()),
      same_lower,
      fmt::format("cells of lower dimension: it has {}, the input {}, or of other kinds",
                  format_count(mesh.lower.size()), format_count(types.size())));
  judge_cells(mesh);
  const Inspection i = inspect(mesh);
  context_.check();
  const auto judge = [&](std::string name, std::string_view what, std::uint64_t found,
                         std::uint64_t allowed, std::initializer_list<Defect> kinds) {
    judge_defect(mesh, i, std::move(name), what, found, allowed, kinds);
  };
  judge("inverted", "inverted cells", i.inverted, promise_.inverted, {Defect::kInverted});
  judge("duplicate_tets", "duplicate cells", i.duplicate_tets, promise_.duplicate_tets,
        {Defect::kDuplicate});
  judge("nonconforming_faces", "faces that do not conform", i.foldover_faces + i.overfull_faces,
        promise_.nonconforming_faces, {Defect::kFoldoverFace, Defect::kOverfullFace});
  judge("degenerate", "degenerate cells", i.degenerate, promise_.degenerate, {Defect::kDegenerate});
  judge("nonmanifold_edges", "boundary edges that are not manifold", i.nonmanifold_edges,
        promise_.nonmanifold_edges, {Defect::kNonmanifoldEdge});
}

void Verifier::judge_defect(const Geometry& mesh, const Inspection& inspection, std::string name,
                            std::string_view what, std::uint64_t found, std::uint64_t allowed,
                            std::initializer_list<Defect> kinds) {
  std::string where;
  for (const Defect kind : kinds) {
    const auto& ids = inspection.first(kind).ids();
    if (ids.empty() || !where.empty()) continue;
    where =
        place(kind == Defect::kNonmanifoldEdge ? point_of(mesh, ids[0]) : centre_of(mesh, ids[0]));
  }
  add(std::move(name), static_cast<double>(found), static_cast<double>(allowed), found <= allowed,
      fmt::format("{}: it has {}, the input {}; the first at {}", what, format_count(found),
                  format_count(allowed), where));
}

void Verifier::judge_cells(const Geometry& mesh) {
  const bool bounded = promise_.max_volume < std::numeric_limits<double>::infinity();
  if (promise_.interest.empty() && !bounded) return;
  const auto keys = promise_.interest.empty() ? Vector<std::uint64_t>() : cell_keys(mesh);
  const OriginalCellFacts facts = survey_cells(original_, promise_.interest, keys, context_);
  if (!promise_.interest.empty()) {
    add("region of interest", static_cast<double>(facts.missing), 0, facts.missing == 0,
        fmt::format("of {} in the region of interest it lacks {}, the first at {}",
                    format_count(facts.inside, "cell"), format_count(facts.missing),
                    place(facts.first_missing)));
  }
  if (!bounded) return;
  const double allowed = std::max(promise_.max_volume, facts.largest_volume);
  const double found = largest_volume(mesh);
  add("largest volume", found, allowed, found <= allowed * (1 + kVolume),
      fmt::format("its largest cell has the volume {:.9g}, where {:.9g} is allowed", found,
                  allowed));
}

void Verifier::compare(MeshSource* result) {
  const Comparison comparison =
      compare_meshes(original_, result, part(kInspected, kCompared), sides_);
  judge_surface("boundary", "boundary", comparison.identical_surface, comparison.surface_differs_at,
                comparison.to_simplified, comparison.to_original, comparison.rounding);
  judge_topology(comparison);
  if (!promise_.regions.empty()) judge_regions(result, comparison);
  for (const ArrayComparison& a : comparison.arrays) {
    if (is_region(a) && !a.regions.empty()) judge_volumes(a, comparison);
    judge_array(comparison, a);
  }
  for (const PromisedError& promised : promise_.errors) judge_error(comparison, promised);
}

void Verifier::judge_surface(std::string name, std::string_view what, bool identical,
                             const Point& differs, const SurfaceShares& to_result,
                             const SurfaceShares& to_original, double rounding) {
  if (!promise_.distance) {
    add(std::move(name), identical ? 0 : 1, 0, identical,
        fmt::format("the triangles of its {} are others than the input's, at {}", what,
                    place(differs)));
    return;
  }
  const bool first = to_result.max >= to_original.max;
  const double found = identical ? 0 : std::max(to_result.max, to_original.max);
  // Where the diagonal is no number of double precision, the rounding is none.
  const bool is_kept = found <= *promise_.distance || found <= *promise_.distance + rounding;
  add(std::move(name), found, *promise_.distance, is_kept,
      fmt::format("its {} is {:.4g} % of the diagonal from the input's, above {:.4g} %, at {}",
                  what, 100 * found, 100 * *promise_.distance,
                  place(first ? to_result.max_at : to_original.max_at)));
}

void Verifier::judge_topology(const Comparison& comparison) {
  const SurfaceTopology& before = comparison.original.boundary;
  const SurfaceTopology& after = comparison.simplified.boundary;
  add("boundary parts", static_cast<double>(after.parts), static_cast<double>(before.parts),
      after.parts == before.parts,
      fmt::format("its boundary has {}, the input's {}", format_count(after.parts, "part"),
                  before.parts));
  add("boundary euler number", static_cast<double>(after.euler), static_cast<double>(before.euler),
      after.euler == before.euler,
      fmt::format("the Euler number of its boundary is {}, the input's {}: a hole or a tunnel has "
                  "come or gone",
                  after.euler, before.euler));
}

void Verifier::judge_regions(MeshSource* result, const Comparison& comparison) {
  const InterfaceComparison i =
      compare_interfaces(original_, result, promise_.regions, part(kCompared, 1));
  const auto shares = [&](const OneSidedDistance& d) {
    const double diagonal = comparison.diagonal;
    return SurfaceShares{diagonal > 0 ? d.max / diagonal : d.max, 0, d.max_at};
  };
  judge_surface("interfaces", "interfaces of regions", i.distance.identical, i.distance.differs_at,
                shares(i.distance.first_to_second), shares(i.distance.second_to_first),
                comparison.rounding);
}

// Where interfaces stay, so do the volumes between them.
void Verifier::judge_volumes(const ArrayComparison& a, const Comparison& comparison) {
  const double allowed = comparison.volume_error;
  if (promise_.distance || !std::isfinite(allowed)) return;  // or too large for a double
  double most = 0, value = 0;
  for (const RegionVolume& region : a.regions) {
    const double change = std::abs(region.simplified - region.original);
    if (change > most) value = region.value;
    most = std::max(most, change);
  }
  add("region volumes:" + a.info.name, most, allowed, most <= allowed,
      fmt::format("the volume of region {} of {} has changed by {:.4g}", value, a.info.name, most));
}

void Verifier::judge_array(const Comparison& comparison, const ArrayComparison& a) {
  if (a.integer) return;
  const bool cells = a.association == Association::kCell;
  const std::string name = (cells ? "cell:" : "") + a.info.name;
  // What is not finite spreads to what is fused with it.
  if (a.non_finite == 0) {
    add("finite:" + name, static_cast<double>(a.simplified_non_finite), 0,
        a.simplified_non_finite == 0,
        fmt::format("{} is not finite at {}, the input's is everywhere", name,
                    format_count(a.simplified_non_finite, cells ? "cell" : "point")));
  }
  // Where a region's interfaces may move, what they enclose may change by as much.
  if (promise_.integrals && !(is_region(a) && promise_.distance)) judge_integral(comparison, a);
}

// Where cells overlap, or are turned over, nobody knows which of them a point lies in. Integrals
// are of the whole mesh: there `at` is null.
void Verifier::judge_measure(VerifiedCheck check, const std::string& what, const Point* at) {
  if (!check.kept && (at != nullptr ? cells_overlap_at(*at) : input_overlaps())) {
    out_.not_verified.push_back(
        fmt::format("{} came out as {:.4g}, above {:.4g}, but cells overlap there", what,
                    check.found, check.allowed));
    return;
  }
  if (check.kept) check.sentence.clear();
  out_.checks.push_back(std::move(check));
}

// Parts that overlap are each as they should be: only a point in several cells tells.
bool Verifier::cells_overlap_at(const Point& p) const {
  const Geometry mesh = open_mesh(path_)->read_geometry();
  std::uint64_t inside = 0, touched = 0;
  for (const Tet& t : mesh.tets) {
    const std::array<Point, 4> corners{point_of(mesh, t[0]), point_of(mesh, t[1]),
                                       point_of(mesh, t[2]), point_of(mesh, t[3])};
    const int side = determinant(corners[0], corners[1], corners[2], corners[3]).sign();
    int least = 1;
    for (std::size_t i = 0; i < 4; ++i) {
      std::array<Point, 4> moved = corners;
      moved[i] = p;
      least = std::min(least, side * determinant(moved[0], moved[1], moved[2], moved[3]).sign());
    }
    if (side != 0 && least >= 0) ++touched;
    if (side != 0 && least > 0) ++inside;
  }
  return inside > 0 && touched > 1;
}

void Verifier::judge_error(const Comparison& comparison, const PromisedError& promised) {
  Bounds bounds;
  bounds.max_error = promised.share;
  bounds.arrays = {promised.array};
  for (const BoundResult& bound : judge_bounds(comparison, bounds)) {
    const auto is_it = [&](const ArrayComparison& a) {
      return a.association == Association::kPoint && a.info.name == bound.array;
    };
    const auto a = std::find_if(comparison.arrays.begin(), comparison.arrays.end(), is_it);
    if (a == comparison.arrays.end()) continue;  // another check tells of it
    if (a->range == 0) continue;                 // it has not steered
    const std::string sentence =
        a->undefined > 0
            ? fmt::format(
                  "{} is not finite at {} of the input where the input's is, the first at {}",
                  bound.array, format_count(a->undefined, "point"), place(a->undefined_at))
            : fmt::format("the largest error of {} is {:.4g} % of its range, above {:.4g} %, at {}",
                          bound.array, 100 * bound.value, 100 * bound.limit, place(a->max_at));
    judge_measure({"error:" + bound.array, bound.value, bound.limit, !bound.broken, sentence},
                  "the largest error of " + bound.array,
                  a->undefined > 0 ? &a->undefined_at : &a->max_at);
  }
}

// Where the boundary moves, if only by the rounding of coordinates, the domain changes, and the
// integral with it: that of a constant as well, but for what comes to as much as goes.
void Verifier::judge_integral(const Comparison& comparison, const ArrayComparison& a) {
  const bool cells = a.association == Association::kCell;
  const std::string name = (cells ? "cell:" : "") + a.info.name;
  if (a.non_finite > 0) {
    out_.not_verified.push_back(fmt::format("the integral of {}, which is not finite", name));
    return;
  }
  const bool single = a.info.type == ValueType::kFloat32;
  double volume = 1;  // by how much of it, in units of what its rounding may be
  if (promise_.distance && comparison.volume_error > 0) {
    volume += comparison.volume_between / comparison.volume_error;
  }
  const double allowed = (single ? kIntegral32 : kIntegral64) + volume * a.integral_rounding;
  const double change = std::abs(a.integral_change);
  judge_measure({"integral:" + name, change, allowed, change <= allowed,
                 fmt::format("the integral of {} has changed by {:.4g} of that of its absolute "
                             "value, more than {:.4g}",
                             name, change, allowed)},
                "the change of the integral of " + name, nullptr);
}

}  // namespace

bool Verification::kept() const {
  return std::all_of(checks.begin(), checks.end(), [](const auto& c) { return c.kept; });
}

std::string Verification::complaint() const {
  std::string text;
  for (const VerifiedCheck& check : checks) {
    if (!check.kept) text += (text.empty() ? "" : "; ") + check.sentence;
  }
  return text;
}

Verification verify_result(MeshSource* original, const std::string& result, const Promise& promise,
                           std::uint64_t sides, const RunContext& context) {
  return Verifier(original, result, promise, sides, context).run();
}

}  // namespace tetfusion
