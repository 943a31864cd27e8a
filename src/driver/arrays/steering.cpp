#include "driver/arrays/steering.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

#include "base/blocks.h"
#include "base/error.h"
#include "base/numbers.h"
#include "driver/arrays/notices.h"
#include "driver/arrays/rows_in_use.h"
#include "io/source/stream_windows.h"
#include "mesh/array_names.h"
#include "mesh/predicates.h"

namespace tetfusion {

Tolerances tolerances_of(const std::vector<SteeringChoice>& choices) {
  Tolerances tolerances;
  for (const SteeringChoice& choice : choices) tolerances.push_back(choice.tolerance);
  return tolerances;
}

namespace {

std::optional<SteeringChoice> find_named(const MeshDescription& mesh, const std::string& name,
                                         bool for_steering) {
  constexpr std::string_view kCellPrefix = "cell:";
  SteeringChoice choice;
  choice.name = name;
  choice.index = mesh.point_data.find(name);
  const bool is_there = choice.index != AttributeSet::npos;
  if (is_there && (for_steering || !mesh.point_data.arrays[choice.index].steers_only)) {
    return choice;
  }
  if (name.starts_with(kCellPrefix)) {
    choice.association = Association::kCell;
    choice.index = mesh.cell_data.find(name.substr(kCellPrefix.size()));
    if (choice.index != AttributeSet::npos) return choice;
  }
  return std::nullopt;
}

}  // namespace

std::optional<SteeringChoice> find_array(const MeshDescription& mesh, const std::string& name) {
  return find_named(mesh, name, true);
}

std::optional<SteeringChoice> find_own_array(const MeshDescription& mesh, const std::string& name) {
  return find_named(mesh, name, false);
}

// A bare one would be refused.
std::string with_tolerance(const std::string& name, double tolerance) {
  return tolerance == 1 ? name + ":100%" : fmt::format("{}:{}", name, tolerance);
}

namespace {

// What is behind the last colon of what a user has given.
double tolerance_in(const std::string& text) {
  const std::string share = text.substr(text.rfind(':') + 1);
  const auto tolerance = parse_share(share);
  if (tolerance && is_bare_one(share)) refuse(fmt::format("--array {}: give 100% or 1%", text));
  if (tolerance && *tolerance > 0 && *tolerance <= 1) return *tolerance;
  throw Error(ErrorCode::kUsage,
              fmt::format("--array {}: the tolerance \"{}\" must be greater than 0% and at most "
                          "100% of the field's range, as in 0.5%",
                          text, share));
}

SteeringChoice resolve(const MeshDescription& mesh, const std::string& text) {
  if (auto choice = find_array(mesh, text)) return *choice;
  const std::size_t colon = text.rfind(':');
  if (colon != std::string::npos) {
    if (auto choice = find_array(mesh, text.substr(0, colon))) {
      choice->tolerance = tolerance_in(text);
      return *choice;
    }
  }
  throw Error(
      ErrorCode::kUsage,
      fmt::format("{}: no array \"{}\" to steer by; point arrays: {}; cell arrays (name them "
                  "cell:NAME): {}",
                  mesh.path, text, names_of(mesh.point_data), names_of(mesh.cell_data)));
}

Vector<Vec3<double>> read_positions(const MeshDescription& mesh, const MeshStream& stream,
                                    const RunContext& context) {
  Vector<Vec3<double>> positions(stream.points());
  Vector<std::byte> rows;
  for_each_window(positions.size(), context, [&](std::uint64_t first, std::uint64_t count) {
    rows.resize(count * 3 * size_of(mesh.point_type));
    stream.read_points(first, count, rows);
    const Vector<double> values = to_doubles(mesh.point_type, rows);
    for (std::size_t p = 0; p < count; ++p) {
      positions[first + p] = {values[3 * p], values[3 * p + 1], values[3 * p + 2]};
    }
  });
  return positions;
}

}  // namespace

Vector<double> means_at_points(std::size_t cell_array, const MeshDescription& mesh,
                               const MeshStream& stream, const RunContext& context) {
  const ArrayInfo& info = mesh.cell_data.arrays[cell_array];
  const std::size_t components = info.components;
  const Vector<Vec3<double>> positions = read_positions(mesh, stream, context);
  Vector<double> sums, weights;
  sums.assign(positions.size() * components, 0.0);
  weights.assign(positions.size(), 0.0);
  CellWindow window;
  const auto add = [&](std::uint64_t first, std::span<const std::byte> rows) {
    const Vector<double> values = to_doubles(info.type, rows);
    stream.read_cells(first, values.size() / components, &window);
    for (std::size_t t = 0; t < window.tets.size(); ++t) {
      const Tet& tet = window.tets[t];
      const double volume = std::abs(determinant(positions, tet).value);
      const std::size_t row = window.tet_rows.empty() ? t : window.tet_rows[t] - first;
      for (const VertexId v : tet) {
        weights[v] += volume;
        for (std::size_t k = 0; k < components; ++k) {
          sums[v * components + k] += volume * values[row * components + k];
        }
      }
    }
  };
  for_each_window_of(stream, Association::kCell, cell_array, info, context, add);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const double weight = weights[i / components];
    sums[i] /= weight > 0 ? weight : 1;
  }
  return sums;
}

