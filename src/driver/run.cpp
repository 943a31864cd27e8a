#include "driver/run.h"
#include "driver/arrays/weights.h"

#include <fmt/format.h>

#include <utility>

#include "driver/arrays/notices.h"
#include "driver/arrays/regions.h"
#include "driver/export/export.h"
#include "driver/request/check_options.h"
#include "driver/request/stages.h"
#include "driver/run_setup.h"
#include "driver/scratch_place.h"
#include "io/files/output_file.h"
#include "io/open_mesh.h"

namespace tetfusion {

namespace {

// The scratch folder would stand where one of them is to be, when all work is done.
void check_outputs(const SimplifyRequest& request) {
  std::vector<std::string> names{request.progressive, request.also_written};
  for (const Stage& stage : plan_stages(request, kMaxTets)) {
    check_export(stage.path, request.encoding);
    if (!stage.map.empty()) check_output_path(stage.map);
    names.insert(names.end(), {stage.path, stage.map});
  }
  if (!request.progressive.empty()) check_output_path(request.progressive);
  refuse_same_file("--scratch", scratch_folder(request), names);
}

RunInput open_input(const SimplifyRequest& request, std::unique_ptr<MeshSource> source,
                    const RunContext& context) {
  const BehaviourOptions& b = request.behaviour;
  if (!source) {
    source = open_mesh(request.input, open_options(request, spool_folder(request), context));
  }
  const MeshDescription& mesh = source->description();
  std::unique_ptr<MeshStream> stream = source->stream();
  std::vector<SteeringChoice> steering =
      b.arrays.empty() ? choose_what_varies(source.get(), stream.get(), context)
                       : choose_steering(mesh, b.arrays);
  std::vector<std::size_t> regions = choose_regions(mesh, b.regions);
  CarriedArrays carried(mesh);
  const WeightColumn weights = weight_column(b.weight, mesh, carried);
  RegionOfInterest interest(b.interest, request.input, mesh.point_data);
  return {std::move(source),  std::move(stream), std::move(steering), std::move(regions),
          std::move(carried), weights,           std::move(interest)};
}

}  // namespace

Run open_run(const SimplifyRequest& request, std::unique_ptr<MeshSource> source, MeshSink* sink,
             const RunContext& context) {
  check_options(request);
  set_thread_count(request.performance.threads);
  if (sink == nullptr) check_outputs(request);
  context.report("reading", 0);
  PhaseClock clock;
  clock.begin("read");
  RunInput input = open_input(request, std::move(source), context);
  context.check();
  const MeshDescription& mesh = input.description();
  refuse_outputs_among(mesh, request);
  check_levels(request, mesh.cells);
  MeshDescription output = mesh;  // as far as its arrays go
  if (request.behaviour.original_ids) {
    require_no_original_ids(request.input, mesh);
    output.point_data.arrays.push_back(original_ids_info());
  }
  if (sink == nullptr) {
    tell_left_out(request.output, output, region_that_was_named(request.behaviour.regions),
                  context);
  }
  const ReaderNeeds reader = input.stream
                                 ? ReaderNeeds{input.stream->bytes(), input.stream->lower_cells()}
                                 : ReaderNeeds{input.source->memory_to_read(), {}};
  Workplace place(request, mesh, steering_bytes(request, mesh, input.steering, input.regions),
                  reader, context);
  return {request, context, sink, std::move(input), std::move(place), std::move(clock)};
}

Steering read_steering(Run* run) {
  const BehaviourOptions& b = run->request.behaviour;
  const RunContext& context = run->context;
  RunInput& input = run->input;
  if (!input.stream) input.stream = open_stream(input.source.get());
  context.check();
  const MeshDescription& mesh = input.description();
  Steering steering(input.steering, mesh, *input.stream, context);
  if (!steering.fields().empty()) {
    if (b.arrays.empty()) say_what_steers(steering.names(), mesh, input.regions, context);
    return steering;
  }
  const bool has_end = b.method != Method::kFuse || b.reduction || b.tets || !b.lods.empty();
  // What is the same everywhere keeps each bound. Where the user has said that nothing else counts,
  // or this is but one of the steps, that will do.
  const bool may_go_on = !b.arrays.empty() || (run->request.is_step && !input.steering.empty());
  if (!has_end && !may_go_on) throw no_end_in_sight(run->request.input, input.steering, mesh);
  context.say(fmt::format("no array steers{}: geometry alone decides{}",
                          what_could_steer(input.steering, mesh),
                          !has_end                   ? ", as far as it can"
                          : b.max_error || b.max_rms ? ", and no error is limited"
                                                     : ""));
  return steering;
}

}  // namespace tetfusion
