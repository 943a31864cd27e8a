#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "base/error.h"
#include "base/numbers.h"
#include "compare/compare.h"

namespace tetfusion {

namespace {

std::string percent(double share) { return fmt::format("{:.4g} %", 100 * share); }

constexpr std::string_view kOfCells = "cell:";
constexpr const char* kInterfaces = "interfaces";

// As bounds and messages call it.
std::string name_of(const ArrayComparison& a) {
  return (a.association == Association::kCell ? std::string(kOfCells) : "") + a.info.name;
}

// The arrays that bounds are for.
std::vector<const ArrayComparison*> bounded_arrays(const Comparison& comparison,
                                                   const Bounds& bounds) {
  std::vector<const ArrayComparison*> arrays;
  for (const ArrayComparison& a : comparison.arrays) {
    const auto& names = bounds.arrays;
    const bool named = std::find(names.begin(), names.end(), name_of(a)) != names.end();
    const bool by_default = names.empty() && !a.integer && a.association == Association::kPoint;
    if (named || by_default) arrays.push_back(&a);
  }
  return arrays;
}

// Nothing could be compared, but there is something now.
bool is_made_up(const ArrayComparison& a, const Comparison& comparison) {
  const auto size = [&](const MeshSize& mesh) {
    return a.association == Association::kCell ? mesh.tets : mesh.points;
  };
  return a.non_finite > 0 && a.non_finite == size(comparison.original) &&
         a.simplified_non_finite < size(comparison.simplified);
}

BoundResult judge(const ArrayComparison& a, const Comparison& comparison, bool rms, double limit) {
  const std::string name = name_of(a);
  BoundResult r{rms ? "max_rms" : "max_error", name, limit, rms ? a.rms : a.max, false, {}};
  const char* option = rms ? "--max-rms" : "--max-error";
  if (a.undefined > 0) {
    r.broken = true;
    r.sentence = fmt::format(
        "{} is broken: {} has values that are not finite where the original's are, at {}", option,
        name, format_count(a.undefined, a.association == Association::kCell ? "cell" : "point"));
  } else if (is_made_up(a, comparison)) {
    r.broken = true;
    r.sentence = fmt::format(
        "{} is broken: no value of {} in the original is finite, but the simplified mesh has such",
        option, name);
  } else if (!(r.value <= limit + a.rounding)) {
    r.broken = true;
    r.sentence = fmt::format("{} is broken: the {} error of {} is {}, above {}", option,
                             rms ? "rms" : "largest", name, percent(r.value), percent(limit));
  }
  return r;
}

BoundResult lost(const std::string& array, const std::string& bound, double limit) {
  const bool of_cells = bound == kInterfaces || array.starts_with(kOfCells);
  std::string option = "--" + bound;
  std::ranges::replace(option, '_', '-');
  return {bound,
          array,
          limit,
          std::numeric_limits<double>::infinity(),
          true,
          fmt::format("{} is broken: the simplified mesh has no {} array {}, or one with another "
                      "number of components",
                      option, of_cells ? "cell" : "point",
                      array.starts_with(kOfCells) ? array.substr(kOfCells.size()) : array)};
}

// Of those that bounds are for.
std::vector<std::string> lost_arrays(const Comparison& comparison, const Bounds& bounds) {
  if (bounds.arrays.empty()) return comparison.lost_fields;
  std::vector<std::string> names = bounds.arrays;
  for (const ArrayComparison* a : bounded_arrays(comparison, bounds)) {
    std::erase(names, name_of(*a));
  }
  return names;
}

bool has_numbers(const AttributeSet& set, const std::string& name) {
  const std::size_t i = set.find(name);
  return i != AttributeSet::npos && set.arrays[i].type != ValueType::kString;
}

// Null where there is none.
const ArrayInfo* first_float(const AttributeSet& set) {
  const auto at = std::find_if(set.arrays.begin(), set.arrays.end(),
                               [](const ArrayInfo& array) { return is_float(array.type); });
  return at != set.arrays.end() ? &*at : nullptr;
}

}  // namespace

void require_arrays(const Bounds& bounds, const MeshDescription& original) {
  for (const std::string& name : bounds.arrays) {
    const bool is_of_cells =
        name.starts_with(kOfCells) && has_numbers(original.cell_data, name.substr(kOfCells.size()));
    if (is_of_cells || has_numbers(original.point_data, name)) continue;
    if (has_numbers(original.cell_data, name)) {
      throw Error(
          ErrorCode::kUsage,
          fmt::format("--array {}: that is an array of cells: --array {}{}", name, kOfCells, name));
    }
    throw Error(ErrorCode::kUsage, fmt::format("--array {}: {} has no numeric array of that name; "
                                               "see 'tetfusion info'",
                                               name, original.path));
  }
  const bool limits_errors = bounds.max_rms || bounds.max_error;
  if (!limits_errors || !bounds.arrays.empty() || first_float(original.point_data)) return;
  if (const ArrayInfo* const array = first_float(original.cell_data)) {
    throw Error(ErrorCode::kUsage,
                fmt::format("{} has no floating-point point array that {} could be for; of cell "
                            "arrays name those that are meant, as in --array {}{}",
                            original.path, bounds.max_error ? "--max-error" : "--max-rms", kOfCells,
                            array->name));
  }
}

void keep_arrays(const std::vector<std::string>& names, Comparison* comparison) {
  std::erase_if(comparison->arrays, [&](const ArrayComparison& a) {
    return std::ranges::find(names, name_of(a)) == names.end();
  });
  std::erase_if(comparison->missing_arrays, [&](const std::string& name) {
    return std::ranges::find(names, name) == names.end();
  });
  std::erase_if(comparison->retyped_arrays, [&](const RetypedArray& array) {
    return std::ranges::find(names, array.name) == names.end();
  });
}

std::vector<BoundResult> judge_bounds(const Comparison& comparison, const Bounds& bounds) {
  std::vector<BoundResult> results;
  for (const ArrayComparison* a : bounded_arrays(comparison, bounds)) {
    if (bounds.max_rms) results.push_back(judge(*a, comparison, true, *bounds.max_rms));
    if (bounds.max_error) results.push_back(judge(*a, comparison, false, *bounds.max_error));
  }
  for (const std::string& name : lost_arrays(comparison, bounds)) {
    if (bounds.max_rms) results.push_back(lost(name, "max_rms", *bounds.max_rms));
    if (bounds.max_error) results.push_back(lost(name, "max_error", *bounds.max_error));
  }
  const auto judge_surface = [&](const std::string& bound, const std::string& array,
                                 const std::string& what, double limit, double value) {
    BoundResult r{bound, array, limit, value, false, {}};
    r.broken = !(value <= limit + comparison.rounding);
    if (r.broken) {
      r.sentence =
          fmt::format("--{} is broken: the {} are up to {} of the diagonal apart, above {}", bound,
                      what, percent(value), percent(limit));
    }
    results.push_back(std::move(r));
  };
  if (bounds.surface) {
    judge_surface("surface", "", "surfaces", *bounds.surface,
                  std::max(comparison.to_simplified.max, comparison.to_original.max));
  }
  for (const ArrayComparison& a : comparison.arrays) {
    if (!bounds.interfaces || !a.interfaces) continue;
    judge_surface(kInterfaces, a.info.name, "interfaces of " + a.info.name, *bounds.interfaces,
                  a.interfaces->max());
  }
  for (const std::string& name : comparison.lost_regions) {
    if (bounds.interfaces) results.push_back(lost(name, kInterfaces, *bounds.interfaces));
  }
  return results;
}

}  // namespace tetfusion
