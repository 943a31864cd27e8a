#include "series/shared_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "base/numbers.h"
#include "base/resources.h"
#include "base/tasks.h"
#include "driver/arrays/notices.h"
#include "driver/arrays/regions.h"
#include "driver/request/error_limits.h"
#include "driver/run_setup.h"
#include "driver/scratch_place.h"
#include "driver/simplify.h"
#include "follow/apply_map.h"
#include "io/files/output_file.h"
#include "io/progressive/map_file.h"
#include "series/bound_search.h"
#include "series/combined_steps.h"
#include "series/fitted_steps.h"
#include "series/result_mesh.h"
#include "series/run_part.h"
#include "series/step_output.h"
#include "series/step_source.h"
#include "series/work_folder.h"

namespace tetfusion {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Where a step has a value and the result none, it is as if that was off by so many times the
// bound.
constexpr double kLostValue = 2;

class SharedSeries {
 public:
  SharedSeries(const SeriesRequest& request, SeriesPlan* plan, const RunContext& context)
      : job_(request.job), plan_(*plan), context_(context), folder_(scratch_folder(request.job)) {
    context_.abandoned = &failed_;
  }

  SeriesReport run();

 private:
  void require_end() const;
  void say_what_does_not_steer() const;
  std::uint64_t memory_to_write() const;
  void simplify_and_compare();
  void simplify_within_bounds();
  bool simplify_without_bounds();
  void simplify_once(std::optional<double> share);
  SimplifyRequest job(std::optional<double> share) const;
  bool tries_without_bounds() const;
  bool has_goal() const { return job_.behaviour.reduction || job_.behaviour.tets; }
  double bound_of(const SteeringChoice& array) const;
  std::vector<BoundSearch::Worst> fit_steps();
  BoundSearch::Worst note_errors(std::size_t step, const std::vector<ArrayFit>& fits,
                                 const std::vector<MovedArray>& moved);
  void write();

