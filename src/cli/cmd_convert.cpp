#include <fmt/format.h>

#include <cstddef>
#include <memory>
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

namespace tetfusion {

namespace {

struct ConvertArguments {
  std::string input, output, labels;
  OpenOptions open;
  WriteOptions write;
  int threads = 0;
  ConsoleOptions console;
};

void choose_labels(const MeshDescription& mesh, ConvertArguments* a) {
  if (a->labels.empty()) return;
  std::string name = a->labels;
  if (name.starts_with("cell:")) name.erase(0, std::string_view("cell:").size());
  const std::vector<std::size_t> chosen = choose_regions(mesh, {{name}}, "--labels");
  a->write.label = mesh.cell_data.arrays[chosen.front()].name;
  a->write.label_comes_first = true;
}

void run_convert(ConvertArguments* a) {
  Console console(a->console);
  const double start = wall_seconds();
  const RunContext context = console.context();
  set_thread_count(a->threads);
  check_mesh_output(a->output, a->write.encoding);
  context.report("reading", 0);
  a->open.cancelled = context.cancelled;
  take_chosen_step(&a->input, &a->open.time_step);
  const auto source = open_mesh(a->input, a->open);
  refuse_piece_as_mesh(a->output, source->description());
  choose_labels(source->description(), a);
  const std::string left_out =
      left_out_of(a->output, source->description(), a->write.label, a->write.label_comes_first);
  if (!left_out.empty()) console.say(left_out);
  a->write.report_to(context, 0.5);
  const InputFacts facts = convert_mesh(source.get(), a->output, a->write);
  say_what_is_odd(facts, source->description(), a->open.linearize, context);
  context.report("done", 1);
  console.say(fmt::format("{}: {} -> {} in {:.2f} s", a->input,
                          format_count(facts.tets, "tetrahedron", "tetrahedra"), a->output,
                          wall_seconds() - start));
  console.detail_resources();
}

}  // namespace

void add_convert_command(CLI::App& app) {
  auto a = std::make_shared<ConvertArguments>();
  CLI::App* command = app.add_subcommand("convert", "Convert a mesh between formats and encodings");
  add_input_options(*command, &a->input, &a->open, kOneStep);
  command
      ->add_option(
          "OUT", a->output,
          "The file to write: .vtu, .vtk, .mesh or .meshb (Medit), .msh (Gmsh), .node or .ele "
          "(TetGen), or - for a .vtu to standard output")
      ->required();
  command
      ->add_option("--labels", a->labels,
                   "The cell array of one component (NAME or cell:NAME), of whole numbers, that "
                   "becomes Medit's references, Gmsh's physical groups or TetGen's attributes. "
                   "Default: those of another format, else the first that is named like a region "
                   "(simplify --regions)")
      ->check(not_empty)
      ->group(kOutputGroup);
  add_encoding_option(*command, &a->write.encoding);
  add_thread_option(*command, &a->threads);
  add_console_options(*command, &a->console);
  command->callback([a] { run_convert(a.get()); });
}

}  // namespace tetfusion
