// Data-parallel loops over fixed blocks: what a block computes depends on its range alone, and the
// caller combines the blocks in order, so that the number of threads changes nothing.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <limits>

#include "base/schedule.h"

namespace tetfusion {

inline std::size_t block_count(std::size_t items, std::size_t block_size) {
  return (items + block_size - 1) / block_size;
}

// Calls f(block, begin, end) for each block of [0, items), in any order and from several threads.
// An exception does not leave the threads: blocks behind one that has thrown are left out, those
// before it are done, and then the lowest block's is thrown.
template <class F>
void for_each_block(std::size_t items, std::size_t block_size, F f) {
  const std::size_t blocks = block_count(items, block_size);
  std::exception_ptr error;
  std::atomic<std::size_t> error_block = std::numeric_limits<std::size_t>::max();
#pragma omp parallel for schedule(dynamic) if (blocks > 1)
  for (std::size_t turn = 0; turn < blocks; ++turn) {
    const std::size_t b = schedule().task(turn, blocks);
    if (b > error_block.load(std::memory_order_relaxed)) continue;
    schedule().before(b);
    try {
      const std::size_t begin = b * block_size;
      f(b, begin, begin + block_size < items ? begin + block_size : items);
    } catch (...) {
#pragma omp critical(tetfusion_block_error)
      if (b < error_block.load(std::memory_order_relaxed)) {
        error = std::current_exception();
        error_block.store(b, std::memory_order_relaxed);
      }
    }
  }
  if (error) std::rethrow_exception(error);
}

}  // namespace tetfusion