std::vector<SteeringChoice> choices_by_default(const MeshDescription& mesh) {
  const AttributeSet& set = mesh.point_data;
  const auto scalars = set.active.find("Scalars");
  const std::size_t active =
      scalars == set.active.end() ? AttributeSet::npos : set.find(scalars->second);
  std::vector<SteeringChoice> choices;
  const auto add = [&](std::size_t i) {
    choices.push_back({Association::kPoint, i, {}, set.arrays[i].name});
  };
  if (active != AttributeSet::npos) add(active);
  for (std::size_t i = 0; i < set.arrays.size(); ++i) {
    if (i != active && is_float(set.arrays[i].type)) add(i);
  }
  return choices;
}

namespace {

// Is there a row that differs from the first one, which is noted if none was before? Rows that are
// not finite do not count, nor do those that are not in use, where that is known; the first of
// these is number `first` there.
bool has_another_row(const ArrayInfo& info, std::span<const std::byte> rows, std::uint64_t first,
                     const BitSet& in_use, Vector<double>* first_row) {
  const Vector<double> values = to_doubles(info.type, rows);
  for (std::size_t i = 0; i < values.size(); i += info.components) {
    if (!in_use.empty() && !in_use.has(first + i / info.components)) continue;
    const std::span<const double> row(values.data() + i, info.components);
    if (!std::ranges::all_of(row, [](double v) { return std::isfinite(v); })) continue;
    if (first_row->empty()) first_row->assign(row.begin(), row.end());
    if (!std::ranges::equal(row, *first_row)) return true;
  }
  return false;
}

}  // namespace

bool varies(std::size_t point_array, MeshSource* source, const MeshStream* stream,
            const RunContext& context) {
  const ArrayInfo& info = source->description().point_data.arrays[point_array];
  if (stream == nullptr) {
    const DataArray array = source->read_array(Association::kPoint, point_array);
    Vector<double> first_row;
    return has_another_row(info, array.bytes, 0, {}, &first_row);
  }
  const auto varies_among = [&](const BitSet& in_use) {
    Vector<double> first_row;
    bool found = false;
    for_each_window_of(*stream, Association::kPoint, point_array, info, context,
                       [&](std::uint64_t first, std::span<const std::byte> rows) {
                         found = has_another_row(info, rows, first, in_use, &first_row);
                         return !found;
                       });
    return found;
  };
  // Few cells say it of most arrays.
  constexpr std::uint64_t kFewCells = 1 << 14;
  const auto among_cells = [&](std::uint64_t cells) {
    return varies_among(find_rows_in_use(*stream, Association::kPoint, context, cells));
  };
  return varies_among({}) && (among_cells(kFewCells) || among_cells(stream->cells()));
}

namespace {

// Of point arrays.
std::vector<SteeringChoice>::const_iterator first_that_varies(
    const std::vector<SteeringChoice>& choices, MeshSource* source, const MeshStream* stream,
    const RunContext& context) {
  return std::ranges::find_if(choices, [&](const SteeringChoice& choice) {
    return varies(choice.index, source, stream, context);
  });
}

}  // namespace

std::uint32_t components_of(const std::vector<SteeringChoice>& choices,
                            const MeshDescription& mesh) {
  std::uint32_t width = 0;
  for (const SteeringChoice& choice : choices) {
    const bool of_cells = choice.association == Association::kCell;
    width += (of_cells ? mesh.cell_data : mesh.point_data).arrays[choice.index].components;
  }
  return width;
}

