// Arrays of legacy .vtk files that have their values in other forms than this program's.
#pragma once

#include <memory>

#include "io/vtk/array_reader.h"
#include "io/vtk/computed_array.h"

namespace tetfusion {

// The bits from byte `begin` of the file on, the highest one of a byte first: UInt8, 0 or 1. So
// many bits are there.
std::shared_ptr<const ComputedArray> bits_of(const MappedFile& file, std::uint64_t begin,
                                             std::uint64_t bits);

// Shares of a colour, Float32 from 0 to 1, as UInt8 from 0 to 255.
std::shared_ptr<const ComputedArray> colours_of(ArrayReader shares);

// Bytes that are kept.
std::shared_ptr<const ComputedArray> kept_bytes(Vector<std::byte> bytes);

}  // namespace tetfusion
