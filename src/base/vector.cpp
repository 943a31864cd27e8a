#include "base/vector.h"

#include <sys/mman.h>

#include <cstdlib>

namespace tetfusion::detail {

namespace {
constexpr std::size_t kHugePage = std::size_t{2} << 20;
// Below this a huge page would waste more than it saves.
constexpr std::size_t kHugePageThreshold = 2 * kHugePage;
}  // namespace

void* allocate_bytes(std::size_t bytes) {
  if (bytes < kHugePageThreshold) return ::operator new(bytes);
  const std::size_t rounded = (bytes + kHugePage - 1) / kHugePage * kHugePage;
  void* p = std::aligned_alloc(kHugePage, rounded);
  if (p == nullptr) throw std::bad_alloc();
  ::madvise(p, rounded, MADV_HUGEPAGE);  // a hint: failure changes nothing but speed
  return p;
}

void free_bytes(void* p, std::size_t bytes) noexcept {
  if (bytes < kHugePageThreshold) {
    ::operator delete(p);
  } else {
    std::free(p);
  }
}

}  // namespace tetfusion::detail
