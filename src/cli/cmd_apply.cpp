#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/numbers.h"
#include "base/resources.h"
#include "base/version.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/findings.h"
#include "cli/listed_steps.h"
#include "cli/summaries.h"
#include "driver/arrays/steering.h"
#include "driver/convert.h"
#include "follow/apply_map.h"
#include "follow/point_weights.h"
#include "io/files/file_system.h"
#include "io/left_out.h"
#include "io/mesh_format.h"
#include "io/open_mesh.h"
#include "io/write_mesh.h"
#include "mesh/array_names.h"
#include "series/array_tally.h"
#include "series/each_step.h"
#include "series/series_plan.h"

namespace tetfusion {

namespace {

struct ApplyArguments {
  std::string map, report, scratch;
  StepsRequest meshes;
  bool fit = false;
  std::vector<std::string> arrays;
  int threads = 0;
  ConsoleOptions console;
};

std::string sentence_of(const MovedArray& moved) {
  const ArrayInfo& info = moved.array.info;
  if (!is_float(info.type)) return fmt::format("{}: the nearest point's values", info.name);
  std::string text = fmt::format(
      "{}: off by {:.3g} % of its range in the mean of squares, {:.3g} % at most (point {})",
      info.name, 100 * moved.rms, 100 * moved.max, moved.max_at);
  if (moved.undefined > 0) {
    text += fmt::format("; no number any more at {}", format_count(moved.undefined, "point"));
  }
  return text;
}

std::string sentence_of(const MovedCells& moved) {
  return fmt::format("cell:{}: {}", moved.array.info.name,
                     moved.has_means ? "the means of the cells in each tetrahedron"
                                     : "in each cell the values of one");
}

// Those that are asked for, or all.
struct ArraysToMove {
  std::vector<std::string> points;
  std::vector<std::size_t> cells;
  bool all_points = false;
};

// Cells follow where they are those of the mesh that was simplified. Where they are not, *reason
// says why.
ArraysToMove arrays_to_move(const std::vector<std::string>& names, const MapFile& map,
                            MeshSource* source, const RunContext& context, std::string* reason) {
  const MeshDescription& mesh = source->description();
  ArraysToMove out;
  for (const std::string& name : names) {
    const auto choice = find_array(mesh, name);
    if (!choice) {
      throw Error(ErrorCode::kUsage,
                  fmt::format("{}: --array {}: there is no such array; 'tetfusion info' lists them",
                              mesh.path, name));
    }
    const bool of_cells = choice->association == Association::kCell;
    const AttributeSet& set = of_cells ? mesh.cell_data : mesh.point_data;
    if (is_ghost_mark(set.arrays[choice->index].name)) {
      throw Error(ErrorCode::kUsage,
                  fmt::format("{}: --array {}: that marks ghosts, which the simplified mesh has "
                              "none of",
                              mesh.path, name));
    }
    if (of_cells) {
      if (std::ranges::find(out.cells, choice->index) == out.cells.end()) {
        out.cells.push_back(choice->index);
      }
    } else {
      out.points.push_back(name);
    }
  }
  if (names.empty()) out.cells = cell_arrays_to_move(mesh.cell_data);
  out.all_points = names.empty();
  if (out.cells.empty() || has_cells_of(map, source, context)) return out;
  *reason = fmt::format(
      "{}: arrays of cells do not follow: its tetrahedra are not those of the mesh that was "
      "simplified, in their order",
      mesh.path);
  if (!names.empty()) throw Error(ErrorCode::kBadInput, *reason);
  out.cells.clear();
  return out;
}

// The map, and what is made of it once for all steps.
struct Mover {
  MapFile map;
  std::optional<PointWeights> weights;  // with --fit, as soon as an array of points moves
};

Json json_of(const std::vector<MovedArray>& arrays) {
  Json list = Json::array();
  for (const MovedArray& moved : arrays) {
    const ArrayInfo& info = moved.array.info;
    Json entry{{"name", info.name}, {"type", vtk_name(info.type)}, {"components", info.components}};
    if (is_float(info.type)) {
      entry["rms"] = moved.rms;
      entry["max"] = moved.max;
      entry["max_at_point"] = moved.max_at;
      entry["undefined"] = moved.undefined;
    }
    list.push_back(std::move(entry));
  }
  return list;
}

Json json_of(const std::vector<MovedCells>& cells) {
  Json list = Json::array();
  for (const MovedCells& moved : cells) {
    const ArrayInfo& info = moved.array.info;
    list.push_back({{"name", info.name},
                    {"type", vtk_name(info.type)},
                    {"components", info.components},
                    {"means", moved.has_means}});
  }
  return list;
}

// What became of a mesh.
struct Applied {
  std::vector<MovedArray> arrays;  // without their values
  std::vector<MovedCells> cells;
  StayedPoints stayed;
  std::string without_cells;  // why arrays of cells do not follow; empty: they do
};

std::string sentence_on_stayed(const std::string& mesh, const StayedPoints& stayed) {
  return fmt::format(
      "points that stayed, but lie elsewhere in {}: {} of {}; the result has the points of the "
      "mesh that was simplified, and wrong values if those of this one come in another order",
      mesh, format_count(stayed.elsewhere), format_count(stayed.count));
}

// A mesh, or a step of a series.
Applied apply_to_mesh(const ApplyArguments& a, const Step& mesh, Mover* mover,
                      const RunContext& context, Console* console) {
  const MapFile& map = mover->map;
  OpenOptions open = a.meshes.open;
  open.time_step = mesh.time_step;
  auto source = open_mesh(mesh.input, open);
  console->tell_time_step(open.time_step, source->description());
  refuse_piece_as_mesh(mesh.output, source->description());
  refuse_piece(a.report, source->description());
  Applied out;
  const ArraysToMove wanted =
      arrays_to_move(a.arrays, map, source.get(), context, &out.without_cells);
  if (wanted.all_points || !wanted.points.empty()) {
    if (a.fit && !mover->weights) {
      mover->weights.emplace(map, a.scratch.empty() ? output_folder(mesh.output) : a.scratch);
    }
    out.arrays = apply_map(map, source.get(), wanted.points, context, true,
                           mover->weights ? &*mover->weights : nullptr);
  }
  out.cells = CellMover(map).move(source.get(), wanted.cells, context);
  out.stayed = compare_stayed_points(map, source.get(), context);
  const auto result = open_moved(map, out.arrays, out.cells, source.get());
  source.reset();  // it may be what is written over
  const std::string left_out = left_out_of(mesh.output, result->description());
  if (!left_out.empty()) context.say(left_out);
  WriteOptions write;
  write.encoding = a.meshes.encoding;
  write.report_to(context);
  convert_mesh(result.get(), mesh.output, write);
  map.check();
  context.report("done", 1);
  for (MovedArray& moved : out.arrays) moved.array.bytes = {};
  for (MovedCells& moved : out.cells) moved.array.bytes = {};
  return out;
}

Json json_of(const Step& mesh, const Applied& applied) {
  return {{"path", mesh.input},
          {"output", mesh.output},
          {"arrays", json_of(applied.arrays)},
          {"cell_arrays", json_of(applied.cells)},
          {"stayed_points", applied.stayed.count},
          {"stayed_points_elsewhere", applied.stayed.elsewhere}};
}

Json apply_to_one(const ApplyArguments& a, const Step& mesh, Mover* mover,
                  const RunContext& context, Console* console) {
  const Applied applied = apply_to_mesh(a, mesh, mover, context, console);
  if (!applied.without_cells.empty()) console->say(applied.without_cells);
  for (const MovedArray& moved : applied.arrays) console->say(sentence_of(moved));
  for (const MovedCells& moved : applied.cells) console->say(sentence_of(moved));
  if (applied.stayed.elsewhere > 0) console->say(sentence_on_stayed(mesh.input, applied.stayed));
  return json_of(mesh, applied);
}

// Of all steps: what is worst, and one sentence for each thing to know.
class StepsSummary {
 public:
  void add(const Step& step, const Applied& applied) {
    ++steps_;
    for (const MovedArray& moved : applied.arrays) {
      if (!is_float(moved.array.info.type)) continue;
      worst_.add(moved.array.info.name, step.label, moved.rms, moved.max);
      undefined_ += moved.undefined;
    }
    if (!applied.without_cells.empty() && without_cells_++ == 0) why_ = applied.without_cells;
    if (applied.stayed.elsewhere > 0 && elsewhere_++ == 0) {
      moved_ = sentence_on_stayed("step " + step.label, applied.stayed);
    }
  }

