// VTK's readers trust counts and offsets in a file, and some damaged files crash them.
#pragma once

#include <functional>
#include <string>

namespace tetfusion {

// Runs `work` in a child process, where a crash does no harm and what libraries print is not seen,
// and forgets its result. An Error that `work` throws is thrown here, too; what else it throws is
// forgotten, as it will be thrown again when the caller does the same work itself. Where no child
// can be had, nothing is tried. Throws Error if the child was killed by a signal:
// kMemory for SIGKILL (the system was out of memory), kInterrupted for SIGINT and SIGTERM,
// otherwise kBadInput, as where a library ends the process.
void try_in_child(const std::string& path, const std::function<void()>& work);

}  // namespace tetfusion