namespace {

constexpr std::string_view kAllWithin = "all:";

bool means_all(const MeshDescription& mesh, const std::string& text) {
  return (text == kAllArrays || text.starts_with(kAllWithin)) && !find_array(mesh, text) &&
         !find_array(mesh, std::string(kAllArrays));
}

// The floating-point arrays of the points that are not among *choices.
void add_all(const MeshDescription& mesh, const std::string& text,
             std::vector<SteeringChoice>* choices) {
  std::optional<double> tolerance;
  if (text != kAllArrays) tolerance = tolerance_in(text);
  const auto& arrays = mesh.point_data.arrays;
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    const bool is_there = std::any_of(choices->begin(), choices->end(), [&](const auto& c) {
      return c.association == Association::kPoint && c.index == i;
    });
    if (is_there || !is_float(arrays[i].type)) continue;
    choices->push_back({Association::kPoint, i, tolerance, arrays[i].name, true});
  }
  if (!choices->empty()) return;
  throw Error(ErrorCode::kUsage,
              fmt::format("{}: --array {}: the points have no floating-point array; cell arrays "
                          "(name them cell:NAME): {}",
                          mesh.path, text, names_of(mesh.cell_data)));
}

}  // namespace

std::vector<SteeringChoice> choose_steering(const MeshDescription& mesh,
                                            const std::vector<std::string>& names) {
  std::vector<SteeringChoice> choices;
  for (const std::string& name : names) {
    if (means_all(mesh, name)) continue;
    SteeringChoice choice = resolve(mesh, name);
    choice.by_name = true;
    const bool is_twin = std::any_of(choices.begin(), choices.end(), [&](const SteeringChoice& c) {
      return c.index == choice.index && c.association == choice.association;
    });
    if (is_twin) {
      throw Error(ErrorCode::kUsage,
                  fmt::format("--array {}: that array steers already; name it once", name));
    }
    choices.push_back(std::move(choice));
  }
  bool have_all = false;
  for (const std::string& name : names) {
    if (!means_all(mesh, name)) continue;
    if (std::exchange(have_all, true)) {
      throw Error(ErrorCode::kUsage,
                  fmt::format("--array {}: all arrays steer already; give that once", name));
    }
    add_all(mesh, name, &choices);
  }
  return choices;
}

std::optional<SteeringChoice> steering_by_default(MeshSource* source, const MeshStream* stream,
                                                  const RunContext& context) {
  const std::vector<SteeringChoice> choices = choices_by_default(source->description());
  const auto first = first_that_varies(choices, source, stream, context);
  return first == choices.end() ? std::nullopt : std::optional(*first);
}

std::vector<SteeringChoice> choose_what_varies(MeshSource* source, const MeshStream* stream,
                                               const RunContext& context) {
  const std::vector<SteeringChoice> choices = choices_by_default(source->description());
  const auto first = first_that_varies(choices, source, stream, context);
  if (first == choices.end()) return choices;
  for (auto before = choices.begin(); before != first; ++before) {
    say_does_not_steer(before->name, context);
  }
  return {*first};
}

void Steering::read_array(const Array& array, std::uint64_t first, std::uint64_t count,
                          Vector<double>* values) const {
  const std::size_t components = array.components;
  if (!array.averages.empty()) {
    const double* begin = array.averages.data() + first * components;
    values->assign(begin, begin + count * components);
    return;
  }
  Vector<std::byte> rows(count * components * size_of(array.type));
  stream_->read_rows(Association::kPoint, array.index, first, count, rows);
  *values = to_doubles(array.type, rows);
}

