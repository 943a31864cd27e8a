#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>

#include "base/error.h"
#include "base/numbers.h"
#include "base/resources.h"
#include "base/version.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/findings.h"
#include "io/mesh_format.h"
#include "refine/refine.h"

namespace tetfusion {

namespace {

struct RefineArguments {
  RefineRequest request;
  std::string tets, reduction, max_error, max_rms, report;
  int threads = 0;
  ConsoleOptions console;
};

std::optional<double> share_of(const char* option, const std::string& text) {
  if (text.empty()) return std::nullopt;
  const auto share = parse_share(text);
  if (share) return share;
  throw Error(ErrorCode::kUsage,
              fmt::format("{} {}: give a share, as in 1% or 0.01", option, text));
}

void parse_goal(RefineArguments* a) {
  RefineRequest& r = a->request;
  r.reduction = share_of("--reduction", a->reduction);
  if (!a->max_error.empty()) {
    r.max_error = parse_share_of_range("--max-error", a->max_error, "1%");
  }
  if (!a->max_rms.empty()) r.max_rms = parse_share_of_range("--max-rms", a->max_rms, "0.1%");
  if (!a->tets.empty()) r.tets = parse_tets("--tets", a->tets);
}

Json report_of(const RefineArguments& a, const RefineReport& r) {
  Json json = {{"version", version()},
               {"path", a.request.input},
               {"output", a.request.output},
               {"file_bytes", r.file_bytes},
               {"original", {{"tets", r.counts.tets}, {"points", r.counts.points}}},
               {"base", {{"tets", r.counts.base_tets}, {"points", r.counts.base_points}}},
               {"result", {{"tets", r.tets}, {"points", r.points}}},
               {"fusions", r.counts.fusions},
               {"undone", r.undone},
               {"on_disk", r.on_disk},
               {"reached", r.reached}};
  const bool is_known = r.errors != FusionErrors::kNone;
  const char* kind = r.errors == FusionErrors::kLargest ? "max" : "rms";
  if (is_known) json["error"] = {{"kind", kind}, {"value", r.error}};
  if (r.inside) {
    json["region"] = {{"points", *r.inside}, {"needed", *r.needed}};
    if (is_known) json["region"]["error"] = r.error_inside;
  }
  return json;
}

void run_refine(RefineArguments* a) {
  const double start = wall_seconds();
  Console console(a->console);
  const RunContext context = console.context();
  set_thread_count(a->threads);
  parse_goal(a);
  refuse_same_file("-o", a->request.output, {a->request.input});
  check_report_beside(a->request.output, a->report, {a->request.input});
  const RefineReport r = refine(a->request, context);
  console.say(fmt::format("{}: {} -> {}: {} of {} in {:.2f} s", a->request.input,
                          format_count(r.counts.base_tets, "tetrahedron", "tetrahedra"),
                          a->request.output, format_count(r.tets), format_count(r.counts.tets),
                          wall_seconds() - start));
  if (!r.reached) {
    console.say(fmt::format("the file begins with {}: no level of it has fewer",
                            format_count(r.counts.base_tets, "tetrahedron", "tetrahedra")));
  }
  if (r.needed && *r.needed > 0) {
    console.say(fmt::format("inside the region: {} of the original; undone for that: {} of {}",
                            format_count(*r.inside, "point"), format_count(r.undone),
                            format_count(r.counts.fusions, "fusion")));
  }
  if (r.inside && *r.inside == 0) {
    console.say(
        "no point of the original is inside the region: this is the mesh the file begins with");
  }
  if (r.undone == r.counts.fusions) console.say("this is the original");
  console.detail_resources();
  if (a->report.empty()) return;
  Json json = report_of(*a, r);
  json["seconds"] = r.seconds;
  add_resources(start, &json);
  write_text(a->report, dump(json));
}

}  // namespace

void add_refine_command(CLI::App& app) {
  auto a = std::make_shared<RefineArguments>();
  CLI::App* command =
      app.add_subcommand("refine", "Take a simplification back, in part or as a whole");
  command->footer(
      "Without a goal the result is the original: coordinates, cells and arrays, to the bit and in "
      "its order.\n"
      "A level has the numbers of the original's points and cells in their order.");
  command
      ->add_option("FILE", a->request.input,
                   "The file that 'tetfusion simplify --progressive' wrote")
      ->required()
      ->check(not_empty);
  command
      ->add_option("-o,--output", a->request.output,
                   "The mesh: .vtu, .vtk, .mesh or .meshb (Medit), .msh (Gmsh), .node or .ele "
                   "(TetGen), "
                   "or - for a .vtu to standard output")
      ->required()
      ->check(not_empty)
      ->group(kOutputGroup);
  command
      ->add_option("--tets", a->tets,
                   "Refine as far as so many tetrahedra allow, as in 100000, 100k or 2M")
      ->check(not_empty)
      ->group("Goal");
  command
      ->add_option("--reduction", a->reduction,
                   "Leave this share of the original's tetrahedra out, as in 50%")
      ->check(not_empty)
      ->group("Goal");
  command
      ->add_option("--max-error", a->max_error,
                   "The coarsest level on which no array that steered is further from the original "
                   "at any of its points, as a share of its range, as in 1%. The run that wrote "
                   "the file must have measured that, for a --max-error of its own")
      ->check(not_empty)
      ->group("Goal");
  command
      ->add_option(
          "--max-rms", a->max_rms,
          "The coarsest level of which no fusion was estimated to leave a larger root of "
          "the mean square, as a share of the range; of a run that measured no errors, but "
          "not of --method tetfuse")
      ->check(not_empty)
      ->group("Goal");
  command
      ->add_option(
          "--roi", a->request.region,
          "Refine only there, as far as the goal says: box=X0,X1,Y0,Y1,Z0,Z1, "
          "sphere=X,Y,Z,RADIUS, or a point array and a value, as in \"pressure>0.5\" (of a "
          "vector its length). May be given again. All tetrahedra of the original with a "
          "point inside come back; the others stay as they are in the file, but for what "
          "has to make way, which is most of them where nearly all of the original has gone")
      ->allow_extra_args(false)
      ->group("Goal");
  add_encoding_option(*command, &a->request.write.encoding);
  add_report_option(*command, &a->report);
  add_thread_option(*command, &a->threads);
  add_memory_option(*command, &a->request.memory,
                    "Memory to take at most, as in 2G, 512M or 1.5G; what does not fit lies on the "
                    "disk, and the result is the same. Default: half of what the machine or its "
                    "control group allows");
  add_nameless_scratch_option(*command, &a->request.scratch, "Folder on whose disk that lies");
  add_console_options(*command, &a->console);
  command->callback([a] { run_refine(a.get()); });
}

}  // namespace tetfusion
