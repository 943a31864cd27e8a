#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/numbers.h"
#include "base/resources.h"
#include "base/version.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/findings.h"
#include "cli/listed_steps.h"
#include "compare/compare.h"
#include "compare/interfaces.h"
#include "compare/needs.h"
#include "driver/arrays/notices.h"
#include "io/mesh_format.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "io/vtk/series_list.h"

namespace tetfusion {

namespace {

struct CompareArguments {
  std::string original, simplified, report;
  std::string max_rms, max_error, surface, interfaces;
  std::vector<std::string> arrays;
  OpenOptions open;
  int threads = 0;
  std::uint64_t memory = 0;  // 0: half of what there is
  ConsoleOptions console;
};

std::optional<double> take_bound(std::string_view option, const std::string& text) {
  if (text.empty()) return std::nullopt;
  const auto share = parse_share(text);
  if (share && is_bare_one(text)) {
    throw Error(ErrorCode::kUsage, fmt::format("{} {}: give 100% or 1%", option, text));
  }
  if (share && *share >= 0 && *share <= 1) return share;
  throw Error(ErrorCode::kUsage,
              fmt::format("{} {}: give a share from 0 to 100%, as in 1% or 0.01", option, text));
}

Bounds take_bounds(const CompareArguments& a) {
  return {take_bound("--max-rms", a.max_rms), take_bound("--max-error", a.max_error),
          take_bound("--surface", a.surface), a.arrays, take_bound("--interfaces", a.interfaces)};
}

std::string percent(double share) {
  if (!std::isfinite(share)) return "infinite";
  return share == 0 ? "0" : fmt::format("{:.4g} %", 100 * share);
}

void add_mesh(std::string_view label, const std::string& path, const MeshSize& size,
              std::string* text) {
  fmt::format_to(std::back_inserter(*text), "{:<11}{}: {}, {}, {}\n", label, path,
                 format_count(size.points, "point"),
                 format_count(size.tets, "tetrahedron", "tetrahedra"),
                 format_count(size.boundary_triangles, "boundary triangle"));
}

void add_domain(const Comparison& c, std::string* text) {
  const auto out = std::back_inserter(*text);
  const double tets = static_cast<double>(c.original.tets);
  const double gone = 1 - static_cast<double>(c.simplified.tets) / tets;
  fmt::format_to(out, "  {:<34}{:>14}\n", "tetrahedra gone", percent(gone));
  fmt::format_to(out, "  {:<34}{:>14}\n", "change of the volume", percent(c.volume_change));
  fmt::format_to(out, "  {:<34}{:>14}", "original points outside", format_count(c.outside_points));
  if (c.outside_points > 0) {
    fmt::format_to(out, "  up to {} of the diagonal", percent(c.outside_max));
  }
  fmt::format_to(out, "\n  {:<34}{:>14}\n", "original cell centres outside",
                 format_count(c.outside_cells));
  if (c.identical_surface) {
    fmt::format_to(out, "  {:<34}{:>14}\n", "surface", "identical");
    return;
  }
  fmt::format_to(out, "  {:<34}{:>14}{:>14}\n", "surface, shares of the diagonal", "max", "mean");
  const auto add = [&](std::string_view label, const SurfaceShares& s) {
    fmt::format_to(out, "    {:<32}{:>14}{:>14}\n", label, percent(s.max), percent(s.mean));
  };
  add("original to simplified", c.to_simplified);
  add("simplified to original", c.to_original);
}

std::string place_of(const Point& p) {
  return fmt::format("({:.9g}, {:.9g}, {:.9g})", p.x, p.y, p.z);
}

// What is special about an array: one line, or none.
std::string remarks(const ArrayComparison& a) {
  std::string text;
  const std::string_view item = a.association == Association::kCell ? "cell" : "point";
  if (a.non_finite > 0) {
    text += fmt::format("; {} left out, not finite", format_count(a.non_finite, item));
  }
  if (a.undefined > 0) {
    text += fmt::format("; {} left out, not finite in the simplified mesh, the first at {}",
                        format_count(a.undefined, item), place_of(a.undefined_at));
  }
  if (a.range == 0) text += "; constant: shares of its value";
  constexpr double kWorthTelling = 1e-6;
  if (a.rounding > kWorthTelling && a.rounding > 0.1 * a.max && a.max > 0) {
    text += fmt::format("; rounding to {} makes up to {} of this", vtk_name(a.info.type),
                        percent(a.rounding));
  }
  return text.empty() ? text : fmt::format("    {}\n", text.substr(2));
}

// The region whose volume has changed most, as share of its own.
std::string region_line(const ArrayComparison& a) {
  if (a.regions.empty()) return "";
  double most = 0;
  double value = 0;
  for (const RegionVolume& r : a.regions) {
    const double change = std::abs(r.simplified - r.original);
    const double share = change == 0       ? 0
                         : r.original == 0 ? std::numeric_limits<double>::infinity()
                                           : change / r.original;
    if (share > most) value = r.value;
    most = std::max(most, share);
  }
  std::string text = fmt::format("    change of the volumes of {}: {}",
                                 format_count(a.regions.size(), "region"), percent(most));
  if (most > 0) text += fmt::format(" at most, that of {:.17g}", value);
  if (!a.interfaces) return text + "\n";
  if (a.interfaces->identical) return text + "; interfaces identical\n";
  return text +
         fmt::format("; interfaces up to {} of the diagonal apart\n", percent(a.interfaces->max()));
}

void add_arrays(const Comparison& c, Association association, std::string* text) {
  const auto out = std::back_inserter(*text);
  const bool cells = association == Association::kCell;
  bool first = true;
  for (const ArrayComparison& a : c.arrays) {
    if (a.association != association) continue;
    if (first) {
      fmt::format_to(out, "{:<24} {:>12} {:>12} {:>12} {:>12} {:>12} {:>12}\n",
                     cells ? "Cell arrays" : "Point arrays", "rms", "max",
                     cells ? "L1 error" : "cell rms", cells ? "L1 change" : "cell max",
                     cells ? "" : "gradient", "integral");
    }
    first = false;
    fmt::format_to(out, "  {:<22} {:>12} {:>12}", a.info.name, percent(a.rms), percent(a.max));
    if (a.integer) {
      fmt::format_to(out, "  {} of {} differ\n", percent(a.differing),
                     cells ? "the volume" : "the points");
    } else {
      fmt::format_to(out, " {:>12} {:>12} {:>12} {:>12}\n",
                     percent(cells ? a.l1_error : a.cell_rms),
                     percent(cells ? a.l1_change : a.cell_max),
                     cells ? "" : percent(a.gradient_rms), percent(a.integral_change));
    }
    if (a.max > 0) {
      fmt::format_to(out, "    largest at {}\n", place_of(a.max_at));
    }
    *text += region_line(a) + remarks(a);
  }
}

std::string table(const CompareArguments& a, const Comparison& c,
                  const std::vector<BoundResult>& bounds) {
  std::string text;
  const auto out = std::back_inserter(text);
  add_mesh("original", a.original, c.original, &text);
  add_mesh("simplified", a.simplified, c.simplified, &text);
  add_domain(c, &text);
  add_arrays(c, Association::kPoint, &text);
  add_arrays(c, Association::kCell, &text);
  for (const std::string& name : c.missing_arrays) fmt::format_to(out, "Missing: {}\n", name);
  for (const RetypedArray& r : c.retyped_arrays) {
    fmt::format_to(out, "Other type: {}: {}, was {}\n", r.name, r.simplified, r.original);
  }
  std::uint64_t broken = 0;
  for (const BoundResult& bound : bounds) {
    if (!bound.broken) continue;
    fmt::format_to(out, "{}\n", bound.sentence);
    ++broken;
  }
  if (!bounds.empty() && broken == 0) text += "All bounds are kept\n";
  if (bounds.empty() && !(a.max_rms.empty() && a.max_error.empty())) {
    text += "The original has no floating-point array to hold against the bounds\n";
  }
  return text;
}

Json size_json(const std::string& path, const MeshSize& size) {
  return {{"path", path},
          {"points", size.points},
          {"tets", size.tets},
          {"boundary_triangles", size.boundary_triangles},
          {"volume", size.volume}};
}

Json surface_json(bool identical, const SurfaceShares& to_simplified,
                  const SurfaceShares& to_original) {
  const auto side = [](const SurfaceShares& s) { return Json{{"max", s.max}, {"mean", s.mean}}; };
  return {{"identical", identical},
          {"max", std::max(to_simplified.max, to_original.max)},
          {"mean", std::max(to_simplified.mean, to_original.mean)},
          {"original_to_simplified", side(to_simplified)},
          {"simplified_to_original", side(to_original)}};
}

Json array_json(const ArrayComparison& a) {
  const bool cells = a.association == Association::kCell;
  Json json{{"name", a.info.name},
            {"association", cells ? "cell" : "point"},
            {"type", vtk_name(a.info.type)},
            {"components", a.info.components},
            {"range", a.range},
            {"component_ranges", a.component_ranges},
            {"rms", a.rms},
            {"max", a.max},
            {"max_at", {a.max_at.x, a.max_at.y, a.max_at.z}},
            {"differing", a.differing},
            {"non_finite", a.non_finite},
            {"undefined", a.undefined}};
  if (a.max == 0) json["max_at"] = nullptr;
  for (const RegionVolume& r : a.regions) {
    json["regions"].push_back(
        {{"value", r.value}, {"original", r.original}, {"simplified", r.simplified}});
  }
  if (a.interfaces) {
    json["interfaces"] = surface_json(a.interfaces->identical, a.interfaces->to_simplified,
                                      a.interfaces->to_original);
  }
  if (a.integer) {
    json["integral_change"] = nullptr;
    return json;
  }
  json["integral_change"] = a.integral_change;
  if (cells) {
    json["l1_change"] = a.l1_change;
    json["l1_error"] = a.l1_error;
  } else {
    json["cell_rms"] = a.cell_rms;
    json["cell_max"] = a.cell_max;
    json["gradient_rms"] = a.gradient_rms;
  }
  return json;
}

Json bounds_json(const std::vector<BoundResult>& bounds) {
  Json json = Json::array();
  for (const BoundResult& b : bounds) {
    Json entry{{"bound", b.bound}, {"limit", b.limit}, {"value", b.value}, {"broken", b.broken}};
    if (b.broken) entry["sentence"] = b.sentence;
    if (!b.array.empty()) entry["array"] = b.array;
    json.push_back(entry);
  }
  return json;
}

Json report(const CompareArguments& a, const Comparison& c,
            const std::vector<BoundResult>& bounds) {
  Json json{{"version", version()},
            {"original", size_json(a.original, c.original)},
            {"simplified", size_json(a.simplified, c.simplified)},
            {"reduction",
             1 - static_cast<double>(c.simplified.tets) / static_cast<double>(c.original.tets)},
            {"diagonal", c.diagonal},
            {"volume_change", c.volume_change},
            {"merged_points", c.joined.points},
            {"differing_points", c.joined.differing},
            {"outside_points", c.outside_points},
            {"outside_max", c.outside_max},
            {"outside_cells", c.outside_cells},
            {"surface", surface_json(c.identical_surface, c.to_simplified, c.to_original)}};
  json["arrays"] = Json::array();
  for (const ArrayComparison& array : c.arrays) json["arrays"].push_back(array_json(array));
  json["missing_arrays"] = c.missing_arrays;
  json["retyped_arrays"] = Json::array();
  for (const RetypedArray& r : c.retyped_arrays) {
    json["retyped_arrays"].push_back(
        {{"name", r.name}, {"original", r.original}, {"simplified", r.simplified}});
  }
  json["bounds"] = bounds_json(bounds);
  return json;
}

// What is compared with what.
struct StepPair {
  StepToRead original, simplified;
};

StepPair pair_of_meshes(const CompareArguments& a) {
  StepPair pair{{a.original, {}, a.open.time_step}, {a.simplified, {}, {}}};
  if (time_steps_of(a.simplified, a.open).size() > 1) {
    pair.simplified.time_step = a.open.time_step;
    if (time_steps_of(a.original, a.open).empty()) pair.original.time_step.reset();
  }
  return pair;
}

// A mesh beside a file of several steps is what became of the first, or of the one that is chosen.
bool compares_steps(const CompareArguments& a) {
  if (is_list_name(a.original) || is_list_name(a.simplified)) return true;
  return !a.open.time_step && has_own_steps(a.original, a.open) &&
         has_own_steps(a.simplified, a.open);
}

// Each step with the other's of that number.
std::vector<StepPair> pairs_of_steps(const CompareArguments& a) {
  const std::vector<StepToRead> originals = steps_to_read(a.original, a.open);
  // One that is alone is what became of the step that --time-step says.
  OpenOptions all = a.open;
  all.time_step.reset();
  std::vector<StepToRead> simplified = steps_to_read(a.simplified, all);
  if (simplified.size() > 1) simplified = steps_to_read(a.simplified, a.open);
  if (originals.size() != simplified.size()) {
    throw Error(ErrorCode::kUsage,
                fmt::format("{} is {}, and {} {}: say which one is meant (--time-step), or give "
                            "the files of two steps",
                            a.original, format_count(originals.size(), "step"), a.simplified,
                            format_count(simplified.size())));
  }
  std::vector<StepPair> pairs;
  for (std::size_t i = 0; i < originals.size(); ++i) {
    refuse_same_file("--report", a.report, {originals[i].path, simplified[i].path});
    pairs.push_back({originals[i], simplified[i]});
  }
  return pairs;
}

struct CompareAnswer {
  Json json;
  std::string text;
  std::vector<std::string> broken;  // a sentence for each bound
};

// The patches that were left out are not in it, and not all formats have points to be joined.
OpenOptions options_of_simplified(const StepToRead& step, const OpenOptions& open) {
  OpenOptions options = step.options(open);
  options.dropped_patches.clear();
  options.merge_points = options.merge_points && can_merge_points(step.path);
  return options;
}

CompareAnswer compare_pair(const CompareArguments& a, const StepPair& pair, const Bounds& bounds,
                           const RunContext& context, Console* console) {
  const auto original = open_mesh(pair.original.path, pair.original.options(a.open));
  const auto simplified =
      open_mesh(pair.simplified.path, options_of_simplified(pair.simplified, a.open));
  console->tell_time_step(pair.original.time_step, original->description());
  console->tell_time_step(pair.simplified.time_step, simplified->description());
  refuse_piece(a.report, original->description());
  refuse_piece(a.report, simplified->description());
  require_arrays(bounds, original->description());
  const std::uint64_t memory = memory_to_use(a.memory);
  const std::uint64_t sides = plan_comparison(original.get(), simplified.get(), memory);
  Comparison comparison = compare_meshes(original.get(), simplified.get(), context, sides);
  add_interfaces(original.get(), simplified.get(), context, &comparison);
  if (comparison.joined.differing > 0) {
    InputFacts facts;
    facts.merged_points = comparison.joined.points;
    facts.differing_points = comparison.joined.differing;
    facts.largest_difference = comparison.joined.largest;
    say_what_was_joined(facts, original->description(), context);
  }
  const std::vector<BoundResult> results = judge_bounds(comparison, bounds);
  if (bounds.interfaces && std::ranges::none_of(results, [](const BoundResult& result) {
        return result.bound == "interfaces";
      })) {
    context.say(
        "--interfaces: no cell array that is named like materials says several regions (and no "
        "more than 65,536, or 4096 of floating-point numbers), so that there was nothing to hold "
        "against it");
  }
  const bool limits_errors = bounds.max_rms || bounds.max_error;
  if (!bounds.arrays.empty() && !limits_errors) keep_arrays(bounds.arrays, &comparison);
  CompareArguments named = a;
  named.original = pair.original.path;
  named.simplified = pair.simplified.path;
  CompareAnswer answer{report(named, comparison, results), table(named, comparison, results), {}};
  for (const BoundResult& result : results) {
    if (result.broken) answer.broken.push_back(result.sentence);
  }
  return answer;
}

// Of all pairs together.
CompareAnswer join_steps(const CompareArguments& a, const std::vector<StepPair>& pairs,
                         const std::vector<CompareAnswer>& answers) {
  CompareAnswer all{{{"version", version()},
                     {"original", {{"path", a.original}}},
                     {"simplified", {{"path", a.simplified}}}},
                    "",
                    {}};
  std::size_t broken = 0;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    Json step = answers[i].json;
    step.erase("version");
    if (pairs[i].original.time) step["time"] = *pairs[i].original.time;
    all.json["steps"].push_back(step);
    all.text += (pairs[i].simplified.time_step ? name_of(pairs[i].simplified) + ":\n" : "") +
                answers[i].text + "\n";
    for (const std::string& sentence : answers[i].broken) {
      all.broken.push_back(fmt::format("{}: {}", name_of(pairs[i].simplified), sentence));
    }
    broken += answers[i].broken.empty() ? 0 : 1;
  }
  all.text += fmt::format("{} compared", format_count(answers.size(), "step"));
  all.text += broken > 0 ? fmt::format(", bounds broken at {}\n", format_count(broken)) : "\n";
  return all;
}

CompareAnswer compare(CompareArguments a, const Bounds& bounds) {
  Console console(a.console);
  const RunContext context = console.context();
  a.open.memory = a.memory;
  a.open.cancelled = context.cancelled;
  const bool is_series = compares_steps(a);
  const std::vector<StepPair> pairs =
      is_series ? pairs_of_steps(a) : std::vector{pair_of_meshes(a)};
  const auto share = [&](std::size_t i) {
    return static_cast<double>(i) / static_cast<double>(pairs.size());
  };
  std::vector<CompareAnswer> answers;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    RunContext part = context.part(share(i), share(i + 1));
    if (is_series) {
      part.notice = [&](std::string_view message) {
        context.say(fmt::format("{}: {}", name_of(pairs[i].original), message));
      };
    }
    answers.push_back(compare_pair(a, pairs[i], bounds, part, &console));
  }
  context.report("done", 1);
  console.detail_resources();
  return is_series ? join_steps(a, pairs, answers) : std::move(answers[0]);
}

