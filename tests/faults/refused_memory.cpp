#include "faults/refused_memory.h"

#include <atomic>
#include <cstdlib>
#include <limits>
#include <new>

namespace {

std::atomic<std::size_t> counted_from{std::numeric_limits<std::size_t>::max()};
std::atomic<std::int64_t> counted{0};
std::atomic<std::int64_t> refused{tetfusion::testing::RefusedMemory::kNone};

}  // namespace

void* operator new(std::size_t bytes) {
  if (bytes >= counted_from && counted++ == refused) throw std::bad_alloc();
  void* const p = std::malloc(bytes == 0 ? 1 : bytes);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }

namespace tetfusion::testing {

RefusedMemory::RefusedMemory(std::size_t smallest, std::int64_t n) {
  counted = 0;
  refused = n;
  counted_from = smallest;
}
RefusedMemory::~RefusedMemory() { counted_from = std::numeric_limits<std::size_t>::max(); }
std::int64_t RefusedMemory::allocations() const { return counted; }

}  // namespace tetfusion::testing
