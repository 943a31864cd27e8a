#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/bit_set.h"
#include "base/error.h"
#include "base/name_list.h"
#include "base/numbers.h"
#include "base/resources.h"
#include "base/version.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/findings.h"
#include "cli/listed_steps.h"
#include "driver/arrays/regions.h"
#include "driver/arrays/rows_in_use.h"
#include "driver/arrays/steering.h"
#include "driver/examine/examine.h"
#include "io/formats/mesh_passes.h"
#include "io/formats/xml_text.h"
#include "io/gmsh/gmsh_writer.h"
#include "io/mesh_format.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "io/source/mesh_stream.h"
#include "io/source/stream_windows.h"
#include "io/vtk/series_list.h"
#include "mesh/statistics.h"

namespace tetfusion {

namespace {

struct InfoArguments {
  std::string input, report;
  OpenOptions open;
  ExamineOptions examine;
  int threads = 0;
  ConsoleOptions console;
};

struct ArrayLine {
  std::string_view association;
  ArrayInfo info;
  std::vector<std::string> active;  // "Scalars", "GlobalIds", ...
  ArrayStatistics statistics;
  std::vector<std::pair<std::int64_t, std::int64_t>> groups = {};  // of a name of Gmsh's groups
  std::vector<std::string> texts = {};                             // of an array of strings
};

// Of a window whose first row has that number.
void keep_rows(const BitSet& in_use, std::uint64_t first, DataArray* window) {
  const std::uint64_t row_bytes = window->info.row_bytes();
  std::uint64_t kept = 0;
  for (std::uint64_t i = 0; i < window->info.tuples; ++i) {
    if (!in_use.has(first + i)) continue;
    if (kept != i) {
      std::copy_n(window->bytes.data() + i * row_bytes, row_bytes,
                  window->bytes.data() + kept * row_bytes);
    }
    ++kept;
  }
  window->info.tuples = kept;
  window->bytes.resize(kept * row_bytes);
}

// In windows, where the file can be read so; of points those that tetrahedra use.
ArrayStatistics measure_rows(const MeshStream& stream, Association association, std::size_t index,
                             const ArrayInfo& info, const BitSet& in_use,
                             const RunContext& context) {
  const std::uint64_t all = association == Association::kPoint ? stream.points() : stream.cells();
  ArrayStatistics statistics;
  statistics.components.resize(info.components);
  DataArray window;
  window.info = info;
  const auto add = [&](std::uint64_t first, std::uint64_t count) {
    window.info.tuples = count;
    window.bytes.resize(window.info.values() * size_of(info.type));
    stream.read_rows(association, index, first, count, window.bytes);
    keep_rows(in_use, first, &window);
    statistics.add(measure_array(window));
  };
  for_each_window(all, context, add, stream_window(info.row_bytes()));
  return statistics;
}

// Tag and dimension of each.
std::vector<std::pair<std::int64_t, std::int64_t>> gmsh_groups(const DataArray& array) {
  std::vector<std::pair<std::int64_t, std::int64_t>> groups;
  if (!is_gmsh_name(array.info)) return groups;
  const Vector<std::int64_t> values = to_integers(array.info, array.bytes);
  for (std::size_t i = 0; i + 1 < values.size(); i += 2) {
    groups.emplace_back(values[i], values[i + 1]);
  }
  return groups;
}

std::vector<ArrayLine> measure_arrays(MeshSource* source, const RunContext& context) {
  const MeshDescription& mesh = source->description();
  const auto stream = source->stream();
  BitSet points, cells;  // that count
  if (stream != nullptr && !mesh.point_data.arrays.empty()) {
    points = find_rows_in_use(*stream, Association::kPoint, context);
  }
  if (stream != nullptr && !mesh.cell_data.arrays.empty()) {
    cells = find_rows_of_cells(*stream, context);
  }
  const std::array<std::pair<Association, const AttributeSet*>, 3> sets{
      {{Association::kPoint, &mesh.point_data},
       {Association::kCell, &mesh.cell_data},
       {Association::kField, &mesh.field_data}}};
  constexpr std::array<std::string_view, 3> kNames{"point", "cell", "field"};
  std::vector<ArrayLine> lines;
  for (std::size_t s = 0; s < sets.size(); ++s) {
    const auto& [association, set] = sets[s];
    for (std::size_t i = 0; i < set->arrays.size(); ++i) {
      context.check();
      ArrayLine line{kNames[s], set->arrays[i], {}, {}};
      for (const auto& [attribute, name] : set->active) {
        if (name == line.info.name) line.active.push_back(attribute);
      }
      if (stream != nullptr && association != Association::kField) {
        line.statistics =
            measure_rows(*stream, association, i, line.info,
                         association == Association::kPoint ? points : cells, context);
      } else {
        const DataArray array = source->read_array(association, i);
        line.statistics = measure_array(array);
        line.texts = texts_of(array);
        if (association == Association::kField) line.groups = gmsh_groups(array);
      }
      lines.push_back(std::move(line));
    }
  }
  return lines;
}

// What simplify takes where nobody says anything else.
struct Defaults {
  std::vector<std::string> steering, regions;
};

Defaults find_defaults(MeshSource* source, const RunContext& context) {
  const MeshDescription& mesh = source->description();
  Defaults defaults;
  defaults.regions = names_of_cell_arrays(mesh, choose_regions(mesh, std::nullopt));
  const auto stream = source->stream();
  const auto steers = steering_by_default(source, stream.get(), context);
  if (steers) defaults.steering.push_back(steers->name);
  return defaults;
}

void add_defaults(const Defaults& defaults, std::string* text) {
  const auto list = [](const std::vector<std::string>& names) {
    return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
  };
  *text += fmt::format("steering      {}\nregions       {}\n", list(defaults.steering),
                       list(defaults.regions));
}

std::string describe_groups(const ArrayLine& line) {
  std::string text;
  for (const auto& [tag, dimension] : line.groups) {
    text += fmt::format("{}group {} of dimension {}", text.empty() ? "" : ", ", tag, dimension);
  }
  return text;
}

// As much as goes into a line.
std::string describe_texts(const std::vector<std::string>& texts) {
  constexpr std::size_t kMost = 60;
  std::string all = fmt::format("{}", fmt::join(texts, ", "));
  for (char& c : all) {
    if (std::iscntrl(static_cast<unsigned char>(c)) != 0) c = ' ';
  }
  if (all.size() <= kMost) return all;
  std::size_t end = kMost;
  const auto is_within_character = [&] {
    return (static_cast<unsigned char>(all[end]) & 0xC0u) == 0x80u;  // of UTF-8
  };
  while (end > 0 && is_within_character()) --end;
  return all.substr(0, end) + " ...";
}

// Integers as they are; else six digits, or as many as tell the ends apart.
std::pair<std::string, std::string> describe_ends(const Range& range, ValueType type) {
  constexpr int kFewDigits = 6, kAllDigits = 17;
  constexpr double kExact = 0x1p53;  // statistics are doubles
  const bool is_exact = std::max(std::abs(range.min), std::abs(range.max)) <= kExact;
  if (!is_float(type) && is_exact) {
    return {fmt::format("{:.0f}", range.min), fmt::format("{:.0f}", range.max)};
  }
  std::pair<std::string, std::string> ends;
  for (int digits = kFewDigits; digits <= kAllDigits; ++digits) {
    ends = {fmt::format("{:.{}g}", range.min, digits), fmt::format("{:.{}g}", range.max, digits)};
    if (ends.first != ends.second || range.min == range.max) break;
  }
  return ends;
}

// Statistics are doubles, and different integers may be one of them.
bool is_rounded(const ArrayLine& line) {
  const auto is_far = [](const Range& r) {
    return std::max(std::abs(r.min), std::abs(r.max)) >= 0x1p53;
  };
  return !is_float(line.info.type) && std::ranges::any_of(line.statistics.components, is_far);
}

std::string describe_range(const ArrayLine& line) {
  if (!line.texts.empty()) return describe_texts(line.texts);
  if (!line.groups.empty()) return describe_groups(line);
  const ArrayStatistics& s = line.statistics;
  if (s.components.empty()) return "";
  if (line.info.tuples == 0) return "empty";
  const bool scalar = s.components.size() == 1;
  const Range& range = scalar ? s.components[0] : s.magnitude;
  std::string text;
  if (range.empty()) {
    text = "no finite values";
  } else if (s.constant() && scalar) {
    text = fmt::format("{}{}", describe_ends({range.min, range.min}, line.info.type).first,
                       is_rounded(line) ? ", rounded" : " everywhere");
  } else {
    // Lengths are no integers.
    const auto [least, most] = describe_ends(range, scalar ? line.info.type : ValueType::kFloat64);
    text = fmt::format("{}{} .. {}", scalar ? "" : "length ", least, most);
    if (!scalar && !s.constant()) text += fmt::format(", range {:.6g}", s.diagonal());
    if (s.constant()) text += ", constant";
  }
  if (s.non_finite > 0) text += fmt::format(", {} not finite", format_count(s.non_finite, "value"));
  return text;
}

// "velocity (m/s)"
std::string name_of(const ArrayInfo& info) {
  return for_message(info.units.empty() ? info.name
                                        : fmt::format("{} ({})", info.name, info.units));
}

void add_arrays(const std::vector<ArrayLine>& lines, std::string* text) {
  if (lines.empty()) {
    *text += "arrays        none\n";
    return;
  }
  *text += "arrays\n";
  std::size_t width = 0;
  for (const ArrayLine& line : lines) width = std::max(width, name_of(line.info).size());
  for (const ArrayLine& line : lines) {
    const std::string components =
        line.info.components == 1 ? "" : fmt::format(" x {}", line.info.components);
    fmt::format_to(std::back_inserter(*text), "  {:<6}{:<{}}  {:<11} {}", line.association,
                   name_of(line.info), width, std::string(vtk_name(line.info.type)) + components,
                   describe_range(line));
    if (!line.active.empty()) {
      fmt::format_to(std::back_inserter(*text), "  [active {}]", fmt::join(line.active, ", "));
    }
    *text += '\n';
  }
}

void add_oddities(const InspectionSummary& mesh, const std::vector<Finding>& findings,
                  std::string* text) {
  std::string odd;
  for (const Finding& f : findings) {
    if (f.count == 0) continue;
    const std::string samples = describe_samples(f);
    fmt::format_to(std::back_inserter(odd), "  {}: {}{}{}\n", f.label, format_count(f.count),
                   samples.empty() ? "" : ": ", samples);
  }
  const std::string winding = describe_winding(mesh);
  if (!winding.empty()) odd += "  " + winding + "\n";
  *text += odd.empty() ? "odd           nothing\n" : "odd\n" + odd;
}

std::string describe_lower(const InspectionSummary& mesh) {
  std::string text;
  const auto add = [&](std::uint64_t count, std::string_view one, std::string_view many) {
    if (count > 0) text += ", " + format_count(count, one, many);
  };
  add(mesh.lower_vertices, "vertex", "vertices");
  add(mesh.lower_lines, "line", "lines");
  add(mesh.lower_triangles, "triangle", "triangles");
  return text;
}

std::string describe_steps(const MeshDescription& mesh) {
  const std::vector<double>& times = mesh.time_steps;
  if (times.size() == 1) return fmt::format("1, at {:.6g}", times[0]);
  return fmt::format("{}, from {:.6g} to {:.6g}; number {}, at {:.6g}, is read (--time-step)",
                     format_count(times.size()), times.front(), times.back(), mesh.time_step,
                     times[mesh.time_step]);
}

std::string table(const MeshDescription& mesh, const std::vector<std::string>& needs,
                  const InspectionSummary& i, const std::vector<ArrayLine>& arrays,
                  const Defaults& defaults, const std::vector<Finding>& findings) {
  std::string text;
  const auto out = std::back_inserter(text);
  const auto points = static_cast<double>(std::max<std::uint64_t>(1, i.points));
  fmt::format_to(out, "file          {} ({})\n", mesh.path, format_bytes(mesh.file_bytes));
  fmt::format_to(out, "format        {}{}{}\n", mesh.format,
                 mesh.left_out.empty() ? "" : "; left out: ", fmt::join(mesh.left_out, ", "));
  if (!needs.empty()) {
    fmt::format_to(out, "read with     {}, without which no other command takes it\n",
                   fmt::join(needs, " "));
  }
  if (!mesh.time_steps.empty()) fmt::format_to(out, "time steps    {}\n", describe_steps(mesh));
  if (mesh.pieces != 1) fmt::format_to(out, "pieces        {}\n", format_count(mesh.pieces));
  fmt::format_to(out, "points        {} ({})\n", format_count(i.points), vtk_name(mesh.point_type));
  fmt::format_to(out, "cells         {}{}\n", format_count(i.tets, "tetrahedron", "tetrahedra"),
                 describe_lower(i));
  fmt::format_to(out, "parts         {}, connected by faces{}\n", format_count(i.components),
                 i.tets > 1 && i.boundary_faces == 4 * i.tets
                     ? ": each tetrahedron has points of its own (--merge-points)"
                     : "");
  fmt::format_to(out, "bounding box  x {:.6g} .. {:.6g}, y {:.6g} .. {:.6g}, z {:.6g} .. {:.6g}\n",
                 i.lower[0], i.upper[0], i.lower[1], i.upper[1], i.lower[2], i.upper[2]);
  fmt::format_to(out, "volume        {:.9g}\n", i.volume);
  fmt::format_to(out, "boundary      {}, {} ({:.1f} % of all), {}, Euler number {}\n",
                 format_count(i.boundary_faces, "triangle"),
                 format_count(i.boundary_vertices, "point"),
                 100 * static_cast<double>(i.boundary_vertices) / points,
                 format_count(i.surface_components, "surface"), i.surface_euler());
  add_arrays(arrays, &text);
  add_defaults(defaults, &text);
  if (!mesh.unread.empty()) {
    fmt::format_to(out, "not read      {} (strings or bits)\n", fmt::join(mesh.unread, ", "));
  }
  add_oddities(i, findings, &text);
  return text;
}

Json range_json(const Range& range) { return range.empty() ? Json() : Json{range.min, range.max}; }

Json constant_json(const ArrayLine& line) {
  const bool is_constant = line.statistics.constant();
  return is_constant && is_rounded(line) ? Json() : Json(is_constant);
}

Json arrays_json(const std::vector<ArrayLine>& lines) {
  Json arrays = Json::array();
  for (const ArrayLine& line : lines) {
    Json components = Json::array();
    for (const Range& range : line.statistics.components) components.push_back(range_json(range));
    arrays.push_back({{"association", line.association},
                      {"name", line.info.name},
                      {"type", vtk_name(line.info.type)},
                      {"components", line.info.components},
                      {"component_names", line.info.component_names},
                      {"units", line.info.units.empty() ? Json() : Json(line.info.units)},
                      {"tuples", line.info.tuples},
                      {"active", line.active},
                      {"ranges", components},
                      {"magnitude", range_json(line.statistics.magnitude)},
                      {"range", line.statistics.diagonal()},
                      {"non_finite", line.statistics.non_finite},
                      {"constant", constant_json(line)}});
    if (line.info.type == ValueType::kString) arrays.back()["texts"] = line.texts;
    for (const auto& [tag, dimension] : line.groups) {
      arrays.back()["groups"].push_back({{"tag", tag}, {"dimension", dimension}});
    }
  }
  return arrays;
}

struct InfoAnswer {
  Json json;
  std::string text;
};

// `needs`: options that make the file readable, and were not given.
InfoAnswer look_at(const InfoArguments& a, const OpenOptions& open,
                   const std::vector<std::string>& needs, const RunContext& context) {
  context.report("reading", 0);
  const auto source = open_mesh(a.input, open);
  const MeshDescription& mesh = source->description();
  refuse_piece(a.report, mesh);
  const std::vector<ArrayLine> arrays = measure_arrays(source.get(), context);
  const Defaults defaults = find_defaults(source.get(), context);
  const InspectionSummary summary = examine(source.get(), a.examine, context).mesh;
  const std::vector<Finding> findings = list_findings(summary, mesh.point_data);
  context.report("done", 1);

  Json json{{"version", version()},  {"path", mesh.path},
            {"format", mesh.format}, {"file_bytes", mesh.file_bytes},
            {"pieces", mesh.pieces}, {"point_type", vtk_name(mesh.point_type)}};
  json.update(counts_json(summary));
  json["arrays"] = arrays_json(arrays);
  json["steering"] = defaults.steering;
  json["regions"] = defaults.regions;
  json["unread_arrays"] = mesh.unread;
  json["left_out"] = mesh.left_out;
  json["time_steps"] = mesh.time_steps;
  json["time_step"] = mesh.time_steps.empty() ? Json() : Json(mesh.time_step);
  json["needs"] = needs;
  json.update(findings_json(findings));
  json["largest_difference"] = difference_json(summary.largest_difference, mesh.point_data);
  return {json, table(mesh, needs, summary, arrays, defaults, findings)};
}

// A file that simplify takes with other options only is told of as it is with these.
InfoAnswer answer_of(const InfoArguments& a) {
  Console console(a.console);
  const RunContext context = console.context();
  OpenOptions open = a.open;
  open.time_step = open.time_step.value_or(0);  // the others have a line of their own
  open.memory = a.examine.memory;
  open.cancelled = context.cancelled;
  const auto look_with = [&](bool split, bool straighten) {
    OpenOptions more = open;
    more.tetrahedralize |= split;
    more.linearize |= straighten;
    std::vector<std::string> needs;
    if (more.tetrahedralize && !open.tetrahedralize) needs.emplace_back("--tetrahedralize");
    if (more.linearize && !open.linearize) needs.emplace_back("--linearize");
    return look_at(a, more, needs, context);
  };
  const auto answer = [&] {
    try {
      return look_with(false, false);
    } catch (const InvalidMesh&) {
      throw;
    } catch (const Error& error) {
      // Any other fault than cells that are to be split or linearized is there again.
      if (error.code() != ErrorCode::kBadInput || a.input == "-") throw;
      for (const auto& [split, straighten] :
           {std::pair(true, false), {false, true}, {true, true}}) {
        try {
          return look_with(split, straighten);
        } catch (const Error& other) {
          if (other.code() != ErrorCode::kBadInput) throw;
        }
      }
      throw;
    }
  }();
  console.detail_resources();
  return answer;
}

// Of a list of steps the first one, or the one that was chosen, and which there are.
InfoAnswer answer_of_list(const InfoArguments& a) {
  constexpr std::size_t kMostFiles = 5;
  OpenOptions all = a.open;
  all.time_step.reset();
  const std::vector<StepToRead> steps = steps_to_read(a.input, all);
  const std::size_t chosen = choose_time_step(a.input, steps.size(), a.open.time_step);
  std::vector<std::string> files;
  Json list{{"path", a.input}, {"step", chosen}, {"steps", Json::array()}};
  for (const StepToRead& step : steps) {
    refuse_same_file("--report", a.report, {step.path});
    files.push_back(step.path);
    list["steps"].push_back(step_json(step));
  }
  InfoArguments one = a;
  one.input = steps[chosen].path;
  one.open = steps[chosen].options(a.open);
  InfoAnswer answer = answer_of(one);
  answer.json["list"] = list;
  const auto at = [](const StepToRead& step, std::string_view before, std::string_view behind) {
    return step.time ? fmt::format("{}{:.6g}{}", before, *step.time, behind) : "";
  };
  const std::string times =
      steps.size() > 1 ? at(steps.front(), ", from ", "") + at(steps.back(), " to ", "") : "";
  answer.text = fmt::format(
      "list          {}\nsteps         {}{}; number {}{} is read (--time-step)\n"
      "files         {}\n{}",
      a.input, format_count(steps.size()), times, chosen, at(steps[chosen], ", at ", ","),
      list_names(files, kMostFiles), answer.text);
  return answer;
}

void run_info(const InfoArguments& a) {
  const double start = wall_seconds();
  check_report(a.report, {a.input});
  set_thread_count(a.threads);
  InfoAnswer answer = is_list_name(a.input) ? answer_of_list(a) : answer_of(a);
  if (!a.report.empty()) {
    add_resources(start, &answer.json);
    write_text(a.report, dump(answer.json));
  }
  if (a.report != "-" && !a.console.quiet) write_text("-", answer.text);
}

}  // namespace

void add_info_command(CLI::App& app) {
  auto a = std::make_shared<InfoArguments>();
  CLI::App* command = app.add_subcommand(
      "info", "Say what is in a mesh: counts, arrays, boundary, what is odd about it");
  command->footer(
      "Of a list of steps (.pvd, .series) the first one is told of, or the one that --time-step "
      "says.");
  add_input_options(*command, &a->input, &a->open, "the first");
  add_report_option(*command, &a->report);
  add_thread_option(*command, &a->threads);
  add_memory_options(*command, &a->examine.memory, &a->examine.scratch);
  add_console_options(*command, &a->console);
  command->callback([a] { run_info(*a); });
}

}  // namespace tetfusion
