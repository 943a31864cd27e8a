#include "driver/simplify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "base/memory_budget.h"
#include "base/numbers.h"
#include "base/resources.h"
#include "driver/checkpoint.h"
#include "driver/estimate.h"
#include "driver/export.h"
#include "driver/fingerprint.h"
#include "driver/memory_plan.h"
#include "driver/notices.h"
#include "driver/progressive.h"
#include "driver/promise.h"
#include "driver/regions.h"
#include "driver/round_plan.h"
#include "driver/rounds.h"
#include "driver/run_setup.h"
#include "driver/scratch_place.h"
#include "driver/stages.h"
#include "driver/steering.h"
#include "follow/make_map.h"
#include "io/mesh_source.h"
#include "io/output_file.h"
#include "io/section_file.h"
#include "mesh/region_of_interest.h"

namespace tetfusion {

namespace {

class Job {
 public:
  Job(const SimplifyRequest& request, const RunContext& context,
      std::unique_ptr<MeshSource> source = nullptr, MeshSink* sink = nullptr)
      : request_(request), context_(context), source_(std::move(source)), sink_(sink) {}
  SimplifyReport run();
  RunPlan plan(std::uint64_t sample_tets);

 private:
  void begin();
  void open_input();
  MeshDescription description_of_output() const;
  void plan_memory();
  void open_scratch();
  Steering read_steering();
  template <class Real>
  void run_with();
  template <class Real>
  void import(const CarriedArrays& carried, const Steering& steering, Rounds<Real>* rounds,
              RunState<Real>* state);
  void describe_input(const InputFacts& facts);
  void plan_output(std::uint64_t tets);
  template <class Real>
  void run_stages(const CarriedArrays& carried, const WorkMesh<Real>& layout,
                  std::unique_ptr<Rounds<Real>> rounds, RunState<Real>* state);
  template <class Real>
  bool reach(const std::optional<std::uint64_t>& goal, Rounds<Real>* rounds, RunState<Real>* state);
  template <class Real>
  void end_round(const RoundPlan& plan, const RoundStatistics& round, RunState<Real>* state);
  template <class Real>
  void look_at_excerpt(const Box& box, std::uint64_t tets, Rounds<Real>* rounds,
                       WorkMesh<Real>* excerpt, RunState<Real>* state);
  template <class Real>
  void commit(const std::string& generation, RunState<Real>* state);
  bool looks_at_result() const { return request_.verify || !request_.map.empty(); }
  // Who has the result in memory does not come back for the rest.
  bool keeps_work() const { return sink_ == nullptr && request_.performance.keep_work; }
  bool keeps_logs() const { return !request_.progressive.empty(); }
  bool surfaces_move() const { return tetfusion::surfaces_move(request_.behaviour); }
  // Else the whole mesh has to be looked at before anything fuses, for the ranges that bounds are
  // shares of.
  bool begins_with_excerpt(const std::vector<SteeringField>& fields) const {
    return request_.behaviour.method == Method::kFuse &&
           !error_limits(request_.behaviour, fields).at_points;
  }
  RoundPlan plan_round(const Box& box, std::uint64_t tets, const std::optional<std::uint64_t>& goal,
                       const RoundsState& state) const;
  void make_map(const std::string& path, const Vector<std::int64_t>& original_ids,
                const MeshSummary& written, OutputFile* file);
  void verify(const std::string& output, const std::string& path, const InputFacts& facts,
              const LowerCells& lower, const MeshSummary& written);
  [[noreturn]] void fail_with_hint(const Error& error);

