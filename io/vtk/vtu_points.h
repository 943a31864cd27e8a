// The coordinates of a .vtu file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "io/vtk/vtu_input.h"

namespace tetfusion {

ArrayReader open_coordinates(const VtuInput& input, std::size_t piece);

// The type of a mesh's points whose file has coordinates of that type: integers fit into Float64
// (those that a mesh can have as coordinates).
ValueType point_type_for(ValueType coordinates);

// Throws Error(kMemory) for more points than ids of vertices can tell apart.
void check_point_count(const VtuInput& input, std::uint64_t points);

// `count` points from `first` on into `out`, as `type`, which is Float32 or Float64. False when a
// coordinate of them is not finite.
bool read_coordinates(const ArrayReader& reader, ValueType type, std::uint64_t first,
                      std::uint64_t count, std::byte* out);

// False when a coordinate of any point is not finite. Needs no memory.
bool all_finite(const ArrayReader& reader);

// Throws InvalidMesh for a point of the piece that has a coordinate that is not finite.
[[noreturn]] void fail_not_finite(const ArrayReader& reader, std::uint64_t point);

}  // namespace tetfusion
