#include "base/resources.h"

#include <sys/resource.h>

#include <chrono>
#ifdef _OPENMP
#include <omp.h>
#endif

namespace tetfusion {

double wall_seconds() {
  using Clock = std::chrono::steady_clock;
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

namespace {
rusage usage() {
  rusage u{};
  ::getrusage(RUSAGE_SELF, &u);
  return u;
}
double seconds(const timeval& t) {
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}
}  // namespace

double cpu_seconds() {
  const rusage u = usage();
  return seconds(u.ru_utime) + seconds(u.ru_stime);
}

std::uint64_t peak_rss_bytes() { return static_cast<std::uint64_t>(usage().ru_maxrss) * 1024; }

#ifdef _OPENMP
void set_thread_count(int threads) {
  omp_set_num_threads(threads > 0 ? threads : omp_get_num_procs());
}
int thread_count() { return omp_get_max_threads(); }
#else
void set_thread_count(int) {}
int thread_count() { return 1; }
#endif

void PhaseClock::begin(const std::string& phase) {
  end();
  phase_ = phase;
  since_ = wall_seconds();
}

void PhaseClock::end() {
  if (!phase_.empty()) seconds_[phase_] += wall_seconds() - since_;
  phase_.clear();
}

}  // namespace tetfusion