  const SimplifyRequest& request_;
  const RunContext& context_;
  RoundPlanner planner_{request_.behaviour};
  std::unique_ptr<MeshSource> source_;  // from the start where it is memory
  MeshSink* sink_ = nullptr;            // where the mesh goes to memory
  std::unique_ptr<MeshStream> stream_;
  std::vector<SteeringChoice> steering_choices_;
  RegionOfInterest interest_;
  std::vector<std::size_t> regions_;
  std::vector<std::uint32_t> region_columns_;  // the same, of the columns of chunks
  WeightColumn weight_column_;
  MemoryNeeds needs_;
  std::unique_ptr<MemoryBudget> budget_;
  bool on_disk_ = false;
  bool committed_ = false;  // there is something to resume
  std::unique_ptr<Scratch> scratch_;
  std::optional<Checkpoint> checkpoint_;
  std::vector<Stage> stages_;
  std::unique_ptr<FusionLogs> logs_;  // with request_.progressive
  PhaseClock clock_;
  SimplifyReport report_;
};

RunPlan Job::plan(std::uint64_t sample_tets) {
  const double start = wall_seconds();
  begin();
  const MeshDescription& mesh = source_->description();
  RunPlan plan;
  plan.input.path = request_.input;
  plan.input.points = mesh.points;
  plan.input.tets = mesh.cells;
  for (const SteeringChoice& choice : steering_choices_) plan.steering.push_back(choice.name);
  plan.regions = names_of_cell_arrays(mesh, regions_);
  plan.chunks = (mesh.cells + request_.behaviour.chunk_tets - 1) / request_.behaviour.chunk_tets;
  plan.needs = needs_;
  plan.memory = budget_->total();
  plan.on_disk = on_disk_;
  plan.scratch = scratch_folder(request_);
  if (mesh.spooled_checksum) plan.needs.scratch += mesh.file_bytes;
  plan.method = request_.behaviour.method;
  plan.threads = thread_count();
  const Steering steering = read_steering();
  plan.estimate = estimate_run(
      {request_, mesh, *stream_, steering, regions_, interest_, sample_tets, thread_count(), start},
      context_, budget_.get());
  context_.report("done", 1);
  return plan;
}

void Job::begin() {
  check_options(request_);
  report_.method = request_.behaviour.method;
  report_.boundary = boundary_name(request_.behaviour);
  set_thread_count(request_.performance.threads);
  report_.threads = thread_count();
  if (sink_ == nullptr) {
    for (const Stage& s : plan_stages(request_, kMaxTets)) {
      check_export(s.path, request_.encoding);
      if (!s.map.empty()) check_output_path(s.map);
    }
    if (keeps_logs()) check_output_path(request_.progressive);
  }
  open_input();
  refuse_outputs_among(source_->description(), request_);
  const MeshDescription output = description_of_output();
  if (sink_ == nullptr) tell_left_out(request_.output, output, context_);
  plan_memory();
}

SimplifyReport Job::run() {
  const double start = wall_seconds();
  begin();
  if (sink_ == nullptr) {
    for (const Stage& stage : plan_stages(request_, kMaxTets)) clear_leftovers(stage.path);
  }
  try {
    open_scratch();
    if (source_->description().point_type == ValueType::kFloat32) {
      run_with<float>();
    } else {
      run_with<double>();
    }
    logs_.reset();
    if (scratch_) scratch_->remove();
  } catch (const Error& error) {
    fail_with_hint(error);
  }
  clock_.end();
  report_.seconds = clock_.seconds();
  report_.total_seconds = wall_seconds() - start;
  report_.cpu_seconds = cpu_seconds();
  report_.peak_rss_bytes = peak_rss_bytes();
  report_.scratch_bytes = on_disk_ ? scratch_->peak_bytes() : 0;
  context_.report("done", 1);
  return std::move(report_);
}

// A run that has come far enough to go on from says how; of any other nothing is left.
void Job::fail_with_hint(const Error& error) {
  logs_.reset();
  if (!committed_) {
    if (scratch_) {
      try {
        scratch_->remove();
      } catch (const Error&) {
        // The first failure is the one to report.
      }
    }
    throw;
  }
  if (dynamic_cast<const DamagedFile*>(&error) != nullptr) throw;  // nobody goes on from it
  throw Error(
      error.code(),
      fmt::format("{}; the work so far is kept in {}: the same command with --resume goes on "
                  "from there",
                  error.what(), scratch_folder(request_)));
}

void Job::open_input() {
  context_.report("reading", 0);
  clock_.begin("read");
  if (!source_) {
    source_ = open_mesh(request_.input, {request_.behaviour.tetrahedralize,
                                         request_.behaviour.linearize, spool_folder(request_)});
  }
  stream_ = source_->stream();
  steering_choices_ = choose_steering(source_->description(), request_.behaviour.arrays);
  regions_ = choose_regions(source_->description(), request_.behaviour.regions);
  weight_column_ = weight_column(request_.behaviour.weight, source_->description(),
                                 CarriedArrays(source_->description()));
  interest_ = RegionOfInterest(request_.behaviour.interest, request_.input,
                               source_->description().point_data);
  context_.check();
}

// As far as its arrays go.
MeshDescription Job::description_of_output() const {
  MeshDescription mesh = source_->description();
  if (!request_.behaviour.original_ids) return mesh;
  if (mesh.point_data.find(kOriginalIds) != AttributeSet::npos) {
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: the mesh has an array {} already: leave --original-ids out, or "
                            "rename or remove the array",
                            request_.input, kOriginalIds));
  }
  mesh.point_data.arrays.push_back(original_ids_info());
  return mesh;
}