  void say(Console* console) const {
    if (without_cells_ > 0) console->say(of_steps(without_cells_) + why_);
    worst_.say(console);
    if (undefined_ > 0) {
      console->say(fmt::format("values that are no number any more: {} (--report has them by step)",
                               format_count(undefined_)));
    }
    if (elsewhere_ > 0) console->say(of_steps(elsewhere_) + moved_);
  }

 private:
  std::string of_steps(std::size_t count) const {
    return fmt::format("in {} of {}: ", count, format_count(steps_, "step"));
  }

  WorstErrors worst_;
  std::uint64_t undefined_ = 0;
  std::size_t steps_ = 0, without_cells_ = 0, elsewhere_ = 0;
  std::string why_, moved_;  // of the first of them
};

// Returns what the report says of them.
Json apply_to_steps(const ApplyArguments& a, SeriesPlan plan, Mover* mover,
                    const RunContext& context, Console* console) {
  Json steps = Json::array();
  StepsSummary summary;
  ArrayTally tally(plan.steps.size());
  for_each_step(&plan, a.meshes.open, context, [&](const Step& step, const RunContext& part) {
    const Applied applied = apply_to_mesh(a, step, mover, part, console);
    summary.add(step, applied);
    AttributeSet points, cells;
    for (const MovedArray& moved : applied.arrays) points.arrays.push_back(moved.array.info);
    for (const MovedCells& moved : applied.cells) cells.arrays.push_back(moved.array.info);
    tally.note(steps.size(), points, cells);
    Json json{{"step", step.label}};
    if (step.time) json["time"] = *step.time;
    json.update(json_of(step, applied));
    steps.push_back(std::move(json));
    for (const MovedArray& moved : applied.arrays) {
      console->detail(fmt::format("{}: {}", step.output, sentence_of(moved)));
    }
  });
  write_list(plan, context);
  tally.say_what_is_missing(labels_of(plan), context);
  summary.say(console);
  console->say(fmt::format("{} -> {}", format_count(plan.steps.size(), "step"), a.meshes.output));
  Json json = Json::object();
  if (!plan.list.empty()) json["list"] = plan.list;
  json["steps"] = std::move(steps);
  return json;
}

void run_apply(ApplyArguments* a) {
  const double start = wall_seconds();
  Console console(a->console);
  const RunContext context = console.context();
  set_thread_count(a->threads);
  a->meshes.open.cancelled = context.cancelled;
  a->meshes.also_written = {a->report};
  const std::optional<SeriesPlan> plan = plan_if_series(&a->meshes);
  const Step one = only_mesh(a->meshes);
  if (plan) {
    for (const Step& step : plan->steps) refuse_same_file("-o", step.output, {a->map});
    std::vector<std::string> others = files_of(*plan);
    others.push_back(a->map);
    check_report(a->report, others);
  } else {
    check_mesh_output(one.output, a->meshes.encoding);
    refuse_same_file("-o", one.output, {a->map});
    check_report_beside(one.output, a->report, {a->map, one.input});
  }
  context.report("reading", 0);
  Mover mover{MapFile::open(a->map), {}};
  Json json{{"version", version()},
            {"map", a->map},
            {"fitted", a->fit},
            {"original_points", mover.map.counts().original_points},
            {"points", mover.map.counts().points},
            {"tets", mover.map.counts().tets}};
  json.update(plan ? apply_to_steps(*a, *plan, &mover, context, &console)
                   : apply_to_one(*a, one, &mover, context, &console));
  console.detail_resources();
  if (a->report.empty()) return;
  add_resources(start, &json);
  write_text(a->report, dump(json));
}

}  // namespace

void add_apply_command(CLI::App& app) {
  auto a = std::make_shared<ApplyArguments>();
  CLI::App* command = app.add_subcommand(
      "apply", "Bring the arrays of another step or program onto a simplified mesh");
  command->footer(
      "IN is a mesh of tetrahedra with the points of the one that was simplified, in the same "
      "order; where they lie does not matter.\n"
      "A point that stayed keeps its value, any other one gets what the original mesh has at its "
      "place. Cells get the means of those that lie in them, if IN has the tetrahedra of the mesh "
      "that was simplified, in the same order; else only arrays of points follow.");
  command->add_option("MAP", a->map, "The file that 'tetfusion simplify --map' wrote")
      ->required()
      ->check(not_empty);
  command
      ->add_option("IN", a->meshes.inputs,
                   "A mesh with the arrays, or - for standard input. Several files, a .pvd, or a "
                   "file with several time steps where OUT is named as those of a series")
      ->required()
      ->check(not_empty);
  command
      ->add_option(
          "-o,--output", a->meshes.output,
          "The simplified mesh with these arrays: .vtu, .vtk, .mesh or .meshb (Medit), .msh "
          "(Gmsh), .node or .ele (TetGen), or - for a .vtu to standard output. Of a series a name "
          "that holds {step}, or a .pvd")
      ->required()
      ->check(not_empty)
      ->group(kOutputGroup);
  command
      ->add_option("--array", a->arrays,
                   "An array that is wanted: NAME of points, cell:NAME of cells; may be given "
                   "again. Default: all")
      ->check(not_empty)
      ->allow_extra_args(false);
  command->add_flag("--fit", a->fit,
                    "Fit the values of new points, of floating-point arrays, so that errors at the "
                    "points of the original are smaller, as 'simplify' does; they may then leave "
                    "the range of those round them, but not that of the array");
  add_cell_options(*command, &a->meshes.open);
  add_time_step_option(*command, &a->meshes.open.time_step, kStepByOutput);
  add_encoding_option(*command, &a->meshes.encoding);
  add_report_option(*command, &a->report);
  add_thread_option(*command, &a->threads);
  add_nameless_scratch_option(*command, &a->scratch,
                              "Folder on whose disk the map lies once more with --fit, 112 bytes "
                              "at most for each point of IN")
      ->needs("--fit");
  add_console_options(*command, &a->console);
  command->callback([a] { run_apply(a.get()); });
}

}  // namespace tetfusion
