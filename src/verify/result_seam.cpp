#include "verify/result_seam.h"

#include <atomic>

namespace tetfusion {

namespace {

ResultSeam usual;
std::atomic<ResultSeam*> current{&usual};

}  // namespace

void ResultSeam::written(const std::string&) {}

ResultSeam& result_seam() { return *current.load(std::memory_order_acquire); }

ResultSeam* replace_result_seam(ResultSeam* other) {
  return current.exchange(other != nullptr ? other : &usual);
}

}  // namespace tetfusion
