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
#include "driver/carried_arrays.h"
#include "driver/convert.h"
#include "driver/error_limits.h"
#include "driver/export.h"
#include "driver/notices.h"
#include "driver/promise.h"
#include "driver/regions.h"
#include "driver/run_setup.h"
#include "driver/scratch_place.h"
#include "driver/simplify.h"
#include "follow/apply_map.h"
#include "io/map_file.h"
#include "io/output_file.h"
#include "mesh/time_value.h"
#include "series/combined_fields.h"
#include "series/combined_interest.h"
#include "series/combined_regions.h"
#include "series/fitted_steps.h"
#include "series/other_arrays.h"
#include "series/result_mesh.h"
#include "series/step_mesh.h"
#include "series/step_source.h"
#include "series/work_folder.h"

namespace tetfusion {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Sums of steps, where there is a goal and where a bound alone says how far to go (README.md).
constexpr std::size_t kFewSums = 6, kManySums = 8;

// How much of the bound the sums may use, as what is off by that much there may be off by more in a
// step; and what becomes of that share where it turns out to have been too much (README.md).
constexpr double kFirstShare = 0.95, kLess = 0.8, kMuchLess = 0.5;
constexpr int kLessTries = 5, kMostTries = 12;
// A bound that no step has come near to was held too strictly: sums of steps that are alike are
// larger than these. What is to become of it, and how often that is worth another try.
constexpr double kNear = 0.6, kAim = 0.85, kMostAtOnce = 8;
constexpr int kMoreTries = 2;

// Where a step has a value and the result none, it is as if that was off by so many times the
// bound.
constexpr double kLostValue = 2;

class SharedSeries {
 public:
  SharedSeries(const SeriesRequest& request, SeriesPlan* plan, const RunContext& context)
      : request_(request), plan_(*plan), context_(context), folder_(scratch_folder(request.job)) {
    context_.abandoned = &failed_;
  }

  SeriesReport run() {
    set_thread_count(request_.job.performance.threads);
    clock_.begin("steps");
    look_at_steps();
    simplify_and_compare();
    clock_.begin("write steps");
    std::optional<OutputFile> map;
    if (!request_.job.map.empty()) {
      map.emplace(request_.job.map);
      map->append(map_->bytes().data(), map_->bytes().size());
      map->finish();
    }
    write_steps();
    if (map) map->commit();
    clock_.end();
    report_.runs[0].seconds = clock_.seconds();
    return std::move(report_);
  }

 private:
  std::unique_ptr<MeshSource> open_file(const Step& step) const {
    const BehaviourOptions& b = request_.job.behaviour;
    return open_mesh(step.input, {b.tetrahedralize, b.linearize, folder_.path()});
  }
  std::unique_ptr<MeshSource> open(const Step& step) const {
    return open_step(open_file(step), plan_, step, request_.job.behaviour.weight);
  }
  RunContext part(double from, double to) const;
  void look_at_steps();
  void look_at_first();
  void require_no_original_ids(const MeshDescription& mesh) const;
  template <class Look>
  void add_up(std::size_t from, bool arrays_alone, Look look);
  void add_to_sums(std::size_t i, const MeshDescription& mesh, const MeshStream& stream);
  void add_up_again();
  void simplify_and_compare();
  double bound_of(const SteeringChoice& array) const;
  bool simplify_without_bounds();
  void simplify_once(std::optional<double> share);
  void simplify_within_bounds();
  bool tries_without_bounds() const;
  SimplifyRequest job(std::optional<double> share) const;
  std::unique_ptr<MeshSource> summed_mesh() const;
  double fit_steps(const RunContext& context);
  void write_steps();
  void write_step(std::size_t i, const ResultMesh& result, const RunContext& context);
  // An array that steers, of a step.
  struct Fitted {
    std::size_t step, array;
  };
  template <class PlaceOf>
  StepArrays moved_arrays(MeshSource* source, PlaceOf place_of, const RunContext& context) const;
  void write_mesh(MeshSource* source, StepArrays arrays, const ResultMesh& result,
                  const std::string& path, const RunContext& context);
  void write_in_one_mesh(const ResultMesh& result, const RunContext& context);