void run_compare(const CompareArguments& a) {
  const double start = wall_seconds();
  if (a.original == "-" && a.simplified == "-") {
    throw Error(ErrorCode::kUsage, "only one of the meshes can come from standard input");
  }
  check_report(a.report, {a.original, a.simplified});
  const Bounds bounds = take_bounds(a);
  set_thread_count(a.threads);
  const CompareAnswer answer = compare(a, bounds);
  if (!a.report.empty()) {
    Json json = answer.json;
    add_resources(start, &json);
    write_text(a.report, dump(json));
  }
  const bool shown = a.report != "-" && !a.console.quiet;
  if (shown) write_text("-", answer.text);
  for (const std::string& sentence : answer.broken) {
    if (!shown) print_error(sentence);
  }
  if (!answer.broken.empty()) throw ExitStatus{ErrorCode::kBroken};
}

void add_bound_options(CLI::App& command, CompareArguments* a) {
  constexpr const char* kGroup = "Bounds (exit code 1 if one is broken)";
  command
      .add_option(
          "--max-error", a->max_error,
          "The largest error at any point of the original (of a cell array: at any centre of "
          "its cells), as share of the array's range: 1% or 0.01")
      ->check(not_empty)
      ->group(kGroup);
  command
      .add_option("--max-rms", a->max_rms, "The rms of these errors, as share of the array's range")
      ->check(not_empty)
      ->group(kGroup);
  command
      .add_option("--surface", a->surface,
                  "The distance between the surfaces, either way, as share of the diagonal; "
                  "measured at corners and centres of their triangles")
      ->check(not_empty)
      ->group(kGroup);
  command
      .add_option("--interfaces", a->interfaces,
                  "The same of the surfaces between regions, for each cell array that is named "
                  "like materials")
      ->check(not_empty)
      ->group(kGroup);
  command
      .add_option("--array", a->arrays,
                  "The point array that the first two are for, or cell:NAME (may be repeated). "
                  "Default: all floating-point point arrays. Without these two: the one that is "
                  "shown")
      ->check(not_empty)
      ->allow_extra_args(false)
      ->group(kGroup);
}

}  // namespace

