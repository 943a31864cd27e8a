#include <fmt/format.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "base/error.h"
#include "base/numbers.h"
#include "base/resources.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "generate/generate.h"

namespace tetfusion {

namespace {

struct GenerateArguments {
  std::string kind;
  std::string tets = "1M";
  std::string output;
  GenerateOptions generate;
  WriteOptions write;
  int threads = 0;
  ConsoleOptions console;
};

const std::map<std::string, LatticeKind>& kinds() {
  static const std::map<std::string, LatticeKind> kinds{
      {"five", LatticeKind::kFive}, {"kuhn", LatticeKind::kKuhn}, {"bcc", LatticeKind::kBcc}};
  return kinds;
}

void run_generate(GenerateArguments* a) {
  Console console(a->console);
  const RunContext context = console.context();
  set_thread_count(a->threads);
  const auto tets = parse_count(a->tets);
  if (!tets) {
    throw Error(ErrorCode::kUsage,
                fmt::format("--tets: '{}' is not a count; write 1000000, 2.5M or 1G", a->tets));
  }
  a->generate.kind = kinds().at(a->kind);
  a->generate.tets = *tets;
  context.report_size(*tets);
  a->write.report_to(context);
  const GeneratedSize size = generate_mesh(a->generate, a->output, a->write);
  context.report("done", 1);
  console.detail(fmt::format("{}, {}", format_count(size.points, "point"),
                             format_count(size.tets, "tetrahedron", "tetrahedra")));
  console.detail_resources();
}

void add_shape_options(CLI::App& command, GenerateOptions* options) {
  command
      .add_option("--jitter", options->jitter,
                  "Move inner points by up to this share of what cannot invert a tetrahedron, 0 to "
                  "below 1")
      ->capture_default_str();
  command
      .add_option("--grading", options->grading,
                  "Largest cube over smallest one along each axis, where there are many; 1 to 10000")
      ->capture_default_str();
  command.add_flag("--shuffle", options->shuffle, "Points and tetrahedra in pseudo-random order");
  command.add_option("--seed", options->seed, "Seed of jitter and order, a whole number")
      ->check(CLI::Validator(
          [](const std::string& text) -> std::string {
            return number_in<std::uint64_t>(text) ? "" : "it is a whole number below 2^64";
          },
          ""))
      ->capture_default_str();
  command
      .add_option(
          "--time", options->time,
          "Where the array 'front' stands: a sphere of radius 0.2 + 0.1 time, in the unit box")
      ->capture_default_str();
  command.add_flag("--double", options->double_precision, "Float64 points instead of Float32");
}

}  // namespace

void add_generate_command(CLI::App& app) {
  auto a = std::make_shared<GenerateArguments>();
  CLI::App* command =
      app.add_subcommand("generate", "Write a test mesh of any size, in constant memory");
  command
      ->add_option("KIND", a->kind,
                   "five: cubes cut in five; kuhn: in six round a diagonal; bcc: body-centred "
                   "lattice, the best shapes")
      ->required()
      ->check(CLI::IsMember(kinds()));
  add_shape_options(*command, &a->generate);
  command
      ->add_option("--tets", a->tets,
                   "About how many tetrahedra, as 1000000, 2.5M, 1G; at most 2^40")
      ->capture_default_str();
  command
      ->add_option("-o,--output", a->output,
                   "The mesh to write: a .vtu, or what convert writes; or - for standard output")
      ->required()
      ->check(not_empty);
  add_encoding_option(*command, &a->write.encoding);
  add_thread_option(*command, &a->threads);
  add_console_options(*command, &a->console, "Say more: sizes, time and memory");
  command->callback([a] { run_generate(a.get()); });
}

}  // namespace tetfusion
