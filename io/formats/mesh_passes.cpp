#include "io/formats/mesh_passes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>
#include <variant>

#include "base/error.h"
#include "mesh/regions/region_names.h"

namespace tetfusion {

namespace {

// Integers that are called as one of the formats calls its own, `own` before the others.
std::vector<std::size_t> labels_of_formats(const AttributeSet& set, const char* own) {
  std::vector<std::size_t> found;
  for (const std::string_view name :
       {std::string_view(own), std::string_view("medit:ref"), std::string_view("gmsh:physical"),
        std::string_view("tetgen:ref")}) {
    const std::size_t i = set.find(name);
    const bool is_new = std::find(found.begin(), found.end(), i) == found.end();
    if (i != AttributeSet::npos && is_integer_label(set.arrays[i]) && is_new) found.push_back(i);
  }
  return found;
}

}  // namespace

Vector<std::int64_t> to_integers(const ArrayInfo& info, std::span<const std::byte> values) {
  Vector<std::int64_t> out;
  out.assign(values.size() / size_of(info.type), 0);
  visit_type(info.type, [&](auto zero) {
    using From = decltype(zero);
    for (std::size_t i = 0; i < out.size(); ++i) {
      From value;
      std::memcpy(&value, values.data() + i * sizeof(From), sizeof(From));
      if constexpr (std::is_same_v<From, std::uint64_t>) {
        if (value > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) {
          throw Error(ErrorCode::kBadInput, "array \"" + info.name + "\": " +
                                                std::to_string(value) + " is too large to write");
        }
      }
      if constexpr (std::is_floating_point_v<From>) {
        if (std::isnan(value)) continue;  // stays 0
      }
      out[i] = static_cast<std::int64_t>(value);
    }
  });
  return out;
}

MeshPasses::MeshPasses(MeshSource* source, const MeshStream* stream)
    : source_(source), stream_(stream) {
  CellWindow cells;
  for (std::uint64_t first = 0; first < stream_->cells(); first += kWindow) {
    stream_->read_cells(first, window(first, stream_->cells()), &cells);
    tets_ += cells.tets.size();
    if (cells.lower.size() == 0) continue;
    lower_.add(cells.lower);
    lower_rows_.emplace_back(first, std::move(cells.lower_rows));
  }
}

Vector<std::uint64_t> MeshPasses::lower_of_type(std::uint8_t type) const {
  Vector<std::uint64_t> cells;
  for (std::uint64_t c = 0; c < lower_.size(); ++c) {
    if (lower_.types[c] == type) cells.push_back(c);
  }
  return cells;
}

void MeshPasses::expect(std::uint64_t rows, std::function<void(double)> progress) {
  expected_ = rows;
  visited_ = 0;
  progress_ = std::move(progress);
}

void MeshPasses::visited(std::uint64_t rows) {
  visited_ += rows;
  if (!progress_ || expected_ == 0) return;
  progress_(static_cast<double>(visited_ < expected_ ? visited_ : expected_) /
            static_cast<double>(expected_));
}

const ArrayInfo& MeshPasses::info(Association association, std::size_t array) const {
  const MeshDescription& d = source_->description();
  return (association == Association::kPoint ? d.point_data : d.cell_data).arrays.at(array);
}

Points MeshPasses::read_points(std::uint64_t first, std::uint64_t count) const {
  Points points;
  const auto read = [&](auto xyz) {
    xyz.resize(count);
    stream_->read_points(first, count, std::as_writable_bytes(std::span(xyz)));
    points = std::move(xyz);
  };
  if (source_->description().point_type == ValueType::kFloat32) {
    read(Vector<Vec3<float>>());
  } else {
    read(Vector<Vec3<double>>());
  }
  return points;
}

Vector<std::byte> MeshPasses::read_rows(Association association, std::size_t array,
                                        std::uint64_t first, std::uint64_t count) const {
  Vector<std::byte> rows;
  if (array == kNone) return rows;
  const ArrayInfo& of = info(association, array);
  rows.resize(count * of.row_bytes());
  stream_->read_rows(association, array, first, count, rows);
  return rows;
}

// The rows of some cells of a window, which begins at `first`. No rows: those at its begin.
Vector<std::byte> MeshPasses::rows_of(const Vector<std::uint64_t>& rows, std::size_t cells,
                                      std::size_t array, std::uint64_t first,
                                      std::uint64_t count) const {
  if (array == kNone || cells == 0) return {};
  const ArrayInfo& of = info(Association::kCell, array);
  const std::size_t stride = of.row_bytes();
  Vector<std::byte> all = read_rows(Association::kCell, array, first, count);
  if (rows.empty()) {
    all.resize(cells * stride);
    return all;
  }
  Vector<std::byte> chosen(cells * stride);
  for (std::size_t c = 0; c < cells; ++c) {
    std::memcpy(chosen.data() + c * stride, all.data() + (rows[c] - first) * stride, stride);
  }
  return chosen;
}

Vector<std::byte> MeshPasses::lower_rows(std::size_t array) const {
  Vector<std::byte> all;
  for (const auto& [first, rows] : lower_rows_) {
    const Vector<std::byte> chosen =
        rows_of(rows, rows.size(), array, first, window(first, stream_->cells()));
    all.insert(all.end(), chosen.begin(), chosen.end());
  }
  return all;
}

std::size_t find_point_labels(const AttributeSet& points, const char* own) {
  const std::vector<std::size_t> found = labels_of_formats(points, own);
  return found.empty() ? AttributeSet::npos : found.front();
}

std::vector<std::size_t> possible_labels(const AttributeSet& cells, const LabelPlace& place,
                                         const std::string& label, bool label_comes_first) {
  std::vector<std::size_t> possible;
  const auto add = [&](std::size_t i) {
    const bool is_new = std::find(possible.begin(), possible.end(), i) == possible.end();
    if (i != AttributeSet::npos && can_be_region(cells.arrays[i]) && is_new) possible.push_back(i);
  };
  const auto add_first = [&](auto is_one) {
    const auto found = std::find_if(cells.arrays.begin(), cells.arrays.end(), is_one);
    if (found == cells.arrays.end()) return;
    add(static_cast<std::size_t>(found - cells.arrays.begin()));
  };
  if (label_comes_first) add(cells.find(label));
  for (const std::size_t i : labels_of_formats(cells, place.own)) add(i);
  add(cells.find(label));
  add_first(looks_like_region);
  if (place.holds_own_fractions) add(cells.find(place.own));
  add_first(is_region_of_floats);
  return possible;
}

// Why that cannot be labels of so many bits; empty if it can.
std::string MeshPasses::refusal(std::size_t cell_array, int bits) const {
  const ArrayInfo& of = info(Association::kCell, cell_array);
  const auto bytes = static_cast<int>(size_of(of.type));
  const bool is_unsigned = of.type == ValueType::kUInt8 || of.type == ValueType::kUInt16 ||
                           of.type == ValueType::kUInt32 || of.type == ValueType::kUInt64;
  if (!is_float(of.type) && 8 * bytes + (is_unsigned ? 1 : 0) <= bits) return {};
  const double limit = std::ldexp(1.0, bits - 1);
  std::string why;
  for (std::uint64_t first = 0; why.empty() && first < stream_->cells(); first += kWindow) {
    const Vector<std::byte> rows =
        read_rows(Association::kCell, cell_array, first, window(first, stream_->cells()));
    for (const double value : to_doubles(of.type, rows)) {
      if (std::isnan(value)) continue;
      if (!(value >= -limit && value < limit)) {
        why = fmt::format("its value {} has more than {} bits", value, bits);
      } else if (value != std::trunc(value)) {
        why = fmt::format("its value {} is no whole number", value);
      }
      if (!why.empty()) break;
    }
  }
  return why;
}

bool MeshPasses::is_zero(std::size_t cell_array) const {
  const ValueType type = info(Association::kCell, cell_array).type;
  for (std::uint64_t first = 0; first < stream_->cells(); first += kWindow) {
    const Vector<std::byte> rows =
        read_rows(Association::kCell, cell_array, first, window(first, stream_->cells()));
    for (const double value : to_doubles(type, rows)) {
      if (value != 0 && !std::isnan(value)) return false;
    }
  }
  return true;
}

void MeshPasses::choose_labels(const std::vector<std::size_t>& possible, const LabelPlace& place,
                               const std::string& label, bool is_meant, const std::string& path,
                               const std::function<void(std::string_view)>& tell) {
  const auto name_of = [&](std::size_t i) -> const std::string& {
    return info(Association::kCell, i).name;
  };
  const auto say = [&](const std::string& what) {
    if (tell) tell(what);
  };
  // Values of these are as they are written by one of the formats: to refuse them is to lose them.
  const std::vector<std::size_t> of_formats = labels_of_formats(description().cell_data, place.own);
  std::size_t empty = kNone;
  std::string refused;  // an array that looks like groups
  labels_ = kNone;
  for (const std::size_t i : possible) {
    const bool is_of_format =
        std::find(of_formats.begin(), of_formats.end(), i) != of_formats.end();
    const bool is_own = place.holds_own_fractions && name_of(i) == place.own;
    const std::string why = is_of_format || is_own ? "" : refusal(i, place.bits);
    if (!why.empty()) {
      if (is_meant && name_of(i) == label) {
        throw Error(ErrorCode::kUsage, fmt::format("--labels {}: cannot be the {} of {}: {}", label,
                                                   place.name, path, why));
      }
      const std::string what =
          fmt::format("cell array {} cannot be the {} of {}{}: {}", name_of(i), place.name, path,
                      place.is_only_place ? ", and is left out" : "", why);
      // Elsewhere it keeps its values, under its name.
      if (place.is_only_place || name_of(i) == label) {
        say(what);
      } else if (refused.empty() && looks_like_region(info(Association::kCell, i))) {
        refused = what;
      }
    } else if (possible.size() > 1 && name_of(i) != label && is_zero(i)) {
      if (empty == kNone) empty = i;
    } else {
      labels_ = i;
      break;
    }
  }
  if (labels_ == kNone) labels_ = empty;
  if (labels_ == kNone && !refused.empty()) say(refused);
  if (empty != kNone && labels_ != empty) {
    say(fmt::format("cell array {} is 0 everywhere: {} becomes the {} of {} in its place",
                    name_of(empty), name_of(labels_), place.name, path));
  }
}

}  // namespace tetfusion
