// Memory for large blocks: the system's pages, huge ones where it has them. Freed, they go to the
// next block, up to a limit, and beyond it back to the system: the first touch of a new page costs
// more than copying what it holds. A heap would keep what lies between blocks that live: glibc's,
// as it is in a host that has not tamed it, all below 32 MiB, for each thread.
//
// Thread-safe. Under AddressSanitizer, which knows the heap only, blocks are the heap's.
#pragma once

#include <cstddef>

namespace tetfusion {

// So much of what was freed is kept, in bytes.
inline constexpr std::size_t kMostSparePages = std::size_t{16} << 20;

// At an address that is a multiple of 64; what is there is anything. Throws std::bad_alloc.
std::byte* allocate_pages(std::size_t bytes);

// `bytes` as they were allocated.
void free_pages(std::byte* block, std::size_t bytes) noexcept;

// What is kept goes back to the system.
void free_spare_pages() noexcept;

}  // namespace tetfusion
