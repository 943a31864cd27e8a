// The whole command but for what belongs to the process: its signals, streams and memory.
#pragma once

namespace tetfusion {

// Runs the subcommand that the arguments name, says what went wrong on standard error, and returns
// the exit code. Throws nothing. Jobs use the process's threads: one call at a time.
int run_command_line(int argc, const char* const* argv) noexcept;

}  // namespace tetfusion
