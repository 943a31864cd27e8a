#include <memory>

#include "base/resources.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "driver/result.h"
#include "io/mesh_sink.h"
#include "io/mesh_source.h"

namespace tetfusion {

namespace {

struct Arguments {
  std::string input, output;
  OpenOptions open;
  WriteOptions write;
  int threads = 0;
  ConsoleOptions console;
};

void run(Arguments* a) {
  Console console(a->console);
  const RunContext context = console.context();
  set_thread_count(a->threads);
  check_mesh_output(a->output);
  context.report("reading", 0);
  const auto source = open_mesh(a->input, a->open);
  Result result;
  result.mesh = source->read_geometry();
  const Vector<std::uint64_t> points = std::move(result.mesh.point_source);
  const Vector<std::uint64_t> tets = std::move(result.mesh.tet_source);
  const Vector<std::uint64_t> lower = std::move(result.mesh.lower_source);
  result.point_ids = count_up<VertexId>(point_count(result.mesh.points));
  result.tet_ids = count_up<TetId>(result.mesh.tets.size());
  a->write.progress = [&](double share) {
    context.check();
    context.report("writing", 0.5 + 0.5 * share);
  };
  write_result(result, {}, {points, tets, lower}, a->output, a->write, source.get());
}

}  // namespace

void add_convert_command(CLI::App& app) {
  auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("convert", "Convert a mesh between formats and encodings");
  command->add_option("IN", a->input, "The mesh, or - for standard input")->required();
  command->add_option("OUT", a->output, "The file to write, .vtu, or - for standard output")
      ->required();
  command->add_flag("--tetrahedralize", a->open.tetrahedralize,
                    "Split hexahedra, voxels, wedges and pyramids into tetrahedra");
  command->add_flag("--linearize", a->open.linearize,
                    "Take ten-node tetrahedra as straight-edged ones");
  add_encoding_option(*command, &a->write.encoding);
  add_thread_option(*command, &a->threads);
  add_console_options(*command, &a->console);
  command->callback([a] { run(a.get()); });
}

}  // namespace tetfusion
