// A job on a thread of its own. The caller's thread waits, and is where the observer is called: so
// observers need no locks, and may belong to something that lives on one thread (an interpreter, a
// window).
#pragma once

#include <functional>

#include "base/run_context.h"
#include "tetfusion.h"

namespace tetfusion {

// Calls job(context) and returns when it has ended. What the job throws comes out here; so does
// Error(kInterrupted) where the observer throws, and where it asks for it before the turn of the
// job has come: jobs of a process run one after another.
void run_observed(const Observer& observer, const std::function<void(const RunContext&)>& job);

}  // namespace tetfusion
