// Clocks, memory, processors and the number of threads.
#pragma once

#include <atomic>
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

// What a job may take: what was asked for, or, where that is 0, half of memory_limit().
std::uint64_t memory_to_use(std::uint64_t asked);

// What processes could take now before the system has to end one of them: memory that is free or
// soon would be, and swap space. The largest number where the system does not tell.
std::uint64_t available_memory(const std::string& root = "");

// What that process has of its own, in memory and swapped out: what it has written to, and nothing
// of what it has only asked for. 0 where the system does not tell.
std::uint64_t written_memory(int process);

// Sets up the allocator so that large blocks go back to the system when they are freed, and a bound
// on memory can be kept. For the start of a program, before other threads.
void return_freed_memory();

// Gives back what small blocks have left. Takes milliseconds; for the end of a phase.
void trim_memory();

// Processors that the process may use: those it is bound to (taskset, cpusets of batch systems),
// and no more than the smallest quota of its control groups (containers), rounded up. At least 1.
// `root` as above.
int available_processors(const std::string& root = "");

// Lets the calling thread run on all of OpenMP's places. Where OpenMP binds its threads
// (OMP_PROC_BIND) it binds the process's first one, too, and threads that are not OpenMP's inherit
// that one place.
void leave_openmp_place();

// Threads that loops and tasks use from now on. 0 means as many as the environment's
// OMP_NUM_THREADS says, or one for each available processor. Results never depend on it. Not to be
// called while any run.
void set_thread_count(int threads);
int thread_count();

// As long as it lives, the two are about the calling thread and those that run_tasks() starts from
// it, and no others: so runs that go on at once in a process need not agree on a number.
class OwnThreadCount {
 public:
  OwnThreadCount();
  ~OwnThreadCount();
  OwnThreadCount(const OwnThreadCount&) = delete;
  OwnThreadCount& operator=(const OwnThreadCount&) = delete;

 private:
  std::atomic<int> threads_{0};
  std::atomic<int>* before_ = nullptr;
};

// For those who start threads: what the calling thread takes its number from, and which to take it
// from. Whoever owns it must outlive the thread.
std::atomic<int>* place_of_thread_count();
void share_thread_count(std::atomic<int>* place);

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