void Job::plan_memory() {
  const std::uint64_t total =
      request_.performance.memory != 0 ? request_.performance.memory : memory_limit() / 2;
  const MeshDescription& mesh = source_->description();
  needs_ = estimate_needs(mesh, steering_bytes(request_, mesh, steering_choices_),
                          request_.behaviour.chunk_tets, thread_count(),
                          stream_ ? stream_->bytes() : source_->memory_to_read());
  // Without a goal nobody knows how large the result will be.
  if (const auto goal = plan_stages(request_, mesh.cells).front().tets; looks_at_result() && goal) {
    include_verification(mesh, *goal, request_.map.empty() ? 0 : kMapPointBytes, &needs_);
  }
  if (keeps_logs()) include_logs(request_, mesh, thread_count(), &needs_);
  on_disk_ = request_.performance.on_disk || needs_.in_core > total;
  if (needs_.out_of_core > total) {
    throw Error(
        ErrorCode::kMemory,
        fmt::format("{}: simplifying this mesh needs about {} of memory with its chunks on "
                    "disk (and {} with everything in memory), but it may use {}: give "
                    "--memory {}M or more, or fewer --threads",
                    request_.input, format_bytes(needs_.out_of_core), format_bytes(needs_.in_core),
                    format_bytes(total), (needs_.out_of_core >> 20) + 1));
  }
  budget_ = std::make_unique<MemoryBudget>(total);
}

void Job::open_scratch() {
  const std::string folder = scratch_folder(request_);
  const bool resume = request_.performance.resume && std::filesystem::exists(folder);
  if (!on_disk_ && !resume) {
    scratch_ = memory_scratch();
    return;
  }
  if (sink_ != nullptr && request_.performance.scratch.empty()) {
    throw Error(
        ErrorCode::kMemory,
        fmt::format("{}: simplifying this mesh in memory needs about {}, but it may use {}: give "
                    "--memory {}M or more, or --scratch DIR",
                    request_.input, format_bytes(needs_.in_core), format_bytes(budget_->total()),
                    (needs_.in_core >> 20) + 1));
  }
  if (request_.output == "-" && request_.performance.scratch.empty()) {
    throw Error(
        ErrorCode::kUsage,
        "the mesh does not fit into the memory that may be used, and beside standard output "
        "there is no folder to keep it in: give --scratch DIR");
  }
  on_disk_ = true;
  scratch_ = disk_scratch({folder, fingerprint(request_, source_->description()),
                           request_.performance.resume, needs_.scratch});
  if (resume) checkpoint_ = scratch_->resume();
}

