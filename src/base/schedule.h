// The seam between pieces of work and the order in which they are done: run_tasks() and
// for_each_block() ask it, so that tests can scramble what usually comes in a row.
#pragma once

#include <cstddef>

namespace tetfusion {

// This class keeps the order; tests derive from it. Thread-safe.
class Schedule {
 public:
  virtual ~Schedule() = default;

  // Which task begins at this turn; over all turns in [0, tasks) each task once.
  virtual std::size_t task(std::size_t turn, std::size_t tasks);
  // On the thread of the task, before it begins: whoever takes long delays it.
  virtual void before(std::size_t task);
};

Schedule& schedule();

// For tests: puts another one in its place and returns the one before; nullptr means the order. Not
// while work is under way.
Schedule* replace_schedule(Schedule* other);

}  // namespace tetfusion
