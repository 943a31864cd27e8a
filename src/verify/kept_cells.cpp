#include "verify/kept_cells.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <variant>

#include "base/mix.h"
#include "compare/original_mesh.h"
#include "io/source/mesh_stream.h"
#include "mesh/predicates.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kWindow = std::uint64_t{1} << 18;

std::uint64_t key_of(const Point& p) {
  // -0 and 0 are the same coordinate.
  std::uint64_t key = mix(std::bit_cast<std::uint64_t>(p.x + 0.0));
  key = mix(key + std::bit_cast<std::uint64_t>(p.y + 0.0));
  return mix(key + std::bit_cast<std::uint64_t>(p.z + 0.0));
}

std::uint64_t key_of(const Corners& corners) {
  std::uint64_t sum = 0;
  for (const Point& p : corners) sum += key_of(p);
  return mix(sum);
}

double volume_of(const Corners& c) {
  return std::abs(determinant(c[0], c[1], c[2], c[3]).value) / 6;
}

// f(corners) for each tetrahedron.
template <class F>
void for_each_cell(const Geometry& mesh, F f) {
  std::visit(
      [&](const auto& points) {
        for (const Tet& t : mesh.tets) {
          Corners corners;
          for (std::size_t i = 0; i < 4; ++i) {
            corners[i] = {points[t[i]].x, points[t[i]].y, points[t[i]].z};
          }
          f(corners);
        }
      },
      mesh.points);
}

template <class Real>
void widen(const Vector<std::byte>& bytes, Vector<Point>* points) {
  const auto* numbers = reinterpret_cast<const Real*>(bytes.data());
  for (std::size_t i = 0; i < points->size(); ++i) {
    (*points)[i] = {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
  }
}

PointSet points_inside(MeshSource* original, const RegionOfInterest& region,
                       const RunContext& context) {
  const auto stream = open_stream(original);
  PointSet set(stream->points());
  const ValueType type = original->description().point_type;
  Vector<std::byte> bytes;
  Vector<Point> points;
  Vector<std::uint8_t> inside;
  for (std::uint64_t first = 0; first < stream->points(); first += kWindow) {
    context.check();
    const std::uint64_t count = std::min(kWindow, stream->points() - first);
    bytes.resize(count * 3 * size_of(type));
    stream->read_points(first, count, bytes);
    points.resize(count);
    type == ValueType::kFloat32 ? widen<float>(bytes, &points) : widen<double>(bytes, &points);
    inside.assign(count, 0);
    const auto read = [&](std::size_t array, std::span<std::byte> rows) {
      stream->read_rows(Association::kPoint, array, first, count, rows);
    };
    region.mark<double>(points, read, inside.data());
    for (std::uint64_t i = 0; i < count; ++i) {
      if (inside[i] != 0) set.add(first + i);
    }
  }
  return set;
}

}  // namespace

Vector<std::uint64_t> cell_keys(const Geometry& mesh) {
  Vector<std::uint64_t> keys;
  keys.reserve(mesh.tets.size());
  for_each_cell(mesh, [&](const Corners& corners) { keys.push_back(key_of(corners)); });
  std::sort(keys.begin(), keys.end());
  return keys;
}

OriginalCellFacts survey_cells(MeshSource* original, const RegionOfInterest& region,
                               const Vector<std::uint64_t>& keys, const RunContext& context) {
  const PointSet inside = region.empty() ? PointSet(0) : points_inside(original, region, context);
  const FieldSet none;
  OriginalCellFacts facts;
  OriginalMesh(original, none, none).for_each_cells([&](const OriginalCells& window, double) {
    context.check();
    const auto& ids = window.points.ids;
    for (const Tet& t : window.tets) {
      Corners corners;
      for (std::size_t i = 0; i < 4; ++i) corners[i] = window.points.points[t[i]];
      facts.largest_volume = std::max(facts.largest_volume, volume_of(corners));
      const auto stays = [&](VertexId v) { return inside.has(ids[v]); };
      if (region.empty() || !std::all_of(t.begin(), t.end(), stays)) continue;
      ++facts.inside;
      if (std::binary_search(keys.begin(), keys.end(), key_of(corners))) continue;
      if (facts.missing++ > 0) continue;
      facts.first_missing = 0.25 * ((corners[0] + corners[1]) + (corners[2] + corners[3]));
    }
  });
  return facts;
}

double largest_volume(const Geometry& mesh) {
  double largest = 0;
  for_each_cell(mesh,
                [&](const Corners& corners) { largest = std::max(largest, volume_of(corners)); });
  return largest;
}

}  // namespace tetfusion
