// VTK's readers trust counts and offsets in a file: some damaged files crash them, or let them take
// memory, or run, without end.
#pragma once

#include <functional>
#include <string>

#include "base/error.h"
#include "io/source/mesh_source.h"

namespace tetfusion {

// Runs `work` in a child process, where a crash does no harm and what libraries print is not seen,
// and forgets its result. What `work` throws is thrown here, too, as an Error; only an InvalidMesh
// is forgotten, as it will be thrown again when the caller does the same work itself. Where no
// child can be had, nothing is tried.
//
// The child ends when it has written to more memory than options.memory lets it, or, where that is
// 0, than the machine has to spare (Error(kMemory); where the system does not tell what it has
// written to, nothing bounds it), when options.cancelled becomes true (Error(kInterrupted)), and
// with this process. Throws Error if it was killed by a signal: kMemory for SIGKILL (the system was
// out of memory), kInterrupted for SIGHUP, SIGINT and SIGTERM, otherwise kBadInput, as where a
// library ends the process.
void try_in_child(const std::string& path, const OpenOptions& options,
                  const std::function<void()>& work);

// The exception that is being handled as an Error, for a catch (...). One of a C++ library says in
// its own words which of its functions was called wrongly: what that means for the file is said.
Error caught_error(const std::string& path);

}  // namespace tetfusion
