#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <memory>
#include <system_error>

#include "base/error.h"
#include "base/numbers.h"
#include "base/resources.h"
#include "base/version.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/findings.h"
#include "cli/listed_steps.h"
#include "driver/convert.h"
#include "driver/examine/examine.h"
#include "io/left_out.h"
#include "io/mesh_format.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "io/vtk/series_list.h"
#include "repair/repair.h"

namespace tetfusion {

namespace {

struct CheckArguments {
  std::string input, report, fixed;
  OpenOptions open;
  WriteOptions write;
  ExamineOptions examine;
  bool strict = false;
  int threads = 0;
  ConsoleOptions console;
};

struct Verdict {
  std::uint64_t failures = 0;  // kinds
  std::uint64_t warnings = 0;

  bool valid(bool strict) const { return failures == 0 && (!strict || warnings == 0); }
};

Verdict judge(const std::vector<Finding>& findings) {
  Verdict verdict;
  for (const Finding& f : findings) {
    if (f.count == 0) continue;
    if (f.severity == Severity::kFailure) ++verdict.failures;
    if (f.severity == Severity::kWarning) ++verdict.warnings;
  }
  return verdict;
}

std::string verdict_sentence(const Verdict& verdict, bool strict) {
  if (verdict.failures > 0) return "INVALID\n";
  if (verdict.warnings == 0) return "Valid\n";
  return strict ? "INVALID: with --strict, warnings count\n" : "Valid, with warnings\n";
}

// The shape of the histogram in one line of 18 digits: 9 for the fullest bin, at least 1, '.' for
// an empty one.
std::string sparkline(const std::array<std::uint64_t, kQualityBins>& bins) {
  const std::uint64_t most =
      std::max<std::uint64_t>(1, *std::max_element(bins.begin(), bins.end()));
  std::string line;
  for (const std::uint64_t n : bins) {
    const double ninths = 9 * static_cast<double>(n) / static_cast<double>(most);
    line += n == 0 ? '.' : static_cast<char>('0' + std::max(1, static_cast<int>(ninths)));
  }
  return line;
}

std::string table(const std::string& path, const Examination& examination,
                  const std::vector<Finding>& findings) {
  const InspectionSummary& mesh = examination.mesh;
  const Quality& q = examination.quality;
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "{}: {}, {}, {}\n", path, format_count(mesh.points, "point"),
                 format_count(mesh.tets, "tetrahedron", "tetrahedra"),
                 format_count(mesh.boundary_faces, "boundary triangle"));
  for (const Finding& f : findings) {
    if (f.severity == Severity::kNote && f.count == 0) continue;
    const std::string_view mark = f.count == 0                       ? ""
                                  : f.severity == Severity::kFailure ? "  FAIL"
                                  : f.severity == Severity::kWarning ? "  warning"
                                                                     : "  note";
    const std::string samples = describe_samples(f);
    fmt::format_to(out, "  {:<34}{:>14}{}{}{}\n", f.label, format_count(f.count), mark,
                   samples.empty() ? "" : ": ", samples);
  }
  fmt::format_to(out, "  {:<34}{:>14}\n", "parts connected by faces",
                 format_count(mesh.components));
  fmt::format_to(out, "  {:<34}{:>14}\n", "boundary surfaces",
                 format_count(mesh.surface_components));
  fmt::format_to(out, "  {:<34}{:>14}\n", "Euler number of the boundary", mesh.surface_euler());
  fmt::format_to(out, "  {:<34}{:>14.9g}\n", "volume", mesh.volume);
  const auto add_quality = [&](std::string_view label, const Distribution& d,
                               std::string_view shape) {
    fmt::format_to(out, "  {:<34}{:>14.3g}{:>10.3g}{:>10.3g}  {}\n", label, d.min, d.p1, d.mean,
                   shape);
  };
  fmt::format_to(out, "  {:<34}{:>14}{:>10}{:>10}  {}\n", "", "least", "1 % below", "mean",
                 "from worst to best: none ., most 9");
  add_quality("mean ratio, 0 to 1", q.mean_ratio, sparkline(q.mean_ratio_bins));
  add_quality("smallest dihedral angle, 0 to 90", q.min_dihedral_deg, sparkline(q.dihedral_bins));
  fmt::format_to(out, "  {:<34}{:>14.3g} to {:.3g}, up to {:.3g} : 1 in a cell\n", "edge lengths",
                 q.shortest_edge, q.longest_edge, q.max_aspect);
  const std::string winding = describe_winding(mesh);
  if (!winding.empty()) fmt::format_to(out, "{}\n", winding);
  return text;
}

struct Answer {
  bool valid;  // the input
  Json json;
  std::string text;
  bool is_sound = valid;  // what was written, with --fix
};

// The report's keys, for a mesh that could be judged.
Json measurements(const Examination& examination, const std::vector<Finding>& findings,
                  const AttributeSet& point_data) {
  const InspectionSummary& mesh = examination.mesh;
  Json json = counts_json(mesh);
  json.update(findings_json(findings));
  json["largest_difference"] = difference_json(mesh.largest_difference, point_data);
  json["nonconforming_faces"] = mesh.foldover_faces + mesh.overfull_faces;
  json.update(quality_json(examination.quality));
  return json;
}

// The same keys without values, for one that could not.
Answer answer_invalid(const std::string& why) {
  Json json{{"error", why}};
  json.update(measurements({}, list_findings({}, {}), {}));
  for (auto& [key, value] : json.items()) {
    if (key != "error") value = nullptr;
  }
  return {false, json, why + "\nINVALID\n"};
}

Answer answer(const CheckArguments& a, const std::string& path, const MeshDescription& mesh,
              const Examination& examination) {
  const std::vector<Finding> findings = list_findings(examination.mesh, mesh.point_data);
  const Verdict verdict = judge(findings);
  return {verdict.valid(a.strict), measurements(examination, findings, mesh.point_data),
          table(path, examination, findings) + verdict_sentence(verdict, a.strict)};
}

// Adds what was mended, and the verdict on the mesh that was written, which is the one that counts.
void fix(const CheckArguments& a, MeshSource* source, const Examination& examination,
         Console* console, Answer* answer_of_input) {
  const RunContext context = console->context();
  const RepairedMesh mended = repair(source, examination.mesh.duplicate_tets > 0, context);
  const Repairs& r = mended.repairs;
  const std::string left_out = left_out_of(a.fixed, source->description());
  if (!left_out.empty()) console->say(left_out);
  WriteOptions write = a.write;
  write.report_to(context);
  convert_mesh(mended.source.get(), a.fixed, write);
  std::error_code unknown;
  const bool can_be_read = std::filesystem::is_regular_file(a.fixed, unknown);
  OpenOptions open;  // cells are split, points joined and patches left out already
  open.memory = a.examine.memory;
  open.cancelled = context.cancelled;
  const auto written = can_be_read ? open_mesh(a.fixed, open) : nullptr;
  MeshSource* const result = can_be_read ? written.get() : mended.source.get();
  const Answer after =
      answer(a, a.fixed, result->description(), examine(result, a.examine, context));
  answer_of_input->text +=
      fmt::format("\nmended: {} rewound, {} and {} dropped\n{}", format_count(r.rewound, "cell"),
                  format_count(r.duplicate_tets, "duplicate cell"),
                  format_count(r.unused_points, "unused point"), after.text);
  Json json{{"path", a.fixed},
            {"rewound", r.rewound},
            {"duplicate_tets_dropped", r.duplicate_tets},
            {"unused_points_dropped", r.unused_points},
            {"valid", after.valid},
            {"after", after.json}};
  answer_of_input->json["fix"] = json;
  answer_of_input->is_sound = after.valid;
}

Answer check(const CheckArguments& a) {
  Console console(a.console);
  const RunContext context = console.context();
  try {
    context.report("reading", 0);
    OpenOptions open = a.open;
    open.memory = a.examine.memory;
    open.cancelled = context.cancelled;
    const auto source = open_mesh(a.input, open);
    // What --fix leaves out says it, too.
    if (a.fixed.empty()) console.tell_time_step(a.open.time_step, source->description());
    refuse_piece(a.report, source->description());
    refuse_piece_as_mesh(a.fixed, source->description());
    const Examination examination = examine(source.get(), a.examine, context);
    Answer result = answer(a, a.input, source->description(), examination);
    if (!a.fixed.empty()) fix(a, source.get(), examination, &console, &result);
    context.report("done", 1);
    console.detail_resources();
    return result;
  } catch (const InvalidMesh& e) {
    Answer found = answer_invalid(e.what());
    if (!a.fixed.empty()) {
      found.text += fmt::format("Nobody can mend that: {} was not written\n", a.fixed);
    }
    return found;
  }
}

// Every step by itself; all of them must be valid.
Answer check_steps(const CheckArguments& a) {
  if (!a.fixed.empty()) {
    throw Error(ErrorCode::kUsage,
                a.input + ": --fix mends one mesh: give one of the files that the list names");
  }
  Answer all{true, {}, ""};
  std::size_t invalid = 0;
  const std::vector<StepToRead> steps = steps_to_read(a.input, a.open);
  for (const StepToRead& step : steps) refuse_same_file("--report", a.report, {step.path});
  for (const StepToRead& step : steps) {
    CheckArguments one = a;
    one.input = step.path;
    one.open = step.options(a.open);
    const Answer found = check(one);
    invalid += found.valid ? 0 : 1;
    Json json = step_json(step);
    json["valid"] = found.valid;
    json.update(found.json);
    all.json["steps"].push_back(json);
    all.text += (step.time_step ? name_of(step) + ":\n" : "") + found.text + "\n";
  }
  all.text +=
      fmt::format("{} of {} invalid\n", format_count(invalid), format_count(steps.size(), "step"));
  all.valid = all.is_sound = invalid == 0;
  return all;
}

void run_check(const CheckArguments& a) {
  const double start = wall_seconds();
  set_thread_count(a.threads);
  check_report(a.report, {a.input, a.fixed});
  if (!a.fixed.empty()) {
    check_mesh_output(a.fixed, a.write.encoding);
    if (a.fixed == "-" && (a.report == "-" || !a.console.quiet)) {
      throw Error(ErrorCode::kUsage,
                  "the mesh and what was found cannot both go to standard output: give a name "
                  "after --fix, or --quiet");
    }
  }
  // Of a file's own steps --fix takes one, the first unless --time-step says another.
  const bool all_steps = is_list_name(a.input) ||
                         (a.fixed.empty() && !a.open.time_step && has_own_steps(a.input, a.open));
  const Answer found = all_steps ? check_steps(a) : check(a);
  if (!a.report.empty()) {
    Json json{{"version", version()}, {"path", a.input}, {"valid", found.valid}};
    json.update(found.json);
    add_resources(start, &json);
    write_text(a.report, dump(json));
  }
  if (a.report != "-" && !a.console.quiet) write_text("-", found.text);
  if (!found.is_sound) throw ExitStatus{ErrorCode::kBroken};
}

}  // namespace

