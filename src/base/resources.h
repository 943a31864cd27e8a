// Clocks, memory and the number of threads.
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace tetfusion {

double wall_seconds();  // monotonic, from an arbitrary start
double cpu_seconds();   // user and system time of the process, all threads

// The resident set, mapped pages counted: the largest so far (VmHWM), and now (VmRSS).
std::uint64_t peak_rss_bytes();
std::uint64_t current_rss_bytes();

// What the process may have resident at most: the machine's memory, or the smallest limit of its
// control groups (versions 1 and 2) up to their root, or its own limit (ulimit). `root` is where
// /proc and /sys lie, for tests.
std::uint64_t memory_limit(const std::string& root = "");

// Sets up the allocator so that large blocks go back to the system when they are freed, and a bound
// on memory can be kept. For the start of a program, before other threads.
void return_freed_memory();

// Gives back what small blocks have left. Takes milliseconds; for the end of a phase.
void trim_memory();

// Threads that loops and tasks use from now on. 0 means one a processor. Results never depend on
// it. Not to be called while any run.
void set_thread_count(int threads);
int thread_count();

// As long as it lives, loops that the calling thread begins use so many threads.
class LoopThreads {
 public:
  explicit LoopThreads(int threads);
  ~LoopThreads();
  LoopThreads(const LoopThreads&) = delete;
  LoopThreads& operator=(const LoopThreads&) = delete;

 private:
  int before_ = 0;
};

// How many a loop that the calling thread begins may use.
int loop_threads();

// Wall time by phase.
class PhaseClock {
 public:
  // Ends the running phase and begins another one; coming back to a phase adds to it.
  void begin(const std::string& phase);
  void end();
  // What was counted for one phase, or will be, is another's.
  void move(const std::string& from, const std::string& to, double seconds);
  const std::map<std::string, double>& seconds() const { return seconds_; }

 private:
  std::map<std::string, double> seconds_;
  std::string phase_;
  double since_ = 0;
};

}  // namespace tetfusion