template <class Real>
void Job::run_with() {
  const MeshDescription& description = source_->description();
  const CarriedArrays carried(description);
  region_columns_ = region_columns(carried, regions_);
  RunState<Real> state;
  std::unique_ptr<Rounds<Real>> rounds;
  const auto begin = [&](std::uint32_t steering_width) {
    auto layout = run_layout<Real>(request_.behaviour, carried, steering_width);
    auto rows = layout;
    if (keeps_logs()) rows.cell_columns.push_back(number_column());
    rounds = std::make_unique<Rounds<Real>>(rows, thread_count(), budget_.get(), scratch_.get());
    if (keeps_logs()) {
      logs_ = std::make_unique<FusionLogs>(scratch_.get(), log_bytes_per_tet(description));
      rounds->keep_logs(logs_.get());
    }
    if (fits_values(request_, source_->description(), steering_choices_)) {
      state.values = std::make_unique<OriginalValues<Real>>(scratch_.get(), surfaces_move());
      rounds->put_values_aside(state.values.get());
    }
    return layout;
  };
  if (checkpoint_) {
    load(checkpoint_->state, &state);
    state.input.mesh.pieces = std::move(checkpoint_->pieces);
    committed_ = true;
    report_.lods = state.lods;
    report_.outputs = state.outputs;
    context_.say(fmt::format("going on after {} rounds, with {} tetrahedra left", state.lods.size(),
                             format_count(state.input.mesh.tets)));
    const auto layout = begin(state.steering_width);
    if (keeps_logs()) logs_->resume(state.log_slices, &*checkpoint_);
    if (state.values) state.values->resume(state.value_chunks, &*checkpoint_);
    checkpoint_.reset();
    describe_input(state.input.facts);
    plan_output(state.input.facts.tets);
    report_.steering = state.field_names;
    planner_.limit_errors(error_limits(request_.behaviour, state.fields));
    run_stages(carried, layout, std::move(rounds), &state);
    return;
  }
  const Steering steering = read_steering();
  const auto layout = begin(steering.width());
  import(carried, steering, rounds.get(), &state);
  stream_.reset();
  trim_memory();
  run_stages(carried, layout, std::move(rounds), &state);
}

// Opens the stream, too.
Steering Job::read_steering() {
  if (!stream_) stream_ = open_stream(source_.get());
  context_.check();
  const std::string& weight = request_.behaviour.weight;
  if (!weight.empty()) check_weights(weight, source_->description(), *stream_, context_);
  Steering steering(steering_choices_, source_->description(), *stream_, context_);
  if (!steering.fields().empty()) {
    if (request_.behaviour.arrays.empty()) {
      say_what_steers(steering.names(), source_->description(), context_);
    }
    return steering;
  }
  const BehaviourOptions& b = request_.behaviour;
  if (b.method == Method::kFuse && !b.reduction && !b.tets && b.lods.empty()) {
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: no array steers, so nothing but a goal can say when to stop: give "
                            "--reduction or --tets",
                            request_.input));
  }
  context_.say("no array steers: geometry alone decides");
  return steering;
}

RoundPlan Job::plan_round(const Box& box, std::uint64_t tets,
                          const std::optional<std::uint64_t>& goal,
                          const RoundsState& state) const {
  RoundPlan plan = planner_.plan(box, tets, goal, state);
  const auto& most = request_.behaviour.give_up_rms;
  if (most && !plan.settings.look && plan.settings.fuse.threshold > *most * *most) {
    throw OutOfReach();
  }
  if (surfaces_move()) plan.settings.fuse.regions = region_columns_;
  plan.settings.fuse.weights = weight_column_;
  return plan;
}

