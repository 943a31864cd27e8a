// The exception type of the project. A message says what is wrong, where, and what to do.
#pragma once

#include <stdexcept>
#include <string>

namespace tetfusion {

// The values are the command's exit codes.
enum class ErrorCode : int {
  kBroken = 1,          // a mesh is not valid, or a result not what was promised
  kUsage = 2,           // the options do not make sense
  kBadInput = 3,        // the input file is not what it should be
  kIo = 4,              // reading or writing failed
  kMemory = 5,          // the memory budget is too small for the job
  kGoalNotReached = 6,  // the goal was not reached, and had to be
  kInterrupted = 130    // stopped by the user
};

class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ErrorCode code() const { return code_; }
  int exit_code() const { return static_cast<int>(code_); }

 private:
  ErrorCode code_;
};

// The file can be read, but what it describes is no mesh: a vertex id out of range, a coordinate
// that is not finite. For most jobs bad input like any other; for `check` it is the answer.
class InvalidMesh : public Error {
 public:
  explicit InvalidMesh(const std::string& message) : Error(ErrorCode::kBadInput, message) {}
};

// Thrown in work that was given up because other work had failed: never the reason of a failure,
// and never what a user reads (run_tasks() prefers any other error).
class Abandoned : public Error {
 public:
  Abandoned() : Error(ErrorCode::kInterrupted, "given up, because other work failed") {}
};

// For options and names that cannot be.
[[noreturn]] inline void refuse(const std::string& message) {
  throw Error(ErrorCode::kUsage, message);
}

}  // namespace tetfusion
