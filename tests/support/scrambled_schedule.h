// Stands in the place of the order of work while it lives: tasks begin in a shuffled order, and
// some of them late.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <vector>

#include "base/schedule.h"

namespace tetfusion::testing {

class ScrambledSchedule : public Schedule {
 public:
  // The same seed shuffles alike; the delays fall differently each time.
  explicit ScrambledSchedule(std::uint64_t seed) : seed_(seed), before_(replace_schedule(this)) {}
  ~ScrambledSchedule() override { replace_schedule(before_); }
  ScrambledSchedule(const ScrambledSchedule&) = delete;
  ScrambledSchedule& operator=(const ScrambledSchedule&) = delete;

  std::size_t task(std::size_t turn, std::size_t tasks) override;
  void before(std::size_t task) override;

  std::uint64_t moved() const { return moved_; }  // tasks that began at another's turn

 private:
  std::uint64_t seed_;
  Schedule* before_;
  std::mutex mutex_;
  std::map<std::size_t, std::vector<std::size_t>> orders_;  // by the number of tasks
  std::atomic<std::uint64_t> moved_{0};
  std::atomic<std::uint64_t> begun_{0};
};

}  // namespace tetfusion::testing