void add_compare_command(CLI::App& app) {
  auto a = std::make_shared<CompareArguments>();
  CLI::App* command =
      app.add_subcommand("compare", "Measure what a simplification did to a mesh and its arrays");
  command->footer(
      "Errors of point arrays are taken at the points of the original, and ('cell ...') at the "
      "centres of its\n"
      "cells. Integers are compared with the value at the nearest corner. Points outside the "
      "simplified mesh take\n"
      "the value at the nearest point of its surface, and count.\n"
      "Of lists of steps (.pvd, .series), and of two files with several of their own, each is "
      "compared with the\n"
      "other's of that number, or those that --time-step says.");
  command->add_option("ORIGINAL", a->original, "The mesh, or - for standard input")
      ->required()
      ->check(not_empty);
  command->add_option("SIMPLIFIED", a->simplified, "What became of it, or - for standard input")
      ->required()
      ->check(not_empty);
  add_cell_options(*command, &a->open);
  add_time_step_option(*command, &a->open.time_step,
                       "all, each with its own. Of SIMPLIFIED, too, where it has several");
  add_report_option(*command, &a->report);
  add_bound_options(*command, a.get());
  add_memory_option(*command, &a->memory,
                    "Memory to take at most, as in 2G, 512M or 1.5G; the simplified mesh must fit. "
                    "With less the original is read more often, with the same results. Default: "
                    "half of what the machine or its control group allows");
  add_thread_option(*command, &a->threads);
  add_console_options(*command, &a->console);
  command->callback([a] { run_compare(*a); });
}

}  // namespace tetfusion
