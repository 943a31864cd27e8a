#include "io/mesh_passes.h"

#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>
#include <variant>

#include "base/error.h"
#include "mesh/region_names.h"

namespace tetfusion {

namespace {

void append_lower(const LowerCells& from, LowerCells* to) {
  if (to->offsets.empty()) to->offsets.push_back(0);
  const std::uint64_t before = to->connectivity.size();
  for (std::size_t c = 0; c < from.size(); ++c) to->offsets.push_back(before + from.offsets[c + 1]);
  to->types.insert(to->types.end(), from.types.begin(), from.types.end());
  to->connectivity.insert(to->connectivity.end(), from.connectivity.begin(),
                          from.connectivity.end());
}

}  // namespace

Vector<std::int64_t> to_integers(const ArrayInfo& info, std::span<const std::byte> values) {
  Vector<std::int64_t> out(values.size() / size_of(info.type));
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
      out[i] = static_cast<std::int64_t>(value);
    }
  });
  return out;
}

MeshPasses::MeshPasses(MeshSource* source, const MeshStream* stream, std::string label)
    : source_(source), stream_(stream), label_(std::move(label)) {
  CellWindow cells;
  for (std::uint64_t first = 0; first < stream_->cells(); first += kWindow) {
    stream_->read_cells(first, window(first, stream_->cells()), &cells);
    tets_ += cells.tets.size();
    if (cells.lower.size() == 0) continue;
    append_lower(cells.lower, &lower_);
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
  rows.resize(count * of.components * size_of(of.type));
  stream_->read_rows(association, array, first, count, rows);
  return rows;
}

// The rows of some cells of a window, which begins at `first`. No rows: those at its begin.
Vector<std::byte> MeshPasses::rows_of(const Vector<std::uint64_t>& rows, std::size_t cells,
                                      std::size_t array, std::uint64_t first,
                                      std::uint64_t count) const {
  if (array == kNone || cells == 0) return {};
  const ArrayInfo& of = info(Association::kCell, array);
  const std::size_t stride = of.components * size_of(of.type);
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

std::size_t find_references(const AttributeSet& set, Association association, const char* own,
                            const std::string& label) {
  const auto find = [&](std::string_view name) {
    const std::size_t i = set.find(name);
    return i != AttributeSet::npos && is_integer_label(set.arrays[i]) ? i : AttributeSet::npos;
  };
  for (const char* name : {own, "medit:ref", "gmsh:physical", "tetgen:ref"}) {
    if (const std::size_t i = find(name); i != AttributeSet::npos) return i;
  }
  if (association == Association::kPoint) return AttributeSet::npos;
  if (const std::size_t i = find(label); i != AttributeSet::npos) return i;
  for (std::size_t i = 0; i < set.arrays.size(); ++i) {
    if (looks_like_region(set.arrays[i])) return i;
  }
  return AttributeSet::npos;
}

}  // namespace tetfusion
