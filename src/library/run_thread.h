// A job on a thread of its own. The caller's thread waits, and is where the observer is called: so
// observers need no locks, and may belong to something that lives on one thread (an interpreter, a
// window).
#pragma once

#include <functional>

#include "base/run_context.h"
#include "tetfusion.h"

namespace tetfusion {

// Calls job(context) and returns when it has ended. What the job throws comes out here; so does
// Error(kInterrupted) where the observer throws.
//
// Jobs of several threads go on at once. None may wait for another one: who waits may hold what the
// other's observer needs, as the lock of an interpreter.
void run_observed(const Observer& observer, const std::function<void(const RunContext&)>& job);

// How many go on now.
int runs_of_process();

}  // namespace tetfusion
