// Clocks, peak memory and the number of threads.
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace tetfusion {

double wall_seconds();           // monotonic, from an arbitrary start
double cpu_seconds();            // user and system time of the process, all threads
std::uint64_t peak_rss_bytes();  // VmHWM: the largest resident set so far, mapped pages counted

// Threads that loops and tasks use from now on. 0 means one a processor. Results never depend on
// it. Not to be called while any run.
void set_thread_count(int threads);
int thread_count();

// Wall time by phase.
class PhaseClock {
 public:
  // Ends the running phase and begins another one; coming back to a phase adds to it.
  void begin(const std::string& phase);
  void end();
  const std::map<std::string, double>& seconds() const { return seconds_; }

 private:
  std::map<std::string, double> seconds_;
  std::string phase_;
  double since_ = 0;
};

}  // namespace tetfusion
