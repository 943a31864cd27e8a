#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/numbers.h"
#include "base/resources.h"
#include "base/version.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/findings.h"
#include "cli/listed_steps.h"
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

namespace tetfusion {

namespace {

struct ApplyArguments {
  std::string map, input, output, report, scratch;
  bool fit = false;
  std::vector<std::string> arrays;
  OpenOptions open;
  WriteOptions write;
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

// Cells follow where they are those of the mesh that was simplified.
ArraysToMove arrays_to_move(const ApplyArguments& a, const MapFile& map, MeshSource* source,
                            const RunContext& context) {
  const MeshDescription& mesh = source->description();
  ArraysToMove out;
  for (const std::string& name : a.arrays) {
    const auto choice = find_array(mesh, name);
    const bool of_cells = choice && choice->association == Association::kCell;
    const AttributeSet& set = of_cells ? mesh.cell_data : mesh.point_data;
    if (choice && is_ghost_mark(set.arrays[choice->index].name)) {
      throw Error(ErrorCode::kUsage,
                  fmt::format("{}: --array {}: that marks ghosts, which the simplified mesh has "
                              "none of",
                              a.input, name));
    }
    if (of_cells) {
      if (std::ranges::find(out.cells, choice->index) == out.cells.end()) {
        out.cells.push_back(choice->index);
      }
    } else {
      out.points.push_back(name);  // or none, which is refused later
    }
  }
  if (a.arrays.empty()) out.cells = cell_arrays_to_move(mesh.cell_data);
  out.all_points = a.arrays.empty();
  if (out.cells.empty() || has_cells_of(map, source, context)) return out;
  const std::string reason =
      "arrays of cells do not follow: its tetrahedra are not those of the mesh that was "
      "simplified, in their order";
  if (!a.arrays.empty()) {
    throw Error(ErrorCode::kBadInput, fmt::format("{}: {}", a.input, reason));
  }
  context.say(fmt::format("{}: {}", a.input, reason));
  out.cells.clear();
  return out;
}

std::vector<MovedArray> move_points(const ApplyArguments& a, const MapFile& map, MeshSource* source,
                                    const std::vector<std::string>& names,
                                    const RunContext& context) {
  std::optional<PointWeights> weights;
  if (a.fit) weights.emplace(map, a.scratch.empty() ? output_folder(a.output) : a.scratch);
  return apply_map(map, source, names, context, true, weights ? &*weights : nullptr);
}

Json report_of_apply(const ApplyArguments& a, const MapFile& map,
                     const std::vector<MovedArray>& arrays, const std::vector<MovedCells>& cells) {
  Json json{{"version", version()},
            {"map", a.map},
            {"path", a.input},
            {"output", a.output},
            {"fitted", a.fit},
            {"original_points", map.counts().original_points},
            {"points", map.counts().points},
            {"tets", map.counts().tets},
            {"arrays", Json::array()},
            {"cell_arrays", Json::array()}};
  for (const MovedArray& moved : arrays) {
    const ArrayInfo& info = moved.array.info;
    Json entry{{"name", info.name}, {"type", vtk_name(info.type)}, {"components", info.components}};
    if (is_float(info.type)) {
      entry["rms"] = moved.rms;
      entry["max"] = moved.max;
      entry["max_at_point"] = moved.max_at;
      entry["undefined"] = moved.undefined;
    }
    json["arrays"].push_back(entry);
  }
  for (const MovedCells& moved : cells) {
    const ArrayInfo& info = moved.array.info;
    json["cell_arrays"].push_back({{"name", info.name},
                                   {"type", vtk_name(info.type)},
                                   {"components", info.components},
                                   {"means", moved.has_means}});
  }
  return json;
}

void run_apply(ApplyArguments* a) {
  const double start = wall_seconds();
  Console console(a->console);
  const RunContext context = console.context();
  set_thread_count(a->threads);
  check_mesh_output(a->output, a->write.encoding);
  refuse_same_file("-o", a->output, {a->map});
  check_report_beside(a->output, a->report, {a->map, a->input});
  context.report("reading", 0);
  const MapFile map = MapFile::open(a->map);
  a->open.cancelled = context.cancelled;
  take_chosen_step(&a->input, &a->open.time_step);
  auto source = open_mesh(a->input, a->open);
  console.tell_time_step(a->open.time_step, source->description());
  refuse_piece_as_mesh(a->output, source->description());
  refuse_piece(a->report, source->description());
  const ArraysToMove wanted = arrays_to_move(*a, map, source.get(), context);
  std::vector<MovedArray> arrays;
  if (wanted.all_points || !wanted.points.empty()) {
    arrays = move_points(*a, map, source.get(), wanted.points, context);
  }
  const std::vector<MovedCells> cells = CellMover(map).move(source.get(), wanted.cells, context);
  const StayedPoints stayed = compare_stayed_points(map, source.get(), context);
  const auto result = open_moved(map, arrays, cells, source.get());
  source.reset();  // it may be what is written over
  const std::string left_out = left_out_of(a->output, result->description());
  if (!left_out.empty()) console.say(left_out);
  a->write.report_to(context);
  convert_mesh(result.get(), a->output, a->write);
  map.check();
  context.report("done", 1);
  for (const MovedArray& moved : arrays) console.say(sentence_of(moved));
  for (const MovedCells& moved : cells) console.say(sentence_of(moved));
  if (stayed.elsewhere > 0) {
    console.say(fmt::format(
        "points that stayed, but lie elsewhere in {}: {} of {}; the result has the points of the "
        "mesh that was simplified, and wrong values if those of this one come in another order",
        a->input, format_count(stayed.elsewhere), format_count(stayed.count)));
  }
  console.detail_resources();
  if (a->report.empty()) return;
  Json json = report_of_apply(*a, map, arrays, cells);
  json["stayed_points"] = stayed.count;
  json["stayed_points_elsewhere"] = stayed.elsewhere;
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
  command->add_option("MAP", a->map, "The file that 'tetfusion simplify --map' wrote")->required();
  command->add_option("IN", a->input, "A mesh with the arrays, or - for standard input")
      ->required();
  command
      ->add_option(
          "-o,--output", a->output,
          "The simplified mesh with these arrays: .vtu, .vtk, .mesh or .meshb (Medit), .msh "
          "(Gmsh), .node or .ele (TetGen), or - for a .vtu to standard output")
      ->required()
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
  add_cell_options(*command, &a->open);
  add_time_step_option(*command, &a->open.time_step, kOneStep);
  add_encoding_option(*command, &a->write.encoding);
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
