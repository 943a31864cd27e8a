#include "io/vtk/vtu_points.h"

#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>

#include "base/error.h"
#include "mesh/geometry.h"

namespace tetfusion {

namespace {

// False when a value is not finite.
template <class From, class Real>
bool convert(const Chunk& chunk, Real* out) {
  std::uint32_t bad = 0;
  for (std::uint64_t i = 0; i < chunk.count; ++i) {
    From value;
    std::memcpy(&value, chunk.data + i * sizeof(From), sizeof(From));
    const Real x = static_cast<Real>(value);
    out[i] = x;
    bad |= x - x != 0 ? 1u : 0u;  // x - x is zero, but for infinities and NaN
  }
  return bad == 0;
}

template <class Real>
bool read_as(const ArrayReader& reader, std::uint64_t first, std::uint64_t count, Real* out) {
  std::atomic<bool> finite = true;
  visit_type(reader.type(), [&](auto zero) {
    reader.for_each_chunk(first, count, [&](const Chunk& chunk) {
      if (!convert<decltype(zero)>(chunk, out + (chunk.first - first))) finite = false;
    });
  });
  return finite;
}

template <class Real>
bool is_finite(const Chunk& chunk) {
  std::uint32_t bad = 0;
  for (std::uint64_t i = 0; i < chunk.count; ++i) {
    Real x;
    std::memcpy(&x, chunk.data + i * sizeof(Real), sizeof(Real));
    bad |= x - x != 0 ? 1u : 0u;
  }
  return bad == 0;
}

}  // namespace

ArrayReader open_coordinates(const VtuInput& input, std::size_t piece) {
  return input.open(input.head.pieces[piece].coordinates, "coordinates" + input.of_piece(piece));
}

ValueType point_type_for(ValueType coordinates) {
  return coordinates == ValueType::kFloat32 ? ValueType::kFloat32 : ValueType::kFloat64;
}

void check_point_count(const VtuInput& input, std::uint64_t points) {
  if (points <= kMaxPoints) return;
  input.fail(ErrorCode::kMemory, std::to_string(points) +
                                     " points are more than can be held in memory at once (" +
                                     std::to_string(kMaxPoints) + ")");
}

bool read_coordinates(const ArrayReader& reader, ValueType type, std::uint64_t first,
                      std::uint64_t count, std::byte* out) {
  return type == ValueType::kFloat32
             ? read_as(reader, 3 * first, 3 * count, reinterpret_cast<float*>(out))
             : read_as(reader, 3 * first, 3 * count, reinterpret_cast<double*>(out));
}

bool all_finite(const ArrayReader& reader) {
  std::atomic<bool> finite = true;
  visit_type(reader.type(), [&](auto zero) {
    if constexpr (std::is_floating_point_v<decltype(zero)>) {
      reader.for_each_chunk([&](const Chunk& chunk) {
        if (!is_finite<decltype(zero)>(chunk)) finite = false;
      });
    }
  });
  return finite;
}

void fail_not_finite(const ArrayReader& reader, std::uint64_t point) {
  constexpr std::string_view kAxes = "xyz";
  std::array<double, 3> p{};
  read_coordinates(reader, ValueType::kFloat64, point, 1, reinterpret_cast<std::byte*>(p.data()));
  std::size_t axis = 0;
  while (axis < 2 && std::isfinite(p[axis])) ++axis;
  throw InvalidMesh(reader.message("point " + std::to_string(point) + " has the " + kAxes[axis] +
                                   " coordinate " + std::to_string(p[axis]) +
                                   ", which is not finite" + reader.where(3 * point + axis)));
}

}  // namespace tetfusion
