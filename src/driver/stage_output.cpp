#include "driver/stage_output.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/resources.h"
#include "driver/arrays/regions.h"
#include "driver/export/export.h"
#include "driver/export/progressive.h"
#include "driver/promise.h"
#include "driver/request/error_limits.h"
#include "driver/run_setup.h"
#include "follow/make_map.h"
#include "io/files/output_file.h"

namespace tetfusion {

namespace {

// A phase in the midst of writing.
class PhaseWithin {
 public:
  PhaseWithin(const std::string& phase, Run* run) : clock_(run->clock) { clock_.begin(phase); }
  ~PhaseWithin() { clock_.begin("write"); }
  PhaseWithin(const PhaseWithin&) = delete;
  PhaseWithin& operator=(const PhaseWithin&) = delete;

 private:
  PhaseClock& clock_;
};

// Null where values stay as they are.
template <class Real>
std::unique_ptr<FittedValues<Real>> fit_values(const RunState<Real>& state, Run* run) {
  if (state.values == nullptr || state.values->chunks() == 0) return nullptr;
  const PhaseWithin phase("fit", run);
  return std::make_unique<FittedValues<Real>>(
      *state.values, state.mesh,
      move_limits(run->request.behaviour, state.values->columns(), state.fields), thread_count(),
      run->place.scratch());
}

template <class Real>
void write_way_back(Run* run, const RunContext& context, Coarsening<Real>* coarsening,
                    OutputFile* file) {
  const PhaseWithin phase("progressive", run);
  const RunState<Real>& state = coarsening->state();
  write_progressive<Real>(
      {.layout = coarsening->layout(),
       .carried = run->input.carried,
       .errors = noted_errors(run->request.behaviour, tolerances_of(state.fields)),
       .source = run->input.source.get(),
       .mesh = state.mesh,
       .input = state.input,
       .logs = coarsening->logs(),
       .context = context,
       .budget = run->place.budget(),
       .scratch = run->place.scratch()},
      file);
}

// What a result is looked at with, before it has its name.
struct WrittenResult {
  WrittenOutput file;
  const MeshSummary& mesh;
};

void write_map(const WrittenResult& result, OriginalNumbers numbers, const InputFacts& facts,
               Run* run, const RunContext& context, OutputFile* file) {
  const PhaseWithin phase("map", run);
  trim_memory();
  MemoryBudget* budget = run->place.budget();
  ComparisonNeeds needs =
      estimate_comparison(run->input.description(), result.mesh.tets, result.mesh.points,
                          facts.boundary_faces + result.mesh.boundary_triangles);
  needs.fixed += kMapPointBytes * result.mesh.points + kMapTetBytes * result.mesh.tets;
  const std::uint64_t sides = needs.sides_within(budget->free());
  const auto reserved = budget->reserve(needs.fixed + sides, "the map");
  make_map(run->input.source.get(), result.file.path,
           {std::move(numbers), names_of_cell_arrays(run->input.description(), run->input.regions),
            run->request.map_homes},
           sides, file, context);
}

Verification verify(const WrittenResult& result, const InputFacts& facts, const LowerCells& lower,
                    Run* run, const RunContext& context) {
  const PhaseWithin phase("verify", run);
  const RunInput& in = run->input;
  const RunChoices choices{in.description(), in.steering, in.regions};
  const Promise promise = promise_of(run->request.behaviour, choices, facts, lower, result.mesh);
  return verify_output(result.file, promise, in.source.get(), context, run->place.budget());
}

ExportSettings settings_of(const Stage& stage, const Run& run) {
  ExportSettings settings;
  settings.path = stage.path;
  settings.encoding = run.request.encoding;
  settings.label = region_that_was_named(run.request.behaviour.regions);
  settings.threads = thread_count();
  settings.pieces = run.request.pieces;
  settings.sink = run.sink;
  settings.original_ids = run.request.behaviour.original_ids;
  settings.has_numbers = keeps_numbers(run.request);
  return settings;
}

}  // namespace

template <class Real>
StageOutput write_stage(const Stage& stage, bool is_last, Run* run, Coarsening<Real>* coarsening) {
  run->clock.begin("write");
  is_last ? coarsening->end_rounds() : coarsening->pause();
  const SimplifyRequest& request = run->request;
  const RunState<Real>& state = coarsening->state();
  StageOutput done;
  ExportSettings out = settings_of(stage, *run);
  const double begin = coarsening->share_done();
  const double end = is_last ? 1 : begin;
  const double half = looks_at_result(request) ? (begin + end) / 2 : end;
  const double way_back_end = run->keeps_logs() ? (begin + half) / 2 : begin;
  out.progress = [&](double part) {
    run->context.check();
    run->context.report("writing", way_back_end + (half - way_back_end) * part);
  };
  const auto fitted = fit_values(state, run);
  std::optional<OutputFile> way_back, map;
  if (run->keeps_logs()) {
    way_back.emplace(request.progressive, OutputFile::Access::kPatch);
    write_way_back(run, run->context.part(begin, way_back_end), coarsening, &*way_back);
  }
  OriginalNumbers numbers;
  if (!stage.map.empty()) {
    out.point_ids = &numbers.points;
    out.cell_numbers = &numbers.cells;
    map.emplace(stage.map, OutputFile::Access::kPatch);
  }
  if (looks_at_result(request)) {
    out.inspect = [&](const std::string& path, const MeshSummary& written) {
      const InputFacts& facts = state.input.facts;
      const WrittenResult result{{stage.path, path}, written};
      const double mapped = map && request.verify ? (half + end) / 2 : map ? end : half;
      if (map) {
        write_map(result, std::move(numbers), facts, run, run->context.part(half, mapped), &*map);
      }
      if (request.verify) {
        done.verified =
            verify(result, facts, state.input.lower.cells, run, run->context.part(mapped, end));
      }
      if (map) map->finish();
    };
  }
  // Before the output, which may have the input's name: the way back is all that is left of it
  // then.
  const auto name_others = [&] {
    if (map) map->commit();
    if (way_back) way_back->commit();
    map.reset();
    way_back.reset();
  };
  out.before_name = name_others;
  done.mesh = export_mesh<Real>({.mesh = state.mesh,
                                 .layout = coarsening->layout(),
                                 .lower = state.input.lower,
                                 .carried = run->input.carried,
                                 .fitted = fitted.get(),
                                 .source = run->input.source.get(),
                                 .settings = out,
                                 .context = run->context,
                                 .budget = run->place.budget(),
                                 .scratch = run->place.scratch()});
  if (fitted) run->clock.move("write", "fit", fitted->seconds() / thread_count());
  if (run->sink != nullptr) name_others();
  return done;
}

template StageOutput write_stage(const Stage&, bool, Run*, Coarsening<float>*);
template StageOutput write_stage(const Stage&, bool, Run*, Coarsening<double>*);

}  // namespace tetfusion