Steering::Measured Steering::measure(Array* array, const std::function<bool(VertexId)>& is_used,
                                     const RunContext& context) const {
  // A sixteenth, so that neither a difference nor the diagonal of a tensor's box overflows.
  constexpr double kSixteenth = 1.0 / 16;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  struct Range {
    double lo = kInfinity;
    double hi = -kInfinity;
  };
  const std::size_t components = array->components;
  const std::uint64_t points = stream_->points();
  std::vector<std::vector<Range>> windows(block_count(points, kStreamWindow));
  std::atomic<bool> has_some{false}, lacks_some{false};
  for_each_block(points, kStreamWindow, [&](std::size_t w, std::size_t begin, std::size_t end) {
    context.check();
    Vector<double> values;
    read_array(*array, begin, end - begin, &values);
    windows[w].resize(components);
    for (std::size_t row = 0; row < values.size(); row += components) {
      const std::span<const double> tuple(values.data() + row, components);
      if (is_used && !is_used(static_cast<VertexId>(begin + row / components))) continue;
      const bool is_finite = std::ranges::all_of(tuple, [](double v) { return std::isfinite(v); });
      std::atomic<bool>& seen = is_finite ? has_some : lacks_some;
      if (!seen.load(std::memory_order_relaxed)) seen.store(true, std::memory_order_relaxed);
      if (!is_finite) continue;
      for (std::size_t k = 0; k < components; ++k) {
        Range& range = windows[w][k];
        range.lo = std::min(range.lo, tuple[k]);
        range.hi = std::max(range.hi, tuple[k]);
      }
    }
  });
  double diagonal = 0, largest = 0;
  for (std::size_t k = 0; k < components; ++k) {
    Range all;
    for (const std::vector<Range>& window : windows) {
      all.lo = std::min(all.lo, window[k].lo);
      all.hi = std::max(all.hi, window[k].hi);
    }
    if (all.hi >= all.lo) largest = std::max({largest, std::abs(all.lo), std::abs(all.hi)});
    if (all.hi > all.lo) {
      diagonal = std::hypot(diagonal, kSixteenth * all.hi - kSixteenth * all.lo);
    }
  }
  Measured measured{0, has_some && lacks_some};
  int exponent = 0;
  if (!(diagonal > 0)) {
    std::frexp(largest, &exponent);
    array->exponent = -exponent;
    return measured;
  }
  measured.range = std::frexp(diagonal, &exponent);
  array->exponent = -exponent - 4;
  return measured;
}

Steering::Steering(const std::vector<SteeringChoice>& choices, const MeshDescription& mesh,
                   const MeshStream& stream, const RunContext& context)
    : stream_(&stream) {
  for (const SteeringChoice& choice : choices) {
    context.check();
    const bool of_cells = choice.association == Association::kCell;
    const ArrayInfo& info = (of_cells ? mesh.cell_data : mesh.point_data).arrays[choice.index];
    Array array{choice.index, info.type, info.components, 0, {}};
    if (of_cells) {
      say_means_steer(choice.name, context);
      array.averages = means_at_points(choice.index, mesh, stream, context);
    }
    Measured measured = measure(&array, {}, context);
    // Any range will do for what is the same wherever it is anything.
    if (measured.has_gaps && choice.by_name && measured.range == 0) measured.range = 1;
    if (measured.range > 0) {
      fields_.push_back(
          {width_, array.components, measured.range, choice.tolerance, kNoColumn, array.exponent});
      names_.push_back(choice.name);
      width_ += array.components;
      if (!of_cells && !is_float(info.type)) {
        context.say(
            fmt::format("array {} holds whole numbers: the smooth field through them steers, "
                        "and bounds are for that; a new point gets the value of one near it",
                        choice.name));
      }
      arrays_.push_back(std::move(array));
    } else if (!info.steers_only) {
      say_does_not_steer(choice.name, context);
    }
  }
}

void Steering::relate_to(const std::function<bool(VertexId)>& is_used, const RunContext& context) {
  for (std::size_t f = 0; f < fields_.size(); ++f) {
    const double range = measure(&arrays_[f], is_used, context).range;
    if (range > 0) {
      fields_[f].range = range;
      fields_[f].exponent = arrays_[f].exponent;
    } else {
      arrays_[f].exponent = fields_[f].exponent;
    }
  }
}

void Steering::read(std::uint64_t first, std::uint64_t count, double* values,
                    std::uint8_t* not_finite) const {
  // Not an infinity: whoever averages would have to leave that out, too.
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  Vector<double> of_array;
  std::size_t at = 0;
  for (const Array& array : arrays_) {
    read_array(array, first, count, &of_array);
    for (std::size_t p = 0; p < count; ++p) {
      for (std::size_t k = 0; k < array.components; ++k) {
        const double value = of_array[p * array.components + k];
        const bool is_finite = std::isfinite(value);
        if (!is_finite) not_finite[p] = 1;
        values[p * width_ + at + k] = is_finite ? std::ldexp(value, array.exponent) : kNone;
      }
    }
    at += array.components;
  }
}

}  // namespace tetfusion
