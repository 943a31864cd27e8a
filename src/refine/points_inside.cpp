#include "refine/points_inside.h"

#include <algorithm>
#include <cstring>

#include "mesh/regions/region_of_interest.h"

namespace tetfusion {

namespace {

constexpr std::size_t kPointWindow = std::size_t{1} << 16;

template <class Real>
Vector<std::uint8_t> mark(const RefinableMesh& mesh, const ProgressiveFile& file,
                          const RegionOfInterest& region, const std::function<void()>& keep) {
  const std::vector<ArrayInfo>& arrays = file.description().point_data.arrays;
  std::vector<std::size_t> begin{sizeof(Vec3<Real>)};  // of each array's value in a row
  for (const ArrayInfo& a : arrays) begin.push_back(begin.back() + a.row_bytes());
  const std::size_t points = file.counts().points;
  Vector<std::uint8_t> inside(points, std::uint8_t{0});
  Vector<Vec3<Real>> positions;
  for (std::size_t first = 0; first < points; first += kPointWindow) {
    const std::size_t count = std::min(kPointWindow, points - first);
    positions.resize(count);
    const auto copy = [&](std::size_t at, std::size_t bytes, std::byte* out) {
      for (std::size_t i = 0; i < count; ++i) {
        std::memcpy(out + i * bytes, mesh.point_row(first + i) + at, bytes);
      }
    };
    copy(0, sizeof(Vec3<Real>), std::as_writable_bytes(std::span(positions)).data());
    const auto read = [&](std::size_t array, std::span<std::byte> rows) {
      copy(begin[array], begin[array + 1] - begin[array], rows.data());
    };
    region.mark<Real>(positions, read, inside.data() + first);
    keep();
  }
  for (std::size_t v = 0; v < points; ++v) {
    if (!mesh.has_point(v)) inside[v] = 0;
  }
  return inside;
}

}  // namespace

Vector<std::uint8_t> points_inside(const RefinableMesh& mesh, const ProgressiveFile& file,
                                   const std::vector<std::string>& region,
                                   const std::function<void()>& keep) {
  const RegionOfInterest places(region, file.path(), file.description().point_data);
  return file.description().point_type == ValueType::kFloat32
             ? mark<float>(mesh, file, places, keep)
             : mark<double>(mesh, file, places, keep);
}

}  // namespace tetfusion
