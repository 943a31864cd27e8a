// Sorting by keys of few bits, on all threads.
#pragma once

#include <cstdint>

#include "base/vector.h"

namespace tetfusion {

// The numbers of the keys, of so many bits, in ascending order of these; equal keys keep their
// order.
Vector<std::uint32_t> sorted_by_key(const Vector<std::uint32_t>& keys, int bits);

}  // namespace tetfusion
