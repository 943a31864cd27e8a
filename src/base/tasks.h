// Independent pieces of work on a few threads.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <utility>

namespace tetfusion {

// Calls work(task, worker) once for each task in [0, tasks), on up to `threads` threads, fewer
// where the system gives no more; worker is in [0, threads) and tells a thread's own scratch memory
// apart. Tasks begin in ascending order, unless a test has scrambled it (schedule.h). If some
// throw, no further task begins, and the exception of the lowest of them is thrown here when the
// others have ended; Abandoned only if no other kind was thrown.
void run_tasks(std::size_t tasks, int threads,
               const std::function<void(std::size_t task, std::size_t worker)>& work);

// The same for tasks that have loops of their own (base/blocks.h): those of a task get its share of
// thread_count(), so that all together use no more.
void run_tasks_with_loops(std::size_t tasks, int at_once,
                          const std::function<void(std::size_t task)>& work);

// Takes what tasks have made, in any order and from several threads, and hands it on in the order
// of the tasks, one at a time. What comes early waits.
template <class T>
class InOrder {
 public:
  explicit InOrder(std::function<void(T)> take) : take_(std::move(take)) {}
  void put(std::size_t task, T value) {
    const std::lock_guard lock(mutex_);
    waiting_.emplace(task, std::move(value));
    while (!waiting_.empty() && waiting_.begin()->first == next_) {
      auto first = waiting_.extract(waiting_.begin());
      ++next_;  // also if that throws: nothing is handed on twice
      take_(std::move(first.mapped()));
    }
  }

 private:
  std::mutex mutex_;
  std::function<void(T)> take_;
  std::map<std::size_t, T> waiting_;
  std::size_t next_ = 0;
};

}  // namespace tetfusion
