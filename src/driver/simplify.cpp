#include "driver/simplify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "base/numbers.h"
#include "base/resources.h"
#include "driver/prepare.h"
#include "driver/result.h"
#include "driver/rounds.h"
#include "driver/steering.h"
#include "io/mesh_sink.h"
#include "io/mesh_source.h"
#include "mesh/inspect.h"
#include "partition/spatial_order.h"

namespace tetfusion {

namespace {

constexpr std::string_view kLodField = "{lod}";
// When less than this share of the tetrahedra has to go, it may go anywhere; more is spread over
// the mesh.
constexpr double kTrimShare = 1e-4;

// After so many rounds on end without a fusion, each cut elsewhere, the run ends. With chunks of only a few thousand
// tetrahedra some fusions on interfaces may then be left.
constexpr int kIdleRounds = 2;

// A mesh to write on the way, or at the end.
struct Stage {
  std::optional<std::uint64_t> tets;  // go on until so many are left; absent: until nothing fuses
  std::string path;
};

std::uint64_t tets_left(std::uint64_t tets, double reduction) {
  // Rounded up: never below the goal.
  return std::max<std::uint64_t>(
      1, static_cast<std::uint64_t>(std::ceil(static_cast<double>(tets) * (1 - reduction) - 1e-6)));
}

std::string level_path(const std::string& pattern, std::size_t level) {
  std::string path = pattern;
  const std::size_t at = path.find(kLodField);
  if (at != std::string::npos) path.replace(at, kLodField.size(), std::to_string(level));
  return path;
}

std::vector<Stage> plan_stages(const SimplifyRequest& request, std::uint64_t tets) {
  const BehaviourOptions& b = request.behaviour;
  std::vector<Stage> stages;
  for (const double lod : b.lods) stages.push_back({tets_left(tets, lod), ""});
  std::optional<std::uint64_t> goal = b.tets;
  if (b.reduction) goal = tets_left(tets, *b.reduction);
  if (stages.empty() || (goal && *goal < *stages.back().tets)) stages.push_back({goal, ""});
  for (std::size_t i = 0; i < stages.size(); ++i) {
    stages[i].path = level_path(request.output, i + 1);
  }
  return stages;
}

double at_lod(const std::vector<double>& schedule, std::size_t lod) {
  if (schedule.empty()) return std::numeric_limits<double>::infinity();
  return schedule[std::min(lod, schedule.size() - 1)];
}

[[noreturn]] void refuse(const std::string& message) { throw Error(ErrorCode::kUsage, message); }

void check_options(const SimplifyRequest& request) {
  const BehaviourOptions& b = request.behaviour;
  if (b.reduction && b.tets) refuse("--reduction and --tets are two goals: give one of them");
  if (b.reduction && !(*b.reduction >= 0 && *b.reduction < 1)) {
    refuse("--reduction must be at least 0% and less than 100%");
  }
  if (b.tets && *b.tets == 0) refuse("--tets must be at least 1");
  if (b.chunk_tets == 0) refuse("--chunk-tets must be at least 1");
  const auto positive = [](double v) { return v > 0; };
  if (!std::all_of(b.scalar_tolerance.begin(), b.scalar_tolerance.end(), positive)) {
    refuse("--scalar-tolerance must be greater than 0 (a share of the range), or off");
  }
  const auto at_least_one = [](double v) { return v >= 1; };
  if (!std::all_of(b.stretch_factor.begin(), b.stretch_factor.end(), at_least_one)) {
    refuse("--stretch-factor must be at least 1, or off");
  }
  if (!at_least_one(b.aspect_ratio)) refuse("--aspect-ratio must be at least 1");
  if (!std::is_sorted(b.lods.begin(), b.lods.end()))
    refuse("--lods must ascend, as in 50%,80%,95%");
  for (const double lod : b.lods) {
    if (!(lod >= 0 && lod < 1)) refuse("--lods must be at least 0% and less than 100%");
  }
  const bool has_field = request.output.find(kLodField) != std::string::npos;
  if (!b.lods.empty() && b.reduction && *b.reduction < b.lods.back()) {
    refuse(
        "--lods goes further than --reduction: give one of them, or a goal beyond the last level");
  }
  if (!b.lods.empty() && !has_field) {
    refuse(
        fmt::format("--lods writes several files: the name after -o must hold {{lod}}, as in "
                    "part_{{lod}}.vtu, but it is \"{}\"",
                    request.output));
  }
  if (b.lods.empty() && has_field) {
    refuse("the name after -o holds {lod}, but there is no --lods");
  }
}

class Job {
 public:
  Job(const SimplifyRequest& request, const RunContext& context)
      : request_(request), context_(context) {}
  SimplifyReport run();

