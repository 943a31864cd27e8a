#include "base/resources.h"

#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <optional>
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

namespace {
std::atomic<int> threads_of_process{0};  // 0: not chosen yet
thread_local std::atomic<int>* threads_in_use = &threads_of_process;

// As OpenMP reads it: "4", or "4,2" with a number for each level of nested loops, of which the
// first is meant.
std::optional<int> threads_of_environment() {
  const char* text = std::getenv("OMP_NUM_THREADS");
  if (text == nullptr) return std::nullopt;
  const int threads = std::atoi(text);
  return threads > 0 ? std::optional(threads) : std::nullopt;
}

int default_threads() {
  if (const auto threads = threads_of_environment()) return *threads;
  return available_processors();
}
}  // namespace

void set_thread_count(int threads) {
  *threads_in_use = threads > 0 ? threads : default_threads();
#ifdef _OPENMP
  omp_set_num_threads(thread_count());
#endif
}

int thread_count() {
  if (const int threads = *threads_in_use; threads > 0) return threads;
  return default_threads();
}

OwnThreadCount::OwnThreadCount() : before_(threads_in_use) { threads_in_use = &threads_; }
OwnThreadCount::~OwnThreadCount() { threads_in_use = before_; }

std::atomic<int>* place_of_thread_count() { return threads_in_use; }
void share_thread_count(std::atomic<int>* place) { threads_in_use = place; }

LoopThreads::LoopThreads([[maybe_unused]] int threads) {
#ifdef _OPENMP
  before_ = omp_get_max_threads();
  omp_set_num_threads(threads);
#endif
}

LoopThreads::~LoopThreads() {
#ifdef _OPENMP
  omp_set_num_threads(before_);
#endif
}

int loop_threads() {
#ifdef _OPENMP
  return omp_get_max_threads();
#else
  return 1;
#endif
}

void PhaseClock::begin(const std::string& phase) {
  end();
  phase_ = phase;
  since_ = wall_seconds();
}

void PhaseClock::move(const std::string& from, const std::string& to, double seconds) {
  seconds_[from] -= seconds;
  seconds_[to] += seconds;
}

void PhaseClock::end() {
  if (!phase_.empty()) seconds_[phase_] += wall_seconds() - since_;
  phase_.clear();
}

}  // namespace tetfusion
