#include "support/scrambled_schedule.h"

#include <algorithm>
#include <chrono>
#include <numeric>
#include <random>
#include <thread>

namespace tetfusion::testing {

std::size_t ScrambledSchedule::task(std::size_t turn, std::size_t tasks) {
  const std::lock_guard lock(mutex_);
  std::vector<std::size_t>& order = orders_[tasks];
  if (order.empty()) {
    order.resize(tasks);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::shuffle(order.begin(), order.end(), std::mt19937_64(seed_));
  }
  if (order[turn] != turn) ++moved_;
  return order[turn];
}

// One task in eight, which one is decided by how many have begun on all threads.
void ScrambledSchedule::before(std::size_t) {
  const std::uint64_t mixed = (++begun_ + seed_) * 0x9E3779B97F4A7C15u;
  if (mixed >> 61 == 0) std::this_thread::sleep_for(std::chrono::microseconds(mixed >> 50 & 1023));
}

}  // namespace tetfusion::testing
