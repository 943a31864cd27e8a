#include "base/page_pool.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <mutex>
#include <new>

namespace tetfusion {

namespace {

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kHeapOnly = true;
#elif defined(__has_feature)
constexpr bool kHeapOnly = __has_feature(address_sanitizer);
#else
constexpr bool kHeapOnly = false;
#endif

constexpr std::align_val_t kHeapAlignment{64};
constexpr std::size_t kHugePage = std::size_t{2} << 20;
constexpr std::size_t kMostBytes = static_cast<std::size_t>(-1) - 2 * kHugePage;

std::size_t rounded_up(std::size_t bytes, std::size_t to) { return (bytes + to - 1) / to * to; }

std::size_t whole_pages(std::size_t bytes) {
  static const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  return rounded_up(bytes, page);
}

// `bytes` of whole huge pages, beginning where one does.
std::byte* map_huge_pages(std::size_t bytes) {
  void* const mapped = ::mmap(nullptr, bytes + kHugePage, PROT_READ | PROT_WRITE,
                              MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (mapped == MAP_FAILED) throw std::bad_alloc();
  auto* const all = static_cast<std::byte*>(mapped);
  const auto address = reinterpret_cast<std::size_t>(all);
  const std::size_t before = rounded_up(address, kHugePage) - address;
  if (before > 0) ::munmap(all, before);
  if (before < kHugePage) ::munmap(all + before + bytes, kHugePage - before);
  // A hint: failure changes nothing but speed.
  ::madvise(all + before, bytes, MADV_HUGEPAGE);
  return all + before;
}

class PagePool {
 public:
  std::byte* allocate(std::size_t bytes) {
    const std::size_t size = whole_pages(bytes);
    const std::lock_guard lock(mutex_);
    if (std::byte* spare = take_spare(size)) return spare;
    const std::size_t mapped = rounded_up(size, kHugePage);
    std::byte* const block = map_huge_pages(mapped);
    keep(block + size, mapped - size);
    return block;
  }

  void free(std::byte* block, std::size_t bytes) noexcept {
    const std::size_t size = whole_pages(bytes);
    if (size > kMostSparePages) {
      ::munmap(block, size);
      return;
    }
    const std::lock_guard lock(mutex_);
    keep(block, size);
  }

  void free_spare() noexcept {
    const std::lock_guard lock(mutex_);
    for (const auto& [begin, size] : spare_) ::munmap(begin, size);
    spare_.clear();
    spare_bytes_ = 0;
  }

 private:
  using Ranges = std::map<std::byte*, std::size_t>;
  using Range = Ranges::value_type;

  // The beginning of the smallest that is large enough; null: there is none.
  std::byte* take_spare(std::size_t size) {
    auto best = spare_.end();
    for (auto it = spare_.begin(); it != spare_.end(); ++it) {
      if (it->second >= size && (best == spare_.end() || it->second < best->second)) best = it;
    }
    if (best == spare_.end()) return nullptr;
    const auto [begin, all] = *best;
    if (all > size) spare_.emplace_hint(best, begin + size, all - size);
    spare_.erase(best);
    spare_bytes_ -= size;
    return begin;
  }

  // Beyond the limit the smallest ranges go back to the system: they fit few blocks.
  void keep(std::byte* begin, std::size_t size) noexcept {
    if (size == 0) return;
    if (!add_spare(begin, size)) {
      ::munmap(begin, size);
      return;
    }
    while (spare_bytes_ > kMostSparePages) {
      const auto least =
          std::min_element(spare_.begin(), spare_.end(),
                           [](const Range& a, const Range& b) { return a.second < b.second; });
      ::munmap(least->first, least->second);
      spare_bytes_ -= least->second;
      spare_.erase(least);
    }
  }

  // False: there is no memory to note it.
  bool add_spare(std::byte* begin, std::size_t size) noexcept {
    Ranges::iterator at;
    try {
      at = spare_.emplace(begin, size).first;
    } catch (const std::bad_alloc&) {
      return false;
    }
    spare_bytes_ += size;
    if (const auto after = std::next(at); after != spare_.end() && begin + size == after->first) {
      at->second += after->second;
      spare_.erase(after);
    }
    if (at == spare_.begin()) return true;
    if (const auto before = std::prev(at); before->first + before->second == begin) {
      before->second += at->second;
      spare_.erase(at);
    }
    return true;
  }

  std::mutex mutex_;
  Ranges spare_;  // none beside another
  std::size_t spare_bytes_ = 0;
};

// Lives for ever: arrays that do may be freed after everything else.
PagePool& pool() {
  static PagePool& pool = *new PagePool;
  return pool;
}

}  // namespace

std::byte* allocate_pages(std::size_t bytes) {
  if (bytes > kMostBytes) throw std::bad_alloc();
  if (kHeapOnly) return static_cast<std::byte*>(::operator new(bytes, kHeapAlignment));
  return pool().allocate(bytes);
}

void free_pages(std::byte* block, std::size_t bytes) noexcept {
  if (kHeapOnly) return ::operator delete(block, kHeapAlignment);
  pool().free(block, bytes);
}

void free_spare_pages() noexcept { pool().free_spare(); }

}  // namespace tetfusion