template <class Real>
void Job::import(const CarriedArrays& carried, const Steering& steering, Rounds<Real>* rounds,
                 RunState<Real>* state) {
  state->fields = fields_of(steering, carried);
  planner_.limit_errors(error_limits(request_.behaviour, state->fields));
  state->field_names = steering.names();
  state->steering_width = steering.width();
  state->chunk_tets = request_.behaviour.chunk_tets;
  report_.steering = state->field_names;
  ImportSettings settings =
      import_settings(request_.behaviour, carried, regions_, state->steering_width);
  settings.interest = &interest_;
  settings.keeps_numbers = keeps_logs();
  RoundPlan plan;
  FirstRound<Real> first;
  // Under the rule of boundary tetrahedra chunks must know each other's boundary before they begin.
  if (request_.behaviour.boundary_rule == BoundaryRule::kVertices) {
    first.begin = [&](const Box& box, std::uint64_t tets, std::vector<std::uint64_t> shares,
                      const Vector<Vec3<Real>>& samples) {
      report_.input.tets = tets;
      plan_output(tets);
      state->input.box = box;
      plan = plan_round(box, tets, stages_.front().tets, *state);
      rounds->begin(plan.settings, plan.limits, state->fields, tets, std::move(shares), samples);
    };
    settings.excerpt = begins_with_excerpt(state->fields);
    first.look = [&](const Box& box, std::uint64_t tets, WorkMesh<Real>* excerpt) {
      look_at_excerpt(box, tets, rounds, excerpt, state);
    };
    first.work = [&](std::uint32_t chunk, std::size_t worker, WorkMesh<Real>* mesh) {
      rounds->work(chunk, worker, mesh);
    };
  }
  state->input = import_mesh<Real>(*stream_, carried, steering, settings, first, context_, &clock_,
                                   budget_.get(), scratch_.get());
  const ErrorLimits limits = error_limits(request_.behaviour, state->fields);
  if (limits.at_points && state->input.facts.unused_points > 0) {
    relate_to_used_points(state->input.steering_box, limits.max_error, &state->fields);
    planner_.limit_errors(error_limits(request_.behaviour, state->fields));
  }
  describe_input(state->input.facts);
  say_what_is_odd(state->input.facts, context_);
  say_which_are_regions(source_->description(), regions_, request_.behaviour.regions.has_value(),
                        context_);
  if (!interest_.empty() && state->input.interesting_points == 0) {
    context_.say("no point of the mesh is in the region of interest (--roi): it keeps nothing");
  }
  plan_output(state->input.facts.tets);
  if (!state->input.first_round_done) {
    commit("import", state);
    return;
  }
  const InterfaceTable marks = std::move(state->input.mesh.interface);
  const RoundStatistics round = rounds->end(&state->input.mesh, marks);
  end_round(plan, round, state);
}

// Finds out about what fusions cost in all of the mesh. The excerpt has all tetrahedra of those of
// its points that are not between chunks.
template <class Real>
void Job::look_at_excerpt(const Box& box, std::uint64_t tets, Rounds<Real>* rounds,
                          WorkMesh<Real>* excerpt, RunState<Real>* state) {
  std::uint64_t corners = 0;
  for (std::size_t v = 0; v < excerpt->vertex_count(); ++v) {
    if ((excerpt->marks[v] & kOnInterface) == 0) corners += excerpt->incidence[v];
  }
  if (corners == 0) return;
  const RoundPlan plan = plan_round(box, tets, std::nullopt, *state);
  CostHistogram costs = rounds->look(plan.settings, state->fields, excerpt);
  const double times = 4 * static_cast<double>(tets) / static_cast<double>(corners);
  for (std::uint64_t& count : costs) {
    count = static_cast<std::uint64_t>(std::ceil(times * static_cast<double>(count)));
  }
  state->costs = costs;
}

