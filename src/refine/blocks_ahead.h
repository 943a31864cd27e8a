// The blocks of a progressive file, one after another.
#pragma once

#include <cstddef>
#include <future>
#include <system_error>

#include "base/resources.h"
#include "io/progressive/progressive_file.h"

namespace tetfusion {

// While somebody works on a block, the next one is inflated by another thread, if there may be one.
// What is wrong with a block is thrown by the take() that asks for it.
class BlocksAhead {
 public:
  // The file must outlive this.
  explicit BlocksAhead(const ProgressiveFile& file) : file_(file) {}

  // The next one. There must be one.
  FusionBlock take() {
    FusionBlock block = ahead_.valid() ? ahead_.get() : file_.block(next_);
    ++next_;
    if (next_ < file_.blocks() && thread_count() > 1) {
      try {
        ahead_ = std::async(std::launch::async, [this, b = next_] { return file_.block(b); });
      } catch (const std::system_error&) {
        // No thread to be had: then it is inflated when it is wanted.
      }
    }
    return block;
  }

 private:
  const ProgressiveFile& file_;
  std::size_t next_ = 0;
  std::future<FusionBlock> ahead_;  // waits for its thread when it goes
};

}  // namespace tetfusion
