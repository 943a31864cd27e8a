#include "base/tasks.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "base/error.h"
#include "base/resources.h"
#include "base/schedule.h"

namespace tetfusion {

void run_tasks(std::size_t tasks, int threads,
               const std::function<void(std::size_t task, std::size_t worker)>& work) {
  std::atomic<std::size_t> next{0};
  std::atomic<bool> failed{false};
  std::mutex mutex;
  std::exception_ptr error;
  bool error_is_reason = false;
  std::size_t error_task = tasks;
  const auto keep = [&](std::size_t task, bool is_reason) {
    const std::lock_guard lock(mutex);
    failed = true;
    if (is_reason == error_is_reason ? task >= error_task : error_is_reason) return;
    error_task = task;
    error_is_reason = is_reason;
    error = std::current_exception();
  };
  const auto run = [&](std::size_t worker) {
    while (!failed.load()) {
      const std::size_t turn = next.fetch_add(1);
      if (turn >= tasks) return;
      const std::size_t task = schedule().task(turn, tasks);
      schedule().before(task);
      try {
        work(task, worker);
      } catch (const Abandoned&) {
        keep(task, false);
      } catch (...) {
        keep(task, true);
      }
    }
  };
  const std::size_t workers = std::min(tasks, static_cast<std::size_t>(std::max(threads, 1)));
  std::vector<std::jthread> others;
  try {
    for (std::size_t worker = 1; worker < workers; ++worker) {
      others.emplace_back([&run, worker, count = place_of_thread_count()] {
        share_thread_count(count);
        leave_openmp_place();
        run(worker);
      });
    }
  } catch (const std::system_error&) {
    // The system gives no more threads: those that are there do the work.
  }
  run(0);
  others.clear();  // joins
  if (error) std::rethrow_exception(error);
}

void run_tasks_with_loops(std::size_t tasks, int at_once,
                          const std::function<void(std::size_t task)>& work) {
  run_tasks(tasks, at_once, [&](std::size_t task, std::size_t) {
    const LoopThreads share(std::max(1, thread_count() / std::max(1, at_once)));
    work(task);
  });
}

}  // namespace tetfusion
