#include "io/formats/format_stream.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/bit_set.h"
#include "base/error.h"
#include "io/source/cell_kinds.h"
#include "io/source/cell_windows.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

// When the stream is opened, at a time.
constexpr std::uint64_t kPointsScanned = std::uint64_t{1} << 18;

class FormatStream final : public MeshStream {
 public:
  FormatStream(const FormatReader& reader, const OpenOptions& options)
      : reader_(reader), options_(options) {
    for (std::uint64_t first = 0; first < points(); first += kPointsScanned) {
      const std::uint64_t count = std::min(kPointsScanned, points() - first);
      if (reader_.description().point_type == ValueType::kFloat32) {
        scan<float>(first, count);
      } else {
        scan<double>(first, count);
      }
    }
  }

  std::uint64_t points() const override { return reader_.description().points; }
  std::uint64_t cells() const override { return reader_.description().cells; }
  LowerCount lower_cells() const override {
    const CellTypeCounts types = reader_.cell_types();
    LowerCount lower;
    for (const std::uint8_t type : {kVtkVertex, kVtkLine, kVtkTriangle}) {
      if (is_dropped_patch(type, options_)) continue;
      lower.cells += types[type];
      lower.corners += types[type] * static_cast<std::uint64_t>(vtk_cell_size(type));
    }
    return lower;
  }
  std::uint64_t ghost_cells() const override { return 0; }
  std::uint64_t merged_points() const override { return 0; }
  std::uint64_t dropped_points() const override { return 0; }
  bool streams_from_disk() const override { return true; }
  std::uint64_t bytes() const override { return reader_.bytes() + bad_points_.bytes(); }

  void read_points(std::uint64_t first, std::uint64_t count,
                   std::span<std::byte> out) const override {
    check_window(first, count, points());
    reader_.read_points(first, count, out.data());
  }

  void read_cells(std::uint64_t first, std::uint64_t count, CellWindow* out) const override {
    check_window(first, count, cells());
    clear(out);
    if (count == 0) return;
    ListedCells list = reader_.read_cells(first, count);
    Vector<std::uint64_t> ends(count + 1);
    ends[0] = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
      ends[i + 1] = ends[i] + static_cast<std::uint64_t>(vtk_cell_size(list.types[i]));
    }
    leave_out_patches(options_, list.types);
    sort_cells({first, list.types, ends, list.ids}, out);
    if (!bad_points_.empty()) check_finite(*out);
  }

  void read_rows(Association association, std::size_t index, std::uint64_t first,
                 std::uint64_t count, std::span<std::byte> out) const override {
    check_window(first, count, association == Association::kPoint ? points() : cells());
    reader_.read_rows(association, index, first, count, out.data());
  }

 private:
  template <class Real>
  void scan(std::uint64_t first, std::uint64_t count) {
    Vector<Vec3<Real>> window(count);
    reader_.read_points(first, count, reinterpret_cast<std::byte*>(window.data()));
    for (std::uint64_t i = 0; i < count; ++i) {
      const Vec3<Real>& p = window[i];
      if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) continue;
      if (bad_points_.empty()) bad_points_.resize(points());
      bad_points_.set(first + i);
    }
  }

  // Names the lowest point.
  void check_finite(const CellWindow& window) const {
    const VertexId lowest = lowest_vertex(window, [&](VertexId v) { return bad_points_.has(v); });
    if (lowest == kNoVertex) return;
    Vec3<double> p{};
    if (reader_.description().point_type == ValueType::kFloat32) {
      Vec3<float> narrow{};
      reader_.read_points(lowest, 1, reinterpret_cast<std::byte*>(&narrow));
      p = {narrow.x, narrow.y, narrow.z};
    } else {
      reader_.read_points(lowest, 1, reinterpret_cast<std::byte*>(&p));
    }
    const double axes[3] = {p.x, p.y, p.z};
    std::size_t axis = 0;
    while (axis < 2 && std::isfinite(axes[axis])) ++axis;
    fail_not_finite(reader_.description(), lowest, axis, axes[axis]);
  }

  const FormatReader& reader_;
  const OpenOptions& options_;
  BitSet bad_points_;  // empty when all are finite
};

bool can_stream(const FormatReader& reader, const OpenOptions& options) {
  const CellTypeCounts types = reader.cell_types();
  std::uint64_t taken = 0;
  for (std::size_t t = 0; t < types.size(); ++t) {
    const auto type = static_cast<std::uint8_t>(t);
    const bool as_it_is = type == kVtkTetra || type == kVtkTriangle || type == kVtkLine ||
                          type == kVtkVertex || is_dropped_patch(type, options);
    taken += as_it_is ? types[t] : 0;
  }
  return types[kVtkTetra] > 0 && taken == reader.description().cells && reader.has_rows_in_order();
}

}  // namespace

std::unique_ptr<MeshStream> open_format_stream(const FormatReader& reader,
                                               const OpenOptions& options) {
  if (!can_stream(reader, options)) return nullptr;
  return std::make_unique<FormatStream>(reader, options);
}

void fail_not_finite(const MeshDescription& mesh, std::uint64_t point, std::size_t axis,
                     double value) {
  constexpr const char* kAxes[] = {"x", "y", "z"};
  throw InvalidMesh(mesh.path + ": point " + std::to_string(point) + " has the " + kAxes[axis] +
                    " coordinate " + std::to_string(value) + ", which is not finite");
}

}  // namespace tetfusion