  const SimplifyRequest& job_;  // what is asked for each step
  SeriesPlan& plan_;
  RunContext context_;
  std::atomic<bool> failed_{false};
  const WorkFolder folder_;
  const StepFiles files_{job_.behaviour, plan_, open_options(job_, folder_.path(), context_)};
  BoundSearch search_{has_goal(), files_.count()};
  std::optional<CombinedSteps> steps_;  // when they have been read
  int at_once_ = 1;                     // so many steps are in hand together: 1 or 2
  std::unique_ptr<MapFile> map_;        // of the last simplification
  std::optional<FittedSteps> fitted_;   // to its mesh
  PhaseClock clock_;
  SeriesReport report_;
};

SeriesReport SharedSeries::run() {
  set_thread_count(job_.performance.threads);
  clock_.begin("steps");
  for (const Step& step : plan_.steps) {
    report_.steps.push_back({step.label, step.input, step.output, {}, {}});
  }
  steps_.emplace(job_.behaviour, files_, folder_.path(), search_.sums(), context_);
  at_once_ = steps_->at_once();
  require_end();
  say_what_does_not_steer();
  simplify_and_compare();
  clock_.begin("write steps");
  std::optional<OutputFile> map;
  if (!job_.map.empty()) {
    map.emplace(job_.map);
    map->append(map_->bytes().data(), map_->bytes().size());
    map->finish();
  }
  write();
  if (map) map->commit();
  clock_.end();
  report_.runs[0].seconds = clock_.seconds();
  return std::move(report_);
}

// As of a single mesh (read_steering()), in whose arrays sums have other names.
void SharedSeries::require_end() const {
  const BehaviourOptions& b = job_.behaviour;
  if (b.method != Method::kFuse || has_goal() || !b.arrays.empty()) return;
  const CombinedFields& sums = steps_->sums();
  for (std::size_t f = 0; f < sums.fields().size(); ++f) {
    if (sums.range(f) > 0) return;
  }
  throw no_end_in_sight(files_[0].input, steps_->arrays(), steps_->first());
}

// In the run itself sums have other names, of which nothing is said.
void SharedSeries::say_what_does_not_steer() const {
  const CombinedFields& sums = steps_->sums();
  std::vector<bool> steers(steps_->arrays().size());
  for (std::size_t f = 0; f < sums.fields().size(); ++f) {
    if (sums.range(f) > 0) steers[sums.array_of(f)] = true;
  }
  for (std::size_t a = 0; a < steers.size(); ++a) {
    if (!steers[a]) say_does_not_steer(steps_->arrays()[a].name, context_);
  }
}

// Of what the goal leaves. Without a goal nobody knows how much that is.
std::uint64_t SharedSeries::memory_to_write() const {
  if (!has_goal()) return 0;
  const BehaviourOptions& b = job_.behaviour;
  const MeshDescription& mesh = steps_->first();
  const auto cells = static_cast<double>(std::max<std::uint64_t>(mesh.cells, 1));
  const auto points = static_cast<double>(mesh.points);
  const double left =
      std::min(b.tets ? static_cast<double>(*b.tets) / cells : 1 - *b.reduction, 1.0);
  // On the boundary points may stay: as many as a cube has there, or where there are fewer than 24
  // tetrahedra round each as many as have half of these.
  const double on_boundary =
      std::min(std::max(2 * points - cells / 3, 6 * std::cbrt(points * points)), points);
  const double points_left = points - (1 - left) * (points - on_boundary);
  const auto [once, of_step] =
      step_memory(static_cast<std::uint64_t>(points_left), static_cast<std::uint64_t>(left * cells),
                  steps_->widths());
  return once + of_step;
}

// Reading all of all steps takes a disk as long as simplifying takes the processors. What fails
// ends the other, too; a mesh that is another one is said before what may have come of it.
void SharedSeries::simplify_and_compare() {
  if (!steps_->is_to_compare()) return simplify_within_bounds();
  run_tasks(2, at_once_, [&](std::size_t task, std::size_t) {
    try {
      if (task == 0) return steps_->compare();
      simplify_within_bounds();
      clock_.begin("steps");  // what is left of comparing
    } catch (...) {
      failed_ = true;
      throw;
    }
  });
}

void SharedSeries::simplify_within_bounds() {
  report_.tries = 0;
  if (simplify_without_bounds()) return;
  for (;;) {
    simplify_once(search_.share());
    const std::vector<BoundSearch::Worst> worst = fit_steps();
    const SimplifyReport& run = report_.runs[0];
    const bool reached = run.has_goal && run.stop_reason == StopReason::kGoal;
    const BoundSearch::Next next = search_.after(report_.tries, worst, reached, context_);
    if (next == BoundSearch::Next::kDone) return;
    if (next == BoundSearch::Next::kOtherSums) steps_->add_up_again(search_.sums(), at_once_);
  }
}

// The first try, where there is a goal, as that is often reached long before the bounds are: are
// they kept without being looked at on the way?
bool SharedSeries::simplify_without_bounds() {
  if (!tries_without_bounds()) return false;
  try {
    simplify_once(std::nullopt);
    const auto is_kept = [](const BoundSearch::Worst& step) { return step.used <= 1; };
    if (std::ranges::all_of(fit_steps(), is_kept)) return true;
  } catch (const OutOfReach&) {  // nothing was written
  }
  context_.say("the goal alone would break the bound on the error: once more, with bounds");
  return false;
}

bool SharedSeries::tries_without_bounds() const {
  const auto is_bounded = [&](const SteeringChoice& a) { return bound_of(a) < kInfinity; };
  return has_goal() && std::any_of(steps_->arrays().begin(), steps_->arrays().end(), is_bounded);
}

void SharedSeries::simplify_once(std::optional<double> share) {
  ++report_.tries;
  RunContext context = part_of_run(context_, 0.2, 0.6);
  if (report_.tries > 1) context.notice = {};
  const SimplifyRequest job = this->job(share);
  map_.reset();
  clock_.begin("simplify");
  report_.runs = {simplify(job, steps_->mesh(), context)};
  clock_.begin("fit");
  map_ = std::make_unique<MapFile>(MapFile::open(folder_.map()));
}

// With bounds for the sums of so large a share of the steps', or without.
SimplifyRequest SharedSeries::job(std::optional<double> share) const {
  SimplifyRequest job = job_;
  job.input = files_[0].input;
  job.output = folder_.mesh();
  job.map = folder_.map();
  job.map_homes = !job_.map.empty() || steps_->widths().widest_cell > 0;
  job.encoding = Encoding::kRaw;
  job.performance.scratch = folder_.chunks();
  job.performance.keep_work = false;
  job.performance.memory_afterwards = memory_to_write();
  BehaviourOptions& b = job.behaviour;
  b.fit_values = false;  // those of each step are
  b.interest = steps_->interest();
  b.arrays.clear();
  const CombinedFields& sums = steps_->sums();
  double largest = 1;
  double least_bound = kInfinity;
  for (std::size_t f = 0; f < sums.fields().size(); ++f) {
    if (!(sums.range(f) > 0)) continue;
    const SteeringChoice& array = steps_->arrays()[sums.array_of(f)];
    const double bound = bound_of(array) / sums.range(f);
    least_bound = std::min(least_bound, bound);
    std::string text = sums.fields()[f].name;
    if (bound < kInfinity) {
      // No error is larger than the range. Where there is no goal a run without any bound takes
      // one by itself.
      const double wanted = std::min(share.value_or(1) * bound, 1.0);
      if (share && (wanted < 1 || !has_goal())) text = with_tolerance(text, wanted);
    } else if (array.tolerance) {
      text = with_tolerance(text, *array.tolerance);
    }
    b.arrays.push_back(std::move(text));
    largest = std::max(largest, sums.range(f));
  }
  // What is the same everywhere at each step keeps any bound.
  if (b.arrays.empty() && !job_.behaviour.arrays.empty()) {
    for (const ArrayInfo& sum : sums.fields()) b.arrays.push_back(sum.name);
  }
  if (least_bound < kInfinity) b.max_error.reset();
  // As a share of the sums' ranges.
  if (b.max_rms) *b.max_rms /= largest;
  // A fusion that is off by a bound in the mean leaves no hope that it is kept by itself.
  if (!share) b.give_up_rms = least_bound;
  return job;
}

// At the points of each step, as a share of the array's range there. With tetfuse an array's own
// share is a tolerance, for the sums.
double SharedSeries::bound_of(const SteeringChoice& array) const {
  if (job_.behaviour.method != Method::kFuse) return kInfinity;
  const ErrorLimits limits = error_limits(job_.behaviour, tolerances_of(steps_->arrays()));
  return array.tolerance.value_or(limits.max_error);
}

// Fits the values of the arrays that steer to each step, and puts them aside. What of each step is
// worst.
std::vector<BoundSearch::Worst> SharedSeries::fit_steps() {
  const MapCounts& result = map_->counts();
  const StepMemory needs = step_memory(result.points, result.cells, steps_->widths());
  if (!have_room_for_two(needs, job_.performance.memory)) at_once_ = 1;
  if (steps_->arrays().empty()) return {};
  std::vector<ArrayFit> fits;
  for (const SteeringChoice& a : steps_->arrays()) fits.push_back({a.name, bound_of(a)});
  fitted_.emplace(folder_.path(), *map_, fits, steps_->first(), files_.count());
  const RunContext context = part_of_run(context_, 0.6, 0.7);
  RunContext quiet = context;
  quiet.progress = {};
  std::vector<BoundSearch::Worst> worst(files_.count());
  std::atomic<std::size_t> done{0};
  run_tasks_with_loops(files_.count(), at_once_, [&](std::size_t i) {
    worst[i] = note_errors(i, fits, fitted_->add(i, files_.open(i).get(), quiet));
    context.report("fitting", 0, 1, ++done, files_.count());
  });
  return worst;
}

BoundSearch::Worst SharedSeries::note_errors(std::size_t step, const std::vector<ArrayFit>& fits,
                                             const std::vector<MovedArray>& moved) {
  StepReport& report = report_.steps[step];
  report.arrays.clear();
  BoundSearch::Worst worst;
  for (std::size_t a = 0; a < moved.size(); ++a) {
    const MovedArray& m = moved[a];
    const double bound = fits[a].bound;
    const std::string& name =
        files_.are_one_mesh() ? files_[step].arrays.at(fits[a].name) : fits[a].name;
    report.arrays.push_back({name, m.rms, m.max, m.max_at});
    if (bound == kInfinity || !is_float(m.array.info.type)) continue;
    if (const double used = std::max(m.max - m.rounding, 0.0) / bound; used > worst.used) {
      worst = {used, fmt::format("in step {} {} is off by {:.3g} times the bound at point {}",
                                 report.label, name, used, m.max_at)};
    }
    if (m.undefined > 0 && worst.used < kLostValue) {
      worst = {kLostValue, fmt::format("in step {} {} has no value any more at {}", report.label,
                                       name, format_count(m.undefined, "point"))};
    }
  }
  return worst;
}

void SharedSeries::write() {
  SimplifyReport& run = report_.runs[0];
  run.output.path = job_.output;
  run.steering.clear();
  for (const SteeringChoice& array : steps_->arrays()) run.steering.push_back(array.name);
  const ResultMesh mesh(folder_.mesh(), *map_);
  const SeriesResult result{mesh,
                            *map_,
                            steps_->arrays(),
                            fitted_ ? &*fitted_ : nullptr,
                            job_.encoding,
                            region_that_was_named(job_.behaviour.regions)};
  if (files_.are_one_mesh()) {
    write_in_one_mesh(result, files_, job_.output, context_);
    run.outputs = {run.output};
    return;
  }
  write_steps(result, files_, at_once_, context_, &plan_);
  run.outputs.clear();
  for (std::size_t i = 0; i < files_.count(); ++i) {
    report_.steps[i].time = plan_.steps[i].time;
    run.outputs.push_back(run.output);
    run.outputs.back().path = plan_.steps[i].output;
  }
}

}  // namespace

SeriesReport simplify_shared(const SeriesRequest& request, SeriesPlan* plan,
                             const RunContext& context) {
  const double start = wall_seconds();
  SeriesReport report = SharedSeries(request, plan, context).run();
  report.runs[0].total_seconds = wall_seconds() - start;
  report.runs[0].cpu_seconds = cpu_seconds();
  report.runs[0].peak_rss_bytes = peak_rss_bytes();
  return report;
}

}  // namespace tetfusion
