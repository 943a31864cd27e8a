#include "base/vector.h"

#include "base/page_pool.h"

namespace tetfusion::detail {

namespace {

// Arrays of this size and more are pages of their own.
constexpr std::size_t kOwnPages = std::size_t{256} << 10;

}  // namespace

void* allocate_bytes(std::size_t bytes) {
  return bytes < kOwnPages ? ::operator new(bytes) : allocate_pages(bytes);
}

void free_bytes(void* p, std::size_t bytes) noexcept {
  if (bytes < kOwnPages) {
    ::operator delete(p);
  } else {
    free_pages(static_cast<std::byte*>(p), bytes);
  }
}

}  // namespace tetfusion::detail