  const SeriesRequest& request_;
  SeriesPlan& plan_;
  RunContext context_;
  std::atomic<bool> failed_{false};
  const WorkFolder folder_;
  std::vector<SteeringChoice> arrays_;  // that steer, of the first step
  MeshPrint print_;
  std::optional<PointSet> used_;
  CombinedFields::Settings adding_;
  std::unique_ptr<CombinedFields> sums_;
  std::optional<CombinedRegions> regions_;
  std::optional<CombinedInterest> interest_;
  bool compare_apart_ = false;  // from reading the arrays: beside the first simplification
  std::unique_ptr<MapFile> map_;
  int at_once_ = 1;  // so many steps are in hand together: 1 or 2
  std::optional<FittedSteps> fitted_;
  PhaseClock clock_;
  SeriesReport report_;
};

// Of the whole run, for a part of it.
RunContext SharedSeries::part(double from, double to) const {
  RunContext context = context_;
  if (context_.progress) {
    context.progress = [this, from, to](std::string_view phase, double share) {
      context_.progress(phase, from + (to - from) * share);
    };
  }
  context.size = {};
  return context;
}

// Each step once: what its arrays add to the sums, and, unless that is done apart, that it has the
// first one's mesh.
void SharedSeries::look_at_steps() {
  for (const Step& step : plan_.steps) {
    report_.steps.push_back({step.label, step.input, step.output, {}, {}});
  }
  look_at_first();
  std::atomic<std::size_t> seen{1};
  const bool compare_here = !plan_.in_one_mesh() && !compare_apart_;
  add_up(
      1, !compare_here, [&](std::size_t i, const MeshDescription& mesh, const MeshStream& stream) {
        context_.report("reading steps", 0, 0.2, seen++, plan_.steps.size());
        if (!plan_.in_one_mesh()) {
          const auto first = open(plan_.steps[0]);
          if (compare_here) {
            require_same_mesh(print_, first.get(), print_of(mesh, stream, context_), mesh, stream);
          } else {
            require_same_size(print_, first.get(), mesh, stream);
          }
          regions_->add(i, mesh, stream, context_);
        }
        interest_->add(mesh, stream, context_);
        require_no_original_ids(mesh);
      });
  sums_->finish(context_);
  for (const std::string& name : regions_->changing()) {
    if ("cell:" + name == request_.job.behaviour.weight) {
      throw Error(
          ErrorCode::kUsage,
          fmt::format("--weight cell:{}: the array says regions, too, and changes from step "
                      "to step: give another one, or --regions none",
                      name));
    }
    context_.say(fmt::format(
        "cell array {} changes from step to step: what any step tells apart stays so", name));
  }
}

// What all others are compared with.
void SharedSeries::look_at_first() {
  context_.report("reading steps", 0);
  const auto source = open(plan_.steps[0]);
  const MeshDescription& mesh = source->description();
  const auto stream = open_stream(source.get());
  // Where steps are read whole, one is enough in memory.
  at_once_ = stream->streams_from_disk() && thread_count() > 1 ? 2 : 1;
  compare_apart_ = stream->streams_from_disk() && !plan_.in_one_mesh();
  const BehaviourOptions& b = request_.job.behaviour;
  arrays_ = choose_steering(mesh, b.arrays);
  // Names that are none are refused here, where the mesh has its own arrays.
  regions_.emplace(folder_.path(), mesh, stream->cells(), choose_regions(mesh, b.regions));
  static_cast<void>(weight_column(b.weight, mesh, CarriedArrays(mesh)));
  if (b.arrays.empty() && !arrays_.empty()) {
    say_what_steers({arrays_[0].name}, mesh, context_);
  }
  require_no_original_ids(mesh);
  used_.emplace(stream->points());
  print_ = print_of(mesh, *stream, context_, &*used_);
  tell_left_out(plan_.steps[0].output, open_file(plan_.steps[0])->description(), context_);
  context_.report_size(mesh.cells);
  regions_->add(0, mesh, *stream, context_);
  interest_.emplace(b.interest, mesh);
  interest_->add(mesh, *stream, context_);
  adding_.sums = b.reduction || b.tets ? kFewSums : kManySums;
  sums_ = std::make_unique<CombinedFields>(folder_.path(), arrays_, mesh, &*used_,
                                           plan_.steps.size(), adding_);
  add_to_sums(0, mesh, *stream);
}

void SharedSeries::require_no_original_ids(const MeshDescription& mesh) const {
  if (!request_.job.behaviour.original_ids ||
      mesh.point_data.find(kOriginalIds) == AttributeSet::npos) {
    return;
  }
  throw Error(ErrorCode::kUsage,
              fmt::format("{}: the mesh has an array {} already: leave --original-ids out, or "
                          "rename or remove the array",
                          mesh.path, kOriginalIds));
}

// Calls look(step, mesh, stream) for steps from that one on, and adds them to the sums; two at once
// if they go to different ones, so that each sum has its steps in order.
template <class Look>
void SharedSeries::add_up(std::size_t from, bool arrays_alone, Look look) {
  std::size_t count = 1;
  for (std::size_t i = from; i < plan_.steps.size(); i += count) {
    const bool two = at_once_ > 1 && i + 1 < plan_.steps.size();
    count = two && sums_->sum_of(i) != sums_->sum_of(i + 1) ? 2 : 1;
    run_tasks_with_loops(count, at_once_, [&](std::size_t k) {
      const auto source = open(plan_.steps[i + k]);
      const auto stream = arrays_alone ? open_rows(source.get()) : open_stream(source.get());
      look(i + k, source->description(), *stream);
      add_to_sums(i + k, source->description(), *stream);
    });
  }
}

void SharedSeries::add_to_sums(std::size_t i, const MeshDescription& mesh,
                               const MeshStream& stream) {
  try {
    sums_->add(i, mesh, stream, context_);
  } catch (const Error& error) {
    if (!plan_.in_one_mesh() || error.code() != ErrorCode::kBadInput) throw;
    throw Error(error.code(), fmt::format("step {}: {}", plan_.steps[i].label, error.what()));
  }
}

void SharedSeries::add_up_again() {
  const auto first = open(plan_.steps[0]);
  sums_ = std::make_unique<CombinedFields>(folder_.path(), arrays_, first->description(), &*used_,
                                           plan_.steps.size(), adding_);
  add_up(0, true, [](std::size_t, const MeshDescription&, const MeshStream&) {});
  sums_->finish(context_);
}

// Reading all of all steps takes a disk as long as simplifying takes the processors. What fails
// ends the other, too; a mesh that is another one is said before what may have come of it.
void SharedSeries::simplify_and_compare() {
  const auto compare_all = [&] {
    const auto open_step = [&](std::size_t i) { return open(plan_.steps[i]); };
    require_same_meshes(print_, plan_.steps.size(), open_step, context_);
  };
  const auto simplify_all = [&] {
    simplify_within_bounds();
    clock_.begin("steps");  // what is left of comparing
  };
  if (!compare_apart_) return simplify_all();
  run_tasks(2, at_once_, [&](std::size_t task, std::size_t) {
    try {
      task == 0 ? compare_all() : simplify_all();
    } catch (...) {
      failed_ = true;
      throw;
    }
  });
}

// At the points of each step, as a share of the array's range there. With tetfuse an array's own
// share is a tolerance, for the sums.
double SharedSeries::bound_of(const SteeringChoice& array) const {
  if (request_.job.behaviour.method != Method::kFuse) return kInfinity;
  const ErrorLimits limits = error_limits(request_.job.behaviour, limits_of(arrays_));
  return array.tolerance.value_or(limits.max_error);
}

// The first step's mesh, but with arrays of points that steer, and of cells that may tell regions
// or say where each is in the files.
std::unique_ptr<MeshSource> SharedSeries::summed_mesh() const {
  auto source = open(plan_.steps[0]);
  OtherArrays arrays;
  for (std::size_t f = 0; f < sums_->fields().size(); ++f) {
    const auto read = [this, f](const MeshStream&, std::uint64_t first, std::span<std::byte> out) {
      sums_->read(f, first, out);
    };
    arrays.points.push_back({sums_->fields()[f], read});
  }
  if (!interest_->empty()) arrays.points.push_back(interest_->array());
  const MeshDescription& mesh = source->description();
  const auto weights = find_array(mesh, request_.job.behaviour.weight);
  if (weights && weights->association == Association::kPoint) {
    arrays.points.push_back(own_array(mesh, Association::kPoint, weights->index));
  }
  for (std::size_t i = 0; i < mesh.cell_data.arrays.size(); ++i) {
    const ArrayInfo& info = mesh.cell_data.arrays[i];
    const bool is_weight =
        weights && weights->association == Association::kCell && weights->index == i;
    if (is_float(info.type) && !is_weight) continue;
    if (!regions_->changes(info.name)) {
      arrays.cells.push_back(own_array(mesh, Association::kCell, i));
      continue;
    }
    arrays.cells.push_back(
        {{info.name, ValueType::kInt64, 1, {}, info.tuples},
         [this, name = info.name](const MeshStream&, std::uint64_t first,
                                  std::span<std::byte> out) { regions_->read(name, first, out); }});
  }
  arrays.cells.push_back({cell_numbers_info(mesh),
                          [](const MeshStream&, std::uint64_t first, std::span<std::byte> out) {
                            auto* number = reinterpret_cast<std::int64_t*>(out.data());
                            for (std::size_t i = 0; i < out.size() / sizeof *number; ++i) {
                              number[i] = static_cast<std::int64_t>(first + i);
                            }
                          }});
  return with_arrays(std::move(source), std::move(arrays));
}

// With bounds for the sums of so large a share of the steps', or without.
SimplifyRequest SharedSeries::job(std::optional<double> share) const {
  SimplifyRequest job = request_.job;
  job.input = plan_.steps[0].input;
  job.output = folder_.mesh();
  job.map = folder_.map();
  job.encoding = Encoding::kRaw;
  job.performance.scratch = folder_.chunks();
  job.performance.keep_work = false;
  BehaviourOptions& b = job.behaviour;
  b.fit_values = false;  // those of each step are
  b.interest = interest_->texts();
  b.arrays.clear();
  double largest = 1;
  double least_bound = kInfinity;
  for (std::size_t f = 0; f < sums_->fields().size(); ++f) {
    if (!(sums_->range(f) > 0)) continue;
    const SteeringChoice& array = arrays_[sums_->array_of(f)];
    const double bound = bound_of(array) / sums_->range(f);
    least_bound = std::min(least_bound, bound);
    std::string text = sums_->fields()[f].name;
    if (bound < kInfinity) {
      if (share) text += fmt::format(":{}", *share * bound);
    } else if (array.tolerance) {
      text += fmt::format(":{}", *array.tolerance);
    }
    b.arrays.push_back(std::move(text));
    largest = std::max(largest, sums_->range(f));
  }
  if (least_bound < kInfinity) b.max_error.reset();
  // As a share of the sums' ranges.
  if (b.max_rms) *b.max_rms /= largest;
  // A fusion that is off by a bound in the mean leaves no hope that it is kept by itself.
  if (!share) b.give_up_rms = least_bound;
  return job;
}

bool SharedSeries::tries_without_bounds() const {
  const BehaviourOptions& b = request_.job.behaviour;
  return (b.reduction || b.tets) &&
         std::any_of(arrays_.begin(), arrays_.end(),
                     [&](const SteeringChoice& a) { return bound_of(a) < kInfinity; });
}

// The first try, where there is a goal, as that is often reached long before the bounds are: are
// they kept without being looked at on the way?
bool SharedSeries::simplify_without_bounds() {
  if (!tries_without_bounds()) return false;
  try {
    simplify_once(std::nullopt);
    if (fit_steps(part(0.6, 0.7)) <= 1) return true;
  } catch (const OutOfReach&) {  // nothing was written
  }
  context_.say("the goal alone would break the bound on the error: once more, with bounds");
  return false;
}

void SharedSeries::simplify_once(std::optional<double> share) {
  ++report_.tries;
  RunContext context = part(0.2, 0.6);
  if (report_.tries > 1) context.notice = {};
  const SimplifyRequest job = this->job(share);
  map_.reset();
  clock_.begin("simplify");
  report_.runs = {simplify(job, summed_mesh(), context)};
  clock_.begin("fit");
  map_ = std::make_unique<MapFile>(MapFile::open(folder_.map()));
}

void SharedSeries::simplify_within_bounds() {
  report_.tries = 0;
  if (simplify_without_bounds()) return;
  double share = kFirstShare;
  bool too_much = false;
  int more_tries = 0;
  for (;;) {
    simplify_once(share);
    const double used = fit_steps(part(0.6, 0.7));
    const bool goal = report_.runs[0].has_goal && report_.runs[0].stop_reason == StopReason::kGoal;
    if (used > 1) {
      if (report_.tries >= kMostTries) {
        throw Error(ErrorCode::kBroken,
                    fmt::format("the bound on the error could not be kept at all steps: in one it "
                                "is exceeded by {:.3g} %; nothing was written. Give a larger "
                                "--max-error, or --series each",
                                100 * (used - 1)));
      }
      const bool few = adding_.sums < std::min(kManySums, plan_.steps.size());
      context_.say(
          fmt::format("a step is off by {:.3g} times the bound: once more, with {} sums of steps",
                      used, few ? "more" : "a tighter one for the"));
      // Where steps cancel in their sums a tighter bound does not help for ever.
      if (few || too_much) {
        adding_ = {kManySums, few ? 0 : static_cast<std::uint64_t>(report_.tries)};
        add_up_again();
      }
      too_much = !few;
      share = few ? kFirstShare : share * (report_.tries <= kLessTries ? kLess : kMuchLess);
    } else if (used < kNear && !too_much && !goal && more_tries < kMoreTries && used > 0) {
      ++more_tries;
      context_.say(fmt::format(
          "no step is off by more than {:.3g} times the bound: once more, with a looser "
          "one for the sums of steps",
          used));
      share *= std::min(kAim / used, kMostAtOnce);
    } else {
      return;
    }
  }
}

// Fits the values of the arrays that steer to each step, puts them aside, and returns the largest
// error, as a share of its bound; 0 where there is none.
double SharedSeries::fit_steps(const RunContext& context) {
  if (!have_room_for_two(*map_, open(plan_.steps[0])->description(),
                         request_.job.performance.memory)) {
    at_once_ = 1;
  }
  if (arrays_.empty()) return 0;
  std::vector<ArrayFit> fits;
  for (const SteeringChoice& a : arrays_) fits.push_back({a.name, bound_of(a)});
  fitted_.emplace(folder_.path(), *map_, fits, open(plan_.steps[0])->description(),
                  plan_.steps.size());
  RunContext quiet = context;
  quiet.progress = {};
  std::vector<double> used(plan_.steps.size(), 0);
  std::atomic<std::size_t> done{0};
  run_tasks_with_loops(plan_.steps.size(), at_once_, [&](std::size_t i) {
    report_.steps[i].arrays.clear();
    const std::vector<MovedArray> moved = fitted_->add(i, open(plan_.steps[i]).get(), quiet);
    for (std::size_t a = 0; a < moved.size(); ++a) {
      const std::string& name =
          plan_.in_one_mesh() ? plan_.steps[i].arrays.at(fits[a].name) : fits[a].name;
      report_.steps[i].arrays.push_back({name, moved[a].rms, moved[a].max, moved[a].max_at});
      if (fits[a].bound == kInfinity || !is_float(moved[a].array.info.type)) continue;
      used[i] = std::max(used[i], std::max(moved[a].max - moved[a].rounding, 0.0) / fits[a].bound);
      if (moved[a].undefined > 0) used[i] = std::max(used[i], kLostValue);
    }
    context.report("fitting", 0, 1, ++done, plan_.steps.size());
  });
  return *std::max_element(used.begin(), used.end());
}

void SharedSeries::write_steps() {
  const ResultMesh result(folder_.mesh(), *map_);
  report_.runs[0].output.path = request_.job.output;
  report_.runs[0].steering.clear();
  for (const SteeringChoice& array : arrays_) report_.runs[0].steering.push_back(array.name);
  if (plan_.in_one_mesh()) {
    write_in_one_mesh(result, part(0.7, 1));
    report_.runs[0].outputs = {request_.job.output};
    return;
  }
  std::vector<std::uint8_t> written(plan_.steps.size(), 0);
  const auto share = [&](std::size_t i) {
    return 0.7 + 0.3 * static_cast<double>(i) / static_cast<double>(plan_.steps.size());
  };
  try {
    run_tasks_with_loops(plan_.steps.size(), at_once_, [&](std::size_t i) {
      write_step(i, result, part(share(i), share(i + 1)));
      written[i] = 1;
    });
  } catch (const Error& error) {
    const auto last = std::find(written.rbegin(), written.rend(), 1);
    const auto place = static_cast<std::size_t>(written.rend() - last);
    throw Error(error.code(),
                fmt::format("{}; {} of the {} steps are written{}", error.what(),
                            std::count(written.begin(), written.end(), 1), written.size(),
                            place == 0 ? "" : ", the last is " + plan_.steps[place - 1].output));
  }
  report_.runs[0].outputs.clear();
  for (const Step& step : plan_.steps) report_.runs[0].outputs.push_back(step.output);
}

void SharedSeries::write_step(std::size_t i, const ResultMesh& result, const RunContext& context) {
  const auto source = open(plan_.steps[i]);
  StepArrays arrays = moved_arrays(
      source.get(),
      [&](const std::string& name) {
        const auto choice = std::find_if(arrays_.begin(), arrays_.end(),
                                         [&](const SteeringChoice& c) { return c.name == name; });
        return choice == arrays_.end()
                   ? std::nullopt
                   : std::optional<Fitted>({i, static_cast<std::size_t>(choice - arrays_.begin())});
      },
      context);
  for (const DataArray& array : arrays.field_data) {
    if (!plan_.steps[i].time) plan_.steps[i].time = time_of(array);
  }
  report_.steps[i].time = plan_.steps[i].time;
  write_mesh(source.get(), std::move(arrays), result, plan_.steps[i].output, context);
}

// All steps' arrays, in the order that they have there.
void SharedSeries::write_in_one_mesh(const ResultMesh& result, const RunContext& context) {
  const auto source = open_file(plan_.steps[0]);
  StepArrays arrays = moved_arrays(
      source.get(),
      [&](const std::string& name) {
        std::optional<Fitted> place;
        for (std::size_t i = 0; i < plan_.steps.size() && !place; ++i) {
          const auto pattern = pattern_of(plan_.steps[i], name);
          for (std::size_t a = 0; a < arrays_.size() && pattern; ++a) {
            if (arrays_[a].name == *pattern) place = {i, a};
          }
        }
        return place;
      },
      context);
  write_mesh(source.get(), std::move(arrays), result, request_.job.output, context);
}

// The arrays of points, fitted where place_of(name) says so, and the field data.
template <class PlaceOf>
StepArrays SharedSeries::moved_arrays(MeshSource* source, PlaceOf place_of,
                                      const RunContext& context) const {
  const AttributeSet& all = source->description().point_data;
  std::vector<std::string> others;
  for (const ArrayInfo& info : all.arrays) {
    if (!place_of(info.name) && !is_ghost_mark(info.name)) others.push_back(info.name);
  }
  RunContext quiet = context;
  quiet.progress = {};
  std::vector<MovedArray> moved;
  if (!others.empty()) moved = apply_map(*map_, source, others, quiet, false);
  StepArrays arrays;
  std::size_t next = 0;
  for (const ArrayInfo& info : all.arrays) {
    if (is_ghost_mark(info.name)) continue;
    const std::optional<Fitted> place = place_of(info.name);
    arrays.points.push_back(place ? fitted_->read(place->step, place->array, info)
                                  : std::move(moved[next++].array));
  }
  for (std::size_t f = 0; f < source->description().field_data.arrays.size(); ++f) {
    arrays.field_data.push_back(source->read_array(Association::kField, f));
  }
  return arrays;
}

// With the source's arrays of cells.
void SharedSeries::write_mesh(MeshSource* source, StepArrays arrays, const ResultMesh& result,
                              const std::string& path, const RunContext& context) {
  arrays.cells = result.cell_arrays(source, context);
  const auto out = result.with(std::move(arrays), source->description());
  WriteOptions write;
  write.encoding = request_.job.encoding;
  write.progress = [&](double share) {
    context.check();
    context.report("writing", share);
  };
  convert_mesh(out.get(), path, write);
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
