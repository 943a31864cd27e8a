// Memory that is refused: this program's operator new counts, and throws where it is told to.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tetfusion::testing {

// While it lives, allocation n (from 0) of those of at least `smallest` bytes throws
// std::bad_alloc, in whatever thread. One at a time.
class RefusedMemory {
 public:
  static constexpr std::int64_t kNone = -1;
  RefusedMemory(std::size_t smallest, std::int64_t n);
  ~RefusedMemory();
  RefusedMemory(const RefusedMemory&) = delete;
  RefusedMemory& operator=(const RefusedMemory&) = delete;

  std::int64_t allocations() const;  // of that size, so far
};

}  // namespace tetfusion::testing
