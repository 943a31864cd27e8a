#include <fmt/format.h>

#include <memory>
#include <string>

#include "base/error.h"
#include "base/numbers.h"
#include "base/resources.h"
#include "base/version.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/findings.h"
#include "io/output_file.h"
#include "refine/refine.h"

namespace tetfusion {

namespace {

struct Arguments {
  RefineRequest request;
  std::string tets, reduction, report;
  int threads = 0;
  ConsoleOptions console;
};

void parse_goal(Arguments* a) {
  RefineRequest& r = a->request;
  if (!a->tets.empty()) {
    r.tets = parse_count(a->tets);
    if (!r.tets) {
      throw Error(ErrorCode::kUsage,
                  fmt::format("--tets {}: give a whole number, as in 100000, 100k or 2M", a->tets));
    }
  }
  if (a->reduction.empty()) return;
  r.reduction = parse_share(a->reduction);
  if (!r.reduction) {
    throw Error(ErrorCode::kUsage,
                fmt::format("--reduction {}: give a share, as in 50% or 0.5", a->reduction));
  }
}

Json report_of(const Arguments& a, const RefineReport& r) {
  return {{"version", version()},
          {"path", a.request.input},
          {"output", a.request.output},
          {"file_bytes", r.file_bytes},
          {"original", {{"tets", r.counts.tets}, {"points", r.counts.points}}},
          {"base", {{"tets", r.counts.base_tets}, {"points", r.counts.base_points}}},
          {"result", {{"tets", r.tets}, {"points", r.points}}},
          {"fusions", r.counts.fusions},
          {"undone", r.undone},
          {"reached", r.reached}};
}

void run(Arguments* a) {
  const double start = wall_seconds();
  Console console(a->console);
  const RunContext context = console.context();
  set_thread_count(a->threads);
  parse_goal(a);
  refuse_same_file("-o", a->request.output, {a->request.input});
  refuse_same_file("--report", a->report, {a->request.input, a->request.output});
  if (!a->report.empty()) check_output_path(a->report);
  if (a->report == "-" && a->request.output == "-") {
    throw Error(ErrorCode::kUsage, "the mesh and the report cannot both go to standard output");
  }
  const RefineReport r = refine(a->request, context);
  console.say(fmt::format("{}: {} tetrahedra -> {}: {} of {} in {:.2f} s", a->request.input,
                          format_count(r.counts.base_tets), a->request.output, format_count(r.tets),
                          format_count(r.counts.tets), wall_seconds() - start));
  if (!r.reached) {
    console.say(fmt::format("the file begins with {} tetrahedra: no level of it has fewer",
                            format_count(r.counts.base_tets)));
  }
  if (r.undone == r.counts.fusions) console.say("this is the original");
  console.detail_resources();
  if (a->report.empty()) return;
  Json json = report_of(*a, r);
  json["seconds"] = r.seconds;
  json["seconds"]["total"] = wall_seconds() - start;
  json["cpu_seconds"] = cpu_seconds();
  json["peak_rss_bytes"] = peak_rss_bytes();
  json["threads"] = thread_count();
  write_text(a->report, dump(json));
}

}  // namespace

void add_refine_command(CLI::App& app) {
  auto a = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("refine", "Take a simplification back, in part or as a whole");
  command->footer(
      "Without a goal the result is the original: coordinates, cells and arrays, to the bit and in "
      "its order.\n"
      "A level has the numbers of the original's points and cells in their order.");
  command
      ->add_option("FILE", a->request.input,
                   "The file that 'tetfusion simplify --progressive' wrote")
      ->required();
  command
      ->add_option("-o,--output", a->request.output,
                   "The mesh: .vtu, .vtk, .mesh or .meshb (Medit), .msh (Gmsh), .node or .ele "
                   "(TetGen), "
                   "or - for a .vtu to standard output")
      ->required()
      ->group(kOutputGroup);
  command
      ->add_option("--tets", a->tets,
                   "Refine as far as so many tetrahedra allow, as in 100000, 100k or 2M")
      ->group("Goal");
  command
      ->add_option("--reduction", a->reduction,
                   "Leave this share of the original's tetrahedra out, as in 50%")
      ->group("Goal");
  add_encoding_option(*command, &a->request.write.encoding);
  add_report_option(*command, &a->report);
  add_thread_option(*command, &a->threads);
  add_console_options(*command, &a->console);
  command->callback([a] { run(a.get()); });
}

}  // namespace tetfusion
