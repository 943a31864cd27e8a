#include "base/tasks.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace tetfusion {

void run_tasks(std::size_t tasks, int threads,
               const std::function<void(std::size_t task, std::size_t worker)>& work) {
  std::atomic<std::size_t> next{0};
  std::atomic<bool> failed{false};
  std::mutex mutex;
  std::exception_ptr error;
  std::size_t error_task = tasks;
  const auto run = [&](std::size_t worker) {
    while (!failed.load()) {
      const std::size_t task = next.fetch_add(1);
      if (task >= tasks) return;
      try {
        work(task, worker);
      } catch (...) {
        const std::lock_guard lock(mutex);
        failed = true;
        if (task < error_task) {
          error_task = task;
          error = std::current_exception();
        }
      }
    }
  };
  const std::size_t workers = std::min(tasks, static_cast<std::size_t>(std::max(threads, 1)));
  std::vector<std::jthread> others;
  for (std::size_t worker = 1; worker < workers; ++worker) others.emplace_back(run, worker);
  run(0);
  others.clear();  // joins
  if (error) std::rethrow_exception(error);
}

}  // namespace tetfusion
