#include <fmt/format.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/numbers.h"
#include "base/resources.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/listed_steps.h"
#include "driver/arrays/notices.h"
#include "driver/arrays/regions.h"
#include "driver/convert.h"
#include "io/left_out.h"
#include "io/mesh_format.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "io/write_mesh.h"
#include "series/each_step.h"
#include "series/series_plan.h"

namespace tetfusion {

namespace {

struct ConvertArguments {
  std::string input, labels;
  StepsRequest meshes;
  int threads = 0;
  ConsoleOptions console;
};

void choose_labels(const MeshDescription& mesh, const std::string& wanted, WriteOptions* write) {
  if (wanted.empty()) return;
  std::string name = wanted;
  if (name.starts_with("cell:")) name.erase(0, std::string_view("cell:").size());
  const std::vector<std::size_t> chosen = choose_regions(mesh, {{name}}, "--labels");
  write->label = mesh.cell_data.arrays[chosen.front()].name;
  write->label_comes_first = true;
}

// A mesh, or a step of a series.
void convert_one(const ConvertArguments& a, const Step& mesh, const RunContext& context) {
  const double start = wall_seconds();
  OpenOptions open = a.meshes.open;
  open.time_step = mesh.time_step;
  const auto source = open_mesh(mesh.input, open);
  refuse_piece_as_mesh(mesh.output, source->description());
  WriteOptions write;
  write.encoding = a.meshes.encoding;
  choose_labels(source->description(), a.labels, &write);
  const std::string left_out =
      left_out_of(mesh.output, source->description(), write.label, write.label_comes_first);
  if (!left_out.empty()) context.say(left_out);
  write.report_to(context, 0.5);
  const InputFacts facts = convert_mesh(source.get(), mesh.output, write);
  say_what_is_odd(facts, source->description(), open.linearize, context);
  context.report("done", 1);
  context.say(fmt::format("{}: {} -> {} in {:.2f} s", mesh.input,
                          format_count(facts.tets, "tetrahedron", "tetrahedra"), mesh.output,
                          wall_seconds() - start));
}

void run_convert(ConvertArguments* a) {
  Console console(a->console);
  const RunContext context = console.context();
  set_thread_count(a->threads);
  a->meshes.inputs = {a->input};
  a->meshes.open.cancelled = context.cancelled;
  std::optional<SeriesPlan> plan = plan_if_series(&a->meshes);
  if (plan) {
    for_each_step(&*plan, a->meshes.open, context,
                  [&](const Step& step, const RunContext& part) { convert_one(*a, step, part); });
    write_list(*plan, context);
  } else {
    check_mesh_output(a->meshes.output, a->meshes.encoding);
    context.report("reading", 0);
    convert_one(*a, only_mesh(a->meshes), context);
  }
  console.detail_resources();
}

}  // namespace

void add_convert_command(CLI::App& app) {
  auto a = std::make_shared<ConvertArguments>();
  CLI::App* command = app.add_subcommand("convert", "Convert a mesh between formats and encodings");
  add_input_options(*command, &a->input, &a->meshes.open, kStepByOutput);
  command
      ->add_option(
          "OUT", a->meshes.output,
          "The file to write: .vtu, .vtk, .mesh or .meshb (Medit), .msh (Gmsh), .node or .ele "
          "(TetGen), or - for a .vtu to standard output. A name that holds {step}, or a .pvd, is "
          "for all time steps of IN")
      ->required()
      ->check(not_empty);
  command
      ->add_option("--labels", a->labels,
                   "The cell array of one component (NAME or cell:NAME), of whole numbers, that "
                   "becomes Medit's references, Gmsh's physical groups or TetGen's attributes. "
                   "Default: those of another format, else the first that is named like a region "
                   "(simplify --regions)")
      ->check(not_empty)
      ->group(kOutputGroup);
  add_encoding_option(*command, &a->meshes.encoding);
  add_thread_option(*command, &a->threads);
  add_console_options(*command, &a->console);
  command->callback([a] { run_convert(a.get()); });
}

}  // namespace tetfusion
