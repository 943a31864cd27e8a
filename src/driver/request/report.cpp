#include "driver/request/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "base/numbers.h"
#include "base/version.h"
#include "driver/request/report_json.h"

namespace tetfusion {

namespace {

using Json = nlohmann::ordered_json;

Json to_json_object(const MeshSummary& m) {
  return {{"path", m.path},
          {"points", m.points},
          {"tets", m.tets},
          {"boundary_triangles", m.boundary_triangles},
          {"volume", m.volume}};
}

// As it was asked for: "exact", "planar", or a share.
std::string boundary_name(const SimplifyReport& r) {
  if (r.boundary == Boundary::kWithin) return fmt::format("{}", r.boundary_distance);
  return r.boundary == Boundary::kPlanar ? "planar" : "exact";
}

Json to_json_object(const Verification& v) {
  Json checks = Json::array();
  for (const VerifiedCheck& check : v.checks) {
    checks.push_back({{"name", check.name}, {"found", check.found}, {"allowed", check.allowed}});
  }
  return {{"path", v.path}, {"checks", checks}, {"not_verified", v.not_verified}};
}

Json to_json_object(const RoundSummary& round) {
  Json rejected;
  for (std::size_t r = 0; r < kRejectReasons; ++r)
    rejected[kRejectNames[r]] = round.pass.rejected[r];
  return {{"tets", round.pass.tets_after},
          {"fused", round.pass.fused},
          {"labelled", round.pass.labelled},
          {"rejected", rejected},
          {"scalar_tolerance", round.scalar_tolerance},
          {"stretch_factor", round.stretch_factor},
          {"chunks", round.chunks},
          {"seconds", round.seconds}};
}

std::string_view reason_in_words(Reject reason) {
  switch (reason) {
    case Reject::kBoundary:
      return "a vertex of theirs lies on the boundary, which stays";
    case Reject::kLocked:
      return "a vertex of theirs stays";
    case Reject::kScalar:
      return "the field would change by more than the scalar tolerance";
    case Reject::kFlip:
      return "a tetrahedron round them would turn over";
    case Reject::kStretch:
      return "a tetrahedron would stretch by more than the stretch factor";
    case Reject::kAspect:
      return "a tetrahedron would exceed the aspect ratio";
    case Reject::kVolume:
      return "a tetrahedron would exceed the volume";
    case Reject::kInterface:
      return "a vertex of theirs lies between two chunks";
    case Reject::kQuota:
      return "the goal leaves no room";
    case Reject::kError:
      return "the fields would change by more than they may";
    case Reject::kQuality:
      return "a tetrahedron would fall below the quality floor";
    case Reject::kSurface:
      return "the surface would move further than it may, or be torn";
    case Reject::kDeviation:
      return "a field would deviate by more than it may at a point of the original";
    case Reject::kIntegral:
      return "the integral of a field would change";
  }
  return "";
}

}  // namespace

double SimplifyReport::reduction() const {
  if (input.tets == 0) return 0;
  return 1 - static_cast<double>(output.tets) / static_cast<double>(input.tets);
}

std::string SimplifyReport::reason_of_locks() const {
  std::vector<std::string> places;
  if (facts.between_regions > 0) {
    // Where they may move edges and corners stay, and a mesh of voxels has nothing else.
    places.push_back(
        fmt::format("{}between regions of {}",
                    boundary == Boundary::kExact ? "" : "at an edge, a corner, a rim or a step ",
                    fmt::join(regions, ", ")));
  }
  if (has_interest) places.emplace_back("in the region of interest");
  const InputFacts& f = facts;
  if (f.degenerate + f.inverted + f.duplicate_tets + f.nonconforming_faces > 0) {
    places.emplace_back("at a cell that is odd");
  }
  if (facts.coincident_points > 0) places.emplace_back("where another point does");
  std::vector<std::string> reasons;
  if (!places.empty()) reasons.push_back(fmt::format("lies {}", fmt::join(places, " or ")));
  if (facts.carried_vertices > 0) reasons.emplace_back("is held by a cell of lower dimension");
  if (facts.valueless_points > 0 || reasons.empty())
    reasons.emplace_back("has a value that is no number");
  return fmt::format("{}, and stays", fmt::join(reasons, " or "));
}

std::string SimplifyReport::in_words(Reject reason) const {
  if (reason == Reject::kLocked) return "a vertex of theirs " + reason_of_locks();
  if (reason == Reject::kBoundary && boundary != Boundary::kExact) {
    return "a vertex of theirs lies at a corner of the surface, or where it is odd, and stays";
  }
  return std::string(reason_in_words(reason));
}

bool SimplifyReport::is_for_sharp_edges(Reject reason) const {
  constexpr double kHardlyAny = 120;  // edges are sharper
  if (boundary != Boundary::kWithin || feature_angle >= kHardlyAny) return false;
  const bool are_between_regions =
      facts.between_regions > 0 && facts.carried_vertices == 0 && !has_interest;
  return reason == Reject::kBoundary || (reason == Reject::kLocked && are_between_regions);
}

// A boundary that is exact stays anyway; the question is what holds the others back.
std::string SimplifyReport::reasons_of_vertices(const PassStatistics& last) const {
  std::vector<std::pair<std::uint64_t, Reject>> reasons;
  std::uint64_t all = 0;
  for (std::size_t i = 0; i < last.rejected.size(); ++i) {
    const auto reason = static_cast<Reject>(i);
    const bool stays_anyway = reason == Reject::kBoundary && boundary == Boundary::kExact;
    if (stays_anyway || last.rejected[i] == 0) continue;
    reasons.emplace_back(last.rejected[i], reason);
    all += last.rejected[i];
  }
  if (all == 0) return "every vertex that is left lies on the boundary, which stays.";
  const auto more = [](const auto& a, const auto& b) { return a.first > b.first; };
  std::stable_sort(reasons.begin(), reasons.end(), more);
  std::string because;
  bool has_sharp_edges = false;
  for (std::size_t i = 0; i < std::min<std::size_t>(reasons.size(), 3); ++i) {
    const auto& [count, reason] = reasons[i];
    if (2 * count < reasons[0].first) break;
    because += fmt::format("{}{} {}because {}", i == 0 ? "" : "; ", format_count(count),
                           i == 0 ? "may not be fused " : "", in_words(reason));
    has_sharp_edges |= is_for_sharp_edges(reason);
  }
  return fmt::format(
      "of {} left{}, {}.{}", format_count(all, "vertex", "vertices"),
      boundary == Boundary::kExact ? " inside" : "", because,
      has_sharp_edges ? " More may go with a larger feature angle and a larger distance." : "");
}

std::string SimplifyReport::reasons_of_tets(const PassStatistics& last) const {
  const auto most = std::max_element(last.rejected.begin(), last.rejected.end());
  const auto reason = static_cast<Reject>(most - last.rejected.begin());
  const std::string because = fmt::format("for {} of {} this is because {}.", format_count(*most),
                                          format_count(last.tets_after), in_words(reason));
  if (last.fused == 0) return "no tetrahedron may be fused any more; " + because;
  return fmt::format(
      "next to none may be fused any more (the last round has {} fewer than the one "
      "before); {}",
      format_count(last.tets_before - last.tets_after, "tetrahedron", "tetrahedra"), because);
}

std::string SimplifyReport::stop_sentence() const {
  if (stop_reason == StopReason::kGoal) return "The goal was reached.";
  std::string text = rounds.empty()            ? "no tetrahedron may be fused."
                     : method == Method::kFuse ? reasons_of_vertices(rounds.back().pass)
                                               : reasons_of_tets(rounds.back().pass);
  if (has_goal) return "The goal was not reached: " + text;
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

Json to_json_value(const SimplifyReport& r) {
  Json rounds = Json::array();
  for (const RoundSummary& round : r.rounds) rounds.push_back(to_json_object(round));
  Json verified = Json::array();
  for (const Verification& verification : r.verified) {
    verified.push_back(to_json_object(verification));
  }
  Json outputs = Json::array(), levels = Json::array();
  for (const MeshSummary& output : r.outputs) {
    outputs.push_back(output.path);
    levels.push_back(to_json_object(output));
  }
  Json difference;
  if (!r.differing_array.empty()) {
    difference = {{"array", r.differing_array}, {"share", r.facts.largest_difference.share}};
  }
  Json seconds(r.seconds);
  seconds["total"] = r.total_seconds;
  return {{"version", version()},
          {"method", r.method == Method::kFuse ? "fuse" : "tetfuse"},
          {"input", to_json_object(r.input)},
          {"output", to_json_object(r.output)},
          {"outputs", outputs},
          {"levels", levels},
          {"reduction", r.reduction()},
          {"stop_reason", r.stop_reason == StopReason::kGoal ? "goal" : "saturated"},
          {"stop_sentence", r.stop_sentence()},
          {"steering", r.steering},
          {"regions", r.regions},
          {"boundary",
           {{"mode", boundary_name(r)},
            {"deviation", r.rounds.empty() ? 0.0 : r.rounds.back().deviation}}},
          {"odd",
           {{"rewound", r.facts.rewound},
            {"degenerate", r.facts.degenerate},
            {"inverted", r.facts.inverted},
            {"duplicate_tets", r.facts.duplicate_tets},
            {"nonconforming_faces", r.facts.nonconforming_faces},
            {"unused_points", r.facts.unused_points},
            {"merged_points", r.facts.merged_points},
            {"differing_points", r.facts.differing_points},
            {"largest_difference", difference},
            {"ghost_cells", r.facts.ghost_cells},
            {"locked_vertices", r.facts.locked_vertices}}},
          {"lods", rounds},
          {"verified", verified},
          {"seconds", seconds},
          {"cpu_seconds", r.cpu_seconds},
          {"peak_rss_bytes", r.peak_rss_bytes},
          {"scratch_bytes", r.scratch_bytes},
          {"threads", r.threads},
          {"chunks", r.rounds.empty() ? 1 : r.rounds.front().chunks}};
}

std::string dump(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string to_json(const SimplifyReport& report) { return dump(to_json_value(report)); }

}  // namespace tetfusion
