#include "cli/summaries.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "base/numbers.h"

namespace tetfusion {

namespace {

// What coordinates are rounded by at most, as a share of the diagonal: less is no movement.
constexpr double kRounding = 0x1p-53;

std::string describe_reach(const RunEstimate& e) {
  const std::optional<bool> reaches = e.reaches_goal();
  std::string text = fmt::format("about {:.3g} % fewer tetrahedra", 100 * e.reduction);
  if (e.is_rough) {
    text += fmt::format(" or more ({:.3g} % with four times as many left), as the boundary moves",
                        100 * e.low_reduction());
  }
  if (reaches == false) return text + "; the goal is out of reach";
  return e.goal && !reaches ? text + "; whether the goal is in reach is open" : text;
}

void add_estimate(const RunPlan& plan, std::string* text) {
  const auto to = std::back_inserter(*text);
  const RunEstimate& e = plan.estimate;
  fmt::format_to(to, "boundary   about {:.3g} % of the points\n", 100 * e.boundary_share);
  fmt::format_to(to, "reachable  {}\n", describe_reach(e));
  fmt::format_to(to, "time       about {:.2g} s with {}, without waiting for disks{}\n", e.seconds,
                 format_count(static_cast<std::uint64_t>(plan.threads), "thread"),
                 plan.verifies ? " and without --verify" : "");
  fmt::format_to(
      to, "basis      {}, simplified on one thread in {:.2g} s; the input was read once\n",
      e.is_whole() ? "the whole mesh" : format_count(e.sample_tets) + " tetrahedra from its middle",
      e.sample_seconds);
}

}  // namespace

std::string describe(const RunPlan& plan) {
  std::string text;
  const auto to = std::back_inserter(text);
  const auto names = [](const std::vector<std::string>& all) {
    return all.empty() ? "none" : fmt::format("{}", fmt::join(all, ", "));
  };
  fmt::format_to(to, "input      {}: {}, {}\n", plan.input.path,
                 format_count(plan.input.tets, "cell"), format_count(plan.input.points, "point"));
  fmt::format_to(to, "steering   {}\nregions    {}\nchunks     {}\n", names(plan.steering),
                 names(plan.regions), plan.chunks);
  fmt::format_to(to,
                 "memory     about {}, of {} that it may use; {} would keep the mesh in memory\n",
                 format_bytes(plan.memory_needed()), format_bytes(plan.memory),
                 format_bytes(plan.needs.in_core));
  const std::string scratch = format_bytes(plan.scratch_needed());
  if (plan.on_disk) {
    fmt::format_to(to, "scratch    about {} in {}\n", scratch, plan.scratch);
  } else {
    fmt::format_to(to, "scratch    {}\n",
                   plan.spooled == 0
                       ? "none"
                       : fmt::format("{} for a copy of the input, which is read twice", scratch));
  }
  add_estimate(plan, &text);
  return text;
}

void summarize(const SimplifyReport& r, Console* console) {
  for (std::size_t i = 0; i < r.rounds.size(); ++i) {
    const PassStatistics& p = r.rounds[i].pass;
    std::string rejected;
    for (std::size_t k = 0; k < kRejectReasons; ++k) {
      if (p.rejected[k] > 0) rejected += fmt::format(", {} {}", kRejectNames[k], p.rejected[k]);
    }
    console->detail(fmt::format("round {}: {}, {} fused; rejected{}", i + 1,
                                format_count(p.tets_after, "tetrahedron", "tetrahedra"), p.fused,
                                rejected.empty() ? " none" : rejected.substr(1)));
  }
  const double change = r.input.volume != 0 ? r.output.volume / r.input.volume - 1 : 0;
  console->say(fmt::format("{}: {} -> {}: {} ({:.2f} % less) in {:.2f} s", r.input.path,
                           format_count(r.input.tets, "tetrahedron", "tetrahedra"), r.output.path,
                           format_count(r.output.tets), 100 * r.reduction(), r.total_seconds));
  console->say(fmt::format("boundary triangles {} -> {}; volume {:.6g}, changed by {:.1e}",
                           format_count(r.input.boundary_triangles),
                           format_count(r.output.boundary_triangles), r.input.volume, change));
  if (r.boundary != Boundary::kExact && !r.rounds.empty()) {
    const double moved = r.rounds.back().deviation;
    const std::string surface =
        r.regions.empty() ? "the surface has"
                          : fmt::format("the surface and what lies between regions of {} have",
                                        fmt::join(r.regions, ", "));
    console->say(moved < kRounding ? surface + " stayed in place"
                                   : fmt::format("{} moved by at most {:.2g} % of the diagonal",
                                                 surface, 100 * moved));
  }
  for (const Verification& v : r.verified) {
    console->say(
        fmt::format("{}: verified, {} hold", v.path, format_count(v.checks.size(), "check")));
    for (const std::string& what : v.not_verified) {
      console->say(fmt::format("{}: not verified: {}", v.path, what));
    }
  }
  console->say(r.stop_sentence());
  console->detail_resources();
}

void WorstErrors::add(const std::string& array, const std::string& step, double rms, double max) {
  Worst& worst = arrays_[array];
  worst.rms = std::max(worst.rms, {rms, step});
  worst.max = std::max(worst.max, {max, step});
}

void WorstErrors::say(Console* console) const {
  for (const auto& [name, worst] : arrays_) {
    console->say(fmt::format(
        "{}: off by {:.3g} % of its range in a step at most (step {}), by up "
        "to {:.3g} % in the mean of squares (step {})",
        name, 100 * worst.max.first, worst.max.second, 100 * worst.rms.first, worst.rms.second));
  }
}

void summarize(const SeriesReport& r, const std::string& output, Console* console) {
  WorstErrors worst;
  for (const StepReport& step : r.steps) {
    for (const StepArray& a : step.arrays) {
      console->detail(
          fmt::format("step {}: {} off by {:.3g} % in the mean of squares, {:.3g} % at "
                      "most (point {})",
                      step.label, a.name, 100 * a.rms, 100 * a.max, a.max_at));
      worst.add(a.name, step.label, a.rms, a.max);
    }
  }
  if (!r.shared) {
    for (const SimplifyReport& run : r.runs) summarize(run, console);
    return;
  }
  summarize(r.runs[0], console);
  worst.say(console);
  console->say(fmt::format("{} -> {}, on one mesh; in {:.2f} s",
                           format_count(r.steps.size(), "step"), output, r.total_seconds));
}

}  // namespace tetfusion