void Job::describe_input(const InputFacts& facts) {
  report_.input = {request_.input, facts.points, facts.tets, facts.boundary_faces, facts.volume};
  report_.oddities = {facts.rewound,        facts.degenerate,          facts.inverted,
                      facts.duplicate_tets, facts.nonconforming_faces, facts.unused_points,
                      facts.merged_points,  facts.ghost_cells,         facts.locked_vertices};
  report_.regions = names_of_cell_arrays(source_->description(), regions_);
}

void Job::plan_output(std::uint64_t tets) {
  context_.report_size(tets);
  stages_ = plan_stages(request_, tets);
  if (request_.behaviour.tets && *stages_.back().tets < *request_.behaviour.tets) {
    throw Error(
        ErrorCode::kUsage,
        "--lods goes further than --tets: give one of them, or a goal beyond the last level");
  }
  report_.has_goal = stages_.back().tets.has_value();
}

template <class Real>
void Job::commit(const std::string& generation, RunState<Real>* state) {
  if (!on_disk_ || !keeps_work() || state->input.mesh.whole) return;
  if (keeps_logs()) state->log_slices = logs_->keep();
  if (state->values) state->value_chunks = state->values->keep();
  scratch_->commit(generation, save(*state));
  committed_ = true;
}

template <class Real>
void Job::run_stages(const CarriedArrays& carried, const WorkMesh<Real>& layout,
                     std::unique_ptr<Rounds<Real>> rounds, RunState<Real>* state) {
  if (looks_at_result()) require_boundary(request_.input, state->input.facts);
  if (keeps_logs()) refuse_ghosts(request_.input, state->input.facts);
  for (std::size_t i = state->outputs.size(); i < stages_.size(); ++i) {
    clock_.begin("passes");
    const bool reached = reach(stages_[i].tets, rounds.get(), state);
    const bool last = i + 1 == stages_.size() || !reached;
    if (!reached && i + 1 < stages_.size()) {
      context_.say(
          fmt::format("level {} of {} could not be reached: {} holds the last macroLoD, and no "
                      "further level is "
                      "written",
                      i + 1, stages_.size(), stages_[i].path));
    }
    clock_.begin("write");
    if (last) rounds.reset();
    if (last) scratch_->drop_spares();
    const double share = share_done(report_.input.tets, state->input.mesh.tets, stages_.back().tets,
                                    state->lods.size());
    const auto progress = [&](double done) {
      context_.check();
      context_.report("writing", share + (last ? 1 - share : 0) * done);
    };
    ExportSettings out;
    out.path = stages_[i].path;
    out.encoding = request_.encoding;
    out.threads = thread_count();
    out.progress = progress;
    out.pieces = request_.pieces;
    out.sink = sink_;
    out.original_ids = request_.behaviour.original_ids;
    out.has_numbers = keeps_logs();
    std::unique_ptr<FittedValues<Real>> fitted;
    if (state->values != nullptr && state->values->chunks() > 0) {
      clock_.begin("fit");
      fitted = std::make_unique<FittedValues<Real>>(*state->values, state->input.mesh,
                                                    state->fields, state->steering_width,
                                                    thread_count(), scratch_.get());
      clock_.begin("write");
    }
    std::optional<OutputFile> progressive;
    if (keeps_logs()) {
      clock_.begin("progressive");
      progressive.emplace(request_.progressive, OutputFile::Access::kPatch);
      const bool all_used = state->input.facts.unused_points == 0;
      const NotedErrors errors = noted_errors(
          request_.behaviour, all_used ? nullptr : &state->input.steering_box, state->fields);
      write_progressive(layout, carried, errors, source_.get(), context_, budget_.get(),
                        scratch_.get(), logs_.get(), &state->input, &*progressive);
      clock_.begin("write");
    }
    Vector<std::int64_t> ids;
    std::optional<OutputFile> map;
    if (!stages_[i].map.empty()) {
      out.point_ids = &ids;
      map.emplace(stages_[i].map, OutputFile::Access::kPatch);
    }
    const auto inspect = [&](const std::string& path, const MeshSummary& written) {
      if (map) make_map(path, ids, written, &*map);
      verify(stages_[i].path, path, state->input.facts, state->input.lower.cells, written);
      if (map) map->finish();
    };
    if (looks_at_result()) out.inspect = inspect;
    report_.output =
        export_mesh(state->input.mesh, layout, state->input.lower, carried, fitted.get(),
                    source_.get(), out, context_, budget_.get(), scratch_.get());
    if (fitted) clock_.move("write", "fit", fitted->seconds() / thread_count());
    if (map) map->commit();
    if (progressive) progressive->commit();
    state->outputs.push_back(stages_[i].path);
    state->end = StageEnd::kOpen;
    state->spread = 1;
    report_.outputs = state->outputs;
    report_.lods = state->lods;
    report_.stop_reason = reached ? StopReason::kGoal : StopReason::kSaturated;
    if (last) return;
  }
}

