#include "base/vector.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>

namespace tetfusion::detail {

namespace {

// Sanitizers of addresses know the heap only.
#if defined(__SANITIZE_ADDRESS__)
constexpr bool kHeapOnly = true;
#elif defined(__has_feature)
constexpr bool kHeapOnly = __has_feature(address_sanitizer);
#else
constexpr bool kHeapOnly = false;
#endif

// Arrays of this size and more are the system's pages: freed, they are the system's again at once.
// A heap would keep them, and what lies between those that live: glibc's, as it is in a host that
// has not tamed it, all below 32 MiB, for each thread. From 256 KiB on would save 2 bytes a
// tetrahedron more, but take a tenth more time.
constexpr std::size_t kOwnPages = kHeapOnly ? static_cast<std::size_t>(-1) : std::size_t{1} << 20;
constexpr std::size_t kHugePage = std::size_t{2} << 20;
// Below this a huge page would waste more than it saves.
constexpr std::size_t kHugePageThreshold = 2 * kHugePage;

std::byte* map_pages(std::size_t bytes) {
  void* p = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (p == MAP_FAILED) throw std::bad_alloc();
  return static_cast<std::byte*>(p);
}

std::size_t rounded_up(std::size_t bytes, std::size_t to) { return (bytes + to - 1) / to * to; }

// Begins at a multiple of a huge page. The end, of less than one, has small pages: so no more is
// resident than was written.
std::byte* map_huge_pages(std::size_t bytes) {
  if (bytes > static_cast<std::size_t>(-1) - 2 * kHugePage) throw std::bad_alloc();
  const std::size_t own = rounded_up(bytes, static_cast<std::size_t>(::getpagesize()));
  std::byte* const all = map_pages(own + kHugePage);
  const std::size_t before = rounded_up(reinterpret_cast<std::size_t>(all), kHugePage) -
                             reinterpret_cast<std::size_t>(all);
  if (before > 0) ::munmap(all, before);
  if (before < kHugePage) ::munmap(all + before + own, kHugePage - before);
  // A hint: failure changes nothing but speed.
  ::madvise(all + before, bytes / kHugePage * kHugePage, MADV_HUGEPAGE);
  return all + before;
}

}  // namespace

void* allocate_bytes(std::size_t bytes) {
  if (bytes < kOwnPages) return ::operator new(bytes);
  return bytes < kHugePageThreshold ? map_pages(bytes) : map_huge_pages(bytes);
}

void free_bytes(void* p, std::size_t bytes) noexcept {
  if (bytes < kOwnPages) {
    ::operator delete(p);
  } else {
    ::munmap(p, bytes);
  }
}

}  // namespace tetfusion::detail
