// An array that a file does not have as it is: its values are made of others, chunk by chunk.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/vector.h"

namespace tetfusion {

// Safe to use from several threads.
class ComputedArray {
 public:
  virtual ~ComputedArray() = default;

  // The first value of each chunk; one entry more, the number of values.
  virtual Vector<std::uint64_t> chunk_begins() const = 0;

  // The values of a chunk, in native byte order. `out` has room for them, aligned for them. Throws
  // what reading throws.
  virtual void compute(std::size_t chunk, std::byte* out) const = 0;
};

}  // namespace tetfusion
