#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "base/numbers.h"
#include "base/resources.h"
#include "base/version.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/findings.h"
#include "driver/convert.h"
#include "follow/apply_map.h"
#include "io/mesh_sink.h"

namespace tetfusion {

namespace {

struct ApplyArguments {
  std::string map, input, output, report;
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

Json report_of_apply(const ApplyArguments& a, const MapFile& map,
                     const std::vector<MovedArray>& arrays) {
  Json json{{"version", version()},
            {"map", a.map},
            {"path", a.input},
            {"output", a.output},
            {"original_points", map.counts().original_points},
            {"points", map.counts().points},
            {"tets", map.counts().tets},
            {"arrays", Json::array()}};
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
  return json;
}

void run_apply(ApplyArguments* a) {
  const double start = wall_seconds();
  Console console(a->console);
  const RunContext context = console.context();
  set_thread_count(a->threads);
  check_mesh_output(a->output, a->write.encoding);
  refuse_same_file("-o", a->output, {a->map});
  check_report(a->report, {a->map, a->input, a->output});
  if (a->report == "-" && a->output == "-") {
    throw Error(ErrorCode::kUsage, "the mesh and the report cannot both go to standard output");
  }
  context.report("reading", 0);
  const MapFile map = MapFile::open(a->map);
  a->open.cancelled = context.cancelled;
  auto source = open_mesh(a->input, a->open);
  console.tell_time_step(a->open.time_step, source->description());
  refuse_piece_as_mesh(a->output, source->description());
  refuse_piece(a->report, source->description());
  const std::vector<MovedArray> arrays = apply_map(map, source.get(), a->arrays, context);
  const StayedPoints stayed = compare_stayed_points(map, source.get(), context);
  const auto result = open_moved(map, arrays, source.get());
  const bool has_cell_arrays = !source->description().cell_data.arrays.empty();
  source.reset();  // it may be what is written over
  const std::string left_out = left_out_of(a->output, result->description());
  if (!left_out.empty()) console.say(left_out);
  a->write.progress = [&](double share) {
    context.check();
    context.report("writing", share);
  };
  a->write.tell = [&](std::string_view what) { context.say(what); };
  convert_mesh(result.get(), a->output, a->write);
  map.check();
  context.report("done", 1);
  for (const MovedArray& moved : arrays) console.say(sentence_of(moved));
  if (stayed.elsewhere > 0) {
    console.say(fmt::format(
        "points that stayed, but lie elsewhere in {}: {} of {}; the result has the points of the "
        "mesh that was simplified, and wrong values if those of this one come in another order",
        a->input, format_count(stayed.elsewhere), format_count(stayed.count)));
  }
  if (has_cell_arrays) {
    console.say("arrays of cells do not follow: a map knows where points went");
  }
  console.detail_resources();
  if (a->report.empty()) return;
  Json json = report_of_apply(*a, map, arrays);
  json["stayed_points"] = stayed.count;
  json["stayed_points_elsewhere"] = stayed.elsewhere;
  json["seconds"] = {{"total", wall_seconds() - start}};
  json["cpu_seconds"] = cpu_seconds();
  json["peak_rss_bytes"] = peak_rss_bytes();
  json["threads"] = thread_count();
  write_text(a->report, dump(json));
}

}  // namespace

void add_apply_command(CLI::App& app) {
  auto a = std::make_shared<ApplyArguments>();
  CLI::App* command = app.add_subcommand(
      "apply", "Bring the point arrays of another step or program onto a simplified mesh");
  command->footer(
      "IN is a mesh of tetrahedra with the points of the one that was simplified, in the same "
      "order; where they lie, and which tetrahedra there are, does not matter.\n"
      "A point that stayed keeps its value, any other one gets what the original mesh has at its "
      "place.");
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
                   "A point array that is wanted; may be given again. Default: all")
      ->check(not_empty)
      ->allow_extra_args(false);
  add_cell_options(*command, &a->open);
  add_time_step_option(*command, &a->open.time_step);
  add_encoding_option(*command, &a->write.encoding);
  add_report_option(*command, &a->report);
  add_thread_option(*command, &a->threads);
  add_console_options(*command, &a->console);
  command->callback([a] { run_apply(a.get()); });
}

}  // namespace tetfusion