 private:
  void describe_input(const Geometry& geometry, const Inspection& inspection);
  void say_what_is_odd(const Inspection& inspection);
  template <class Real>
  void run_stages(WorkMesh<Real> work);
  template <class Real>
  bool reach(const std::optional<std::uint64_t>& goal, Rounds<Real>* rounds, WorkMesh<Real>* work);
  template <class Real>
  void set_criteria(std::size_t lod, WorkMesh<Real>* work, PassLimits* limits);
  template <class Real>
  Result take_result(WorkMesh<Real>* work, bool last);
  void write(const Result& result, const std::string& path);
  void describe_output(Result* result);

  const SimplifyRequest& request_;
  const RunContext& context_;
  std::unique_ptr<MeshSource> source_;
  Geometry geometry_;  // its points and tetrahedra move on; what they came from stays
  Steering steering_;
  std::vector<Stage> stages_;
  FuseLog log_;
  PhaseClock clock_;
  SimplifyReport report_;
};

SimplifyReport Job::run() {
  const double start = wall_seconds();
  check_options(request_);
  set_thread_count(request_.performance.threads);
  report_.threads = thread_count();
  for (const Stage& stage : plan_stages(request_, kMaxTets)) check_mesh_output(stage.path);

  context_.report("reading", 0);
  clock_.begin("read");
  source_ =
      open_mesh(request_.input, {request_.behaviour.tetrahedralize, request_.behaviour.linearize});
  const auto choices = choose_steering(source_->description(), request_.behaviour.arrays);
  const auto regions = choose_regions(source_->description(), request_.behaviour.regions);
  geometry_ = source_->read_geometry();
  context_.check();

  clock_.begin("order");
  context_.report("ordering", 0.05);
  order_along_curve(&geometry_);
  context_.check();

  clock_.begin("inspect");
  context_.report("inspecting", 0.1);
  const Inspection inspection = inspect(geometry_);
  describe_input(geometry_, inspection);
  context_.check();

  clock_.begin("prepare");
  steering_ = load_steering(choices, geometry_, context_, source_.get());
  report_.steering = steering_.names;
  for (const std::size_t i : regions) {
    report_.regions.push_back(source_->description().cell_data.arrays[i].name);
  }
  const Vector<std::uint8_t> interfaces = find_interfaces(regions, geometry_, source_.get());
  say_what_is_odd(inspection);
  stages_ = plan_stages(request_, geometry_.tets.size());
  if (request_.behaviour.tets && *stages_.back().tets < *request_.behaviour.tets) {
    refuse("--lods goes further than --tets: give one of them, or a goal beyond the last level");
  }
  report_.has_goal = stages_.back().tets.has_value();
  if (point_type(geometry_.points) == ValueType::kFloat32) {
    run_stages(make_work_mesh<float>(inspection, interfaces, &steering_, &geometry_));
  } else {
    run_stages(make_work_mesh<double>(inspection, interfaces, &steering_, &geometry_));
  }
  clock_.end();
  report_.seconds = clock_.seconds();
  report_.total_seconds = wall_seconds() - start;
  report_.cpu_seconds = cpu_seconds();
  report_.peak_rss_bytes = peak_rss_bytes();
  context_.report("done", 1);
  return std::move(report_);
}

void Job::describe_input(const Geometry& geometry, const Inspection& inspection) {
  report_.input = {request_.input, point_count(geometry.points), geometry.tets.size(),
                   inspection.boundary_faces, inspection.volume};
  report_.oddities = {inspection.rewound,
                      inspection.degenerate,
                      inspection.inverted,
                      inspection.duplicate_tets,
                      inspection.foldover_faces + inspection.overfull_faces,
                      geometry.unused_points,
                      geometry.merged_points,
                      geometry.ghost_cells,
                      0};
}

void Job::say_what_is_odd(const Inspection& inspection) {
  const Oddities& odd = report_.oddities;
  const auto say = [&](std::uint64_t count, std::string_view what) {
    if (count > 0) context_.say(fmt::format("{} {}", format_count(count), what));
  };
  say(odd.rewound, "tetrahedra were wound the other way: rewound");
  say(odd.degenerate, "tetrahedra have no volume: they and their vertices stay as they are");
  say(odd.inverted, "tetrahedra are inverted: they and their vertices stay as they are");
  say(odd.duplicate_tets,
      "tetrahedra are duplicates of others: they and their vertices stay as they are");
  say(odd.nonconforming_faces, "faces do not conform: their tetrahedra stay as they are");
  say(inspection.nonmanifold_edges, "boundary edges are not manifold: they stay as they are");
  say(inspection.coincident_points, "points coincide with others: taken as different points");
  say(odd.unused_points, "points are used by no cell: dropped");
  say(odd.merged_points, "points at the seams of pieces were merged");
  say(odd.ghost_cells, "ghost cells were dropped");
  if (steering_.fields.empty()) context_.say("no array steers: geometry alone decides");
  for (const std::string& name : report_.regions) {
    context_.say(fmt::format(
        "interfaces of cell array {} are kept (--regions none switches that off)", name));
  }
}

template <class Real>
void Job::run_stages(WorkMesh<Real> work) {
  report_.oddities.locked_vertices = static_cast<std::uint64_t>(
      std::count_if(work.marks.begin(), work.marks.end(),
                    [](std::uint8_t m) { return (m & (kLocked | kOnBoundary)) == kLocked; }));
  auto rounds = std::make_unique<Rounds<Real>>(request_.behaviour.chunk_tets, thread_count());
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    clock_.begin("passes");
    const bool reached = reach(stages_[i].tets, rounds.get(), &work);
    const bool last = i + 1 == stages_.size() || !reached;
    if (!reached && i + 1 < stages_.size()) {
      context_.say(fmt::format("level {} of {} could not be reached: {} holds the last macroLoD",
                               i + 1, stages_.size(), stages_[i].path));
    }
    clock_.begin("write");
    if (last) rounds.reset();
    Result result = take_result(&work, last);
    write(result, stages_[i].path);
    if (!last) continue;
    report_.stop_reason = reached ? StopReason::kGoal : StopReason::kSaturated;
    describe_output(&result);
    return;
  }
}

// Runs rounds until the goal is reached (true) or nothing fuses (false).
template <class Real>
bool Job::reach(const std::optional<std::uint64_t>& goal, Rounds<Real>* rounds,
                WorkMesh<Real>* work) {
  const BehaviourOptions& b = request_.behaviour;
  const std::size_t schedule = std::max(b.scalar_tolerance.size(), b.stretch_factor.size());
  const std::uint64_t first_tets = report_.input.tets;
  PassLimits limits;
  limits.boundary_rule = b.boundary_rule;
  limits.aspect_ratio = b.aspect_ratio;
  int idle_rounds = 0;
  bool spread = true;
  while (true) {
    const std::uint64_t tets = work->tets.size();
    if (goal && tets <= *goal) return true;
    const double done =
        static_cast<double>(first_tets - tets) / static_cast<double>(first_tets - goal.value_or(0));
    context_.report("fusing", 0.2 + 0.6 * done);

    const std::size_t lod = report_.lods.size();
    set_criteria(lod, work, &limits);
    if (goal) {
      limits.quota = tets - *goal;
      limits.spread =
          spread && static_cast<double>(limits.quota) > kTrimShare * static_cast<double>(tets);
    }
    const double start = wall_seconds();
    const RoundStatistics round = rounds->run(limits, steering_.fields, context_, work, &log_);
    report_.lods.push_back({round.pass, limits.scalar_tolerance, limits.stretch_factor,
                            round.chunks, wall_seconds() - start});

    const auto rejected = [&](Reject r) {
      return round.pass.rejected[static_cast<std::size_t>(r)] > 0;
    };
    if (round.pass.fused > 0) {
      spread = true;
      idle_rounds = 0;
    } else if (rejected(Reject::kQuota) && limits.spread) {
      spread = false;  // the little that is left may be anywhere
    } else if (rejected(Reject::kQuota)) {
      return true;  // every fusion that is allowed would go below the goal
    } else if (lod + 1 >= schedule) {
      // What lies on this cut's interface may still fuse: another cut has the last word.
      if (!rejected(Reject::kInterface) || ++idle_rounds == kIdleRounds) return false;
    }
  }
}

// The criteria of a macroLoD, and its number.
template <class Real>
void Job::set_criteria(std::size_t lod, WorkMesh<Real>* work, PassLimits* limits) {
  const BehaviourOptions& b = request_.behaviour;
  const double scalar_before = limits->scalar_tolerance;
  limits->scalar_tolerance = at_lod(b.scalar_tolerance, lod);
  limits->stretch_factor = at_lod(b.stretch_factor, lod);
  constexpr std::size_t kNumbers = std::numeric_limits<std::uint16_t>::max();
  limits->number = static_cast<std::uint16_t>(lod % kNumbers + 1);
  // What the mesh remembers is by number, and holds while the tolerance does not narrow.
  if (limits->number == 1 || limits->scalar_tolerance < scalar_before) {
    std::fill(work->flipped.begin(), work->flipped.end(), std::uint16_t{0});
    std::fill(work->changed.begin(), work->changed.end(), std::uint16_t{0});
  }
}

template <class Real>
Result Job::take_result(WorkMesh<Real>* work, bool last) {
  Result result;
  if (last) {
    result = {{}, std::move(work->point_ids), std::move(work->tet_ids)};
    result.mesh.tets = std::move(work->tets);
    result.mesh.points = std::move(work->positions);
    *work = {};
  } else {
    result = {{}, work->point_ids, work->tet_ids};
    result.mesh.tets = work->tets;
    result.mesh.points = work->positions;
  }
  const LowerCells& lower = geometry_.lower;
  if (lower.size() == 0) return result;
  Vector<VertexId> new_id;
  new_id.assign(report_.input.points, kNoVertex);
  for (std::size_t p = 0; p < result.point_ids.size(); ++p) {
    new_id[result.point_ids[p]] = static_cast<VertexId>(p);
  }
  result.mesh.lower = lower;
  for (VertexId& v : result.mesh.lower.connectivity) v = new_id[v];
  return result;
}

void Job::write(const Result& result, const std::string& path) {
  WriteOptions options;
  options.encoding = request_.encoding;
  options.progress = [&](double share) {
    context_.check();
    context_.report("writing", 0.8 + 0.2 * share);
  };
  const InputRows rows{geometry_.point_source, geometry_.tet_source, geometry_.lower_source};
  write_result(result, log_, rows, path, options, source_.get());
  report_.outputs.push_back(path);
}

void Job::describe_output(Result* result) {
  clock_.begin("measure");
  const Inspection inspection = inspect(result->mesh);
  report_.output = {report_.outputs.back(), point_count(result->mesh.points),
                    result->mesh.tets.size(), inspection.boundary_faces, inspection.volume};
}

}  // namespace

SimplifyReport simplify(const SimplifyRequest& request, const RunContext& context) {
  return Job(request, context).run();
}

}  // namespace tetfusion
