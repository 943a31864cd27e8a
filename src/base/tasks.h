// Independent pieces of work on a few threads.
#pragma once

#include <cstddef>
#include <functional>

namespace tetfusion {

// Calls work(task, worker) once for each task in [0, tasks), on up to `threads` threads; worker is
// in [0, threads) and tells a thread's own scratch memory apart. Tasks begin in ascending order. If
// some throw, no further task begins, and the exception of the lowest of them is thrown here when
// the others have ended.
void run_tasks(std::size_t tasks, int threads,
               const std::function<void(std::size_t task, std::size_t worker)>& work);

}  // namespace tetfusion