void add_check_command(CLI::App& app) {
  auto a = std::make_shared<CheckArguments>();
  CLI::App* command = app.add_subcommand("check", "Find out whether a mesh is valid, and how good");
  command->footer(
      "Fails (exit code 1) on inverted or duplicate cells, faces that do not conform, vertex ids "
      "out of range\n"
      "and coordinates that are not finite. Degenerate cells and a boundary that is no manifold "
      "are warnings.\n"
      "Of a list of steps (.pvd, .series), and of a file with several of its own, each is looked "
      "at, or the one\n"
      "that --time-step says.");
  add_input_options(*command, &a->input, &a->open, "all");
  add_report_option(*command, &a->report);
  command->add_flag("--strict", a->strict, "Fail on warnings, too");
  command
      ->add_option("--fix", a->fixed,
                   "Write the mesh to this file with what can be mended without guessing: cells "
                   "wound the other way are rewound, duplicate cells and unused points dropped. "
                   "The exit code is that of the mended mesh")
      ->check(not_empty);
  add_encoding_option(*command, &a->write.encoding);
  add_thread_option(*command, &a->threads);
  add_memory_options(*command, &a->examine.memory, &a->examine.scratch);
  add_console_options(*command, &a->console);
  command->callback([a] { run_check(*a); });
}

}  // namespace tetfusion
