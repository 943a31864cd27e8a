#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "base/error.h"
#include "base/numbers.h"
#include "compare/compare.h"

namespace tetfusion {

namespace {

std::string percent(double share) { return fmt::format("{:.4g} %", 100 * share); }

// The point arrays that bounds are for.
std::vector<const ArrayComparison*> bounded_arrays(const Comparison& comparison,
                                                   const Bounds& bounds) {
  std::vector<const ArrayComparison*> arrays;
  for (const ArrayComparison& a : comparison.arrays) {
    if (a.association != Association::kPoint) continue;
    const auto& names = bounds.arrays;
    const bool named = std::find(names.begin(), names.end(), a.info.name) != names.end();
    if (named || (names.empty() && !a.integer)) arrays.push_back(&a);
  }
  return arrays;
}

// Nothing could be compared, but there is something now.
bool is_made_up(const ArrayComparison& a, const Comparison& comparison) {
  return a.non_finite > 0 && a.non_finite == comparison.original.points &&
         a.simplified_non_finite < comparison.simplified.points;
}

BoundResult judge(const ArrayComparison& a, const Comparison& comparison, bool rms, double limit) {
  BoundResult r{rms ? "max_rms" : "max_error", a.info.name, limit, rms ? a.rms : a.max, false, {}};
  const char* option = rms ? "--max-rms" : "--max-error";
  if (a.undefined > 0) {
    r.broken = true;
    r.sentence = fmt::format(
        "{} is broken: {} has values that are not finite where the original's are, at {}", option,
        a.info.name, format_count(a.undefined, "point"));
  } else if (is_made_up(a, comparison)) {
    r.broken = true;
    r.sentence = fmt::format(
        "{} is broken: no value of {} in the original is finite, but the simplified mesh has such",
        option, a.info.name);
  } else if (!(r.value <= limit + a.rounding)) {
    r.broken = true;
    r.sentence =
        fmt::format("{} is broken: the {} error of {} is {}, above {}", option,
                    rms ? "rms" : "largest", a.info.name, percent(r.value), percent(limit));
  }
  return r;
}

BoundResult lost(const std::string& array, bool rms, double limit) {
  return {
      rms ? "max_rms" : "max_error",
      array,
      limit,
      std::numeric_limits<double>::infinity(),
      true,
      fmt::format("{} is broken: the simplified mesh has no point array {}, or one with another "
                  "number of components",
                  rms ? "--max-rms" : "--max-error", array)};
}

// Of those that bounds are for.
std::vector<std::string> lost_arrays(const Comparison& comparison, const Bounds& bounds) {
  if (bounds.arrays.empty()) return comparison.lost_fields;
  std::vector<std::string> names = bounds.arrays;
  for (const ArrayComparison* a : bounded_arrays(comparison, bounds)) {
    std::erase(names, a->info.name);
  }
  return names;
}

}  // namespace

void require_arrays(const Bounds& bounds, const MeshDescription& original) {
  for (const std::string& name : bounds.arrays) {
    const std::size_t i = original.point_data.find(name);
    if (i != AttributeSet::npos && original.point_data.arrays[i].type != ValueType::kString) {
      continue;
    }
    if (name.starts_with("cell:")) {
      throw Error(ErrorCode::kUsage,
                  fmt::format("--array {}: bounds are for point arrays; the errors of cell arrays "
                              "stand in the table and the report",
                              name));
    }
    throw Error(ErrorCode::kUsage, fmt::format("--array {}: {} has no numeric point array of that "
                                               "name; see 'tetfusion info'",
                                               name, original.path));
  }
}

std::vector<BoundResult> judge_bounds(const Comparison& comparison, const Bounds& bounds) {
  std::vector<BoundResult> results;
  for (const ArrayComparison* a : bounded_arrays(comparison, bounds)) {
    if (bounds.max_rms) results.push_back(judge(*a, comparison, true, *bounds.max_rms));
    if (bounds.max_error) results.push_back(judge(*a, comparison, false, *bounds.max_error));
  }
  for (const std::string& name : lost_arrays(comparison, bounds)) {
    if (bounds.max_rms) results.push_back(lost(name, true, *bounds.max_rms));
    if (bounds.max_error) results.push_back(lost(name, false, *bounds.max_error));
  }
  if (bounds.surface) {
    const double value = std::max(comparison.to_simplified.max, comparison.to_original.max);
    BoundResult r{"surface", "", *bounds.surface, value, false, {}};
    r.broken = !(value <= *bounds.surface + comparison.rounding);
    if (r.broken) {
      r.sentence = fmt::format(
          "--surface is broken: the surfaces are up to {} of the diagonal apart, above {}",
          percent(value), percent(*bounds.surface));
    }
    results.push_back(std::move(r));
  }
  return results;
}

}  // namespace tetfusion