void Job::make_map(const std::string& path, const Vector<std::int64_t>& original_ids,
                   const MeshSummary& written, OutputFile* file) {
  clock_.begin("map");
  trim_memory();
  ComparisonNeeds needs =
      estimate_comparison(source_->description(), written.tets, written.points,
                          report_.input.boundary_triangles + written.boundary_triangles);
  needs.fixed += kMapPointBytes * written.points;
  const std::uint64_t sides = needs.sides_within(budget_->free());
  const auto reserved = budget_->reserve(needs.fixed + sides, "the map of the points");
  tetfusion::make_map(source_.get(), path, original_ids, sides, file, context_);
  clock_.begin("write");
}

void Job::verify(const std::string& output, const std::string& path, const InputFacts& facts,
                 const LowerCells& lower, const MeshSummary& written) {
  if (!request_.verify) return;
  clock_.begin("verify");
  const RunChoices choices{source_->description(), steering_choices_, regions_};
  const Promise promise = promise_of(request_.behaviour, choices, facts, lower, written);
  report_.verified.push_back(
      verify_output({output, path}, promise, source_.get(), context_, budget_.get()));
  clock_.begin("write");
}

// Runs rounds until the goal is reached (true) or nothing fuses (false).
template <class Real>
bool Job::reach(const std::optional<std::uint64_t>& goal, Rounds<Real>* rounds,
                RunState<Real>* state) {
  MacroLod<Real>& mesh = state->input.mesh;
  while (!goal || mesh.tets > *goal) {
    if (state->end != StageEnd::kOpen) return state->end == StageEnd::kGoal;
    context_.report("fusing", share_done(report_.input.tets, mesh.tets, stages_.back().tets,
                                         state->lods.size()));
    const RoundPlan plan = plan_round(state->input.box, mesh.tets, goal, *state);
    const RoundStatistics round =
        rounds->run(plan.settings, plan.limits, state->fields, context_, &mesh);
    end_round(plan, round, state);
  }
  return true;
}

// Notes what a round did, and keeps it.
template <class Real>
void Job::end_round(const RoundPlan& plan, const RoundStatistics& round, RunState<Real>* state) {
  planner_.note(plan, round, state);
  trim_memory();
  commit(fmt::format("round-{}", plan.settings.number), state);
}

}  // namespace

SimplifyReport simplify(const SimplifyRequest& request, const RunContext& context) {
  return Job(request, context).run();
}

SimplifyReport simplify(const SimplifyRequest& request, std::unique_ptr<MeshSource> source,
                        const RunContext& context) {
  return Job(request, context, std::move(source)).run();
}

SimplifyReport simplify(const SimplifyRequest& request, std::unique_ptr<MeshSource> source,
                        MeshSink* sink, const RunContext& context) {
  return Job(request, context, std::move(source), sink).run();
}

RunPlan plan_run(const SimplifyRequest& request, const RunContext& context,
                 std::uint64_t sample_tets) {
  return Job(request, context).plan(sample_tets);
}

}  // namespace tetfusion
