// Which processors the process may use, as OpenMP and the kernel tell it.
#include <sched.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <thread>
#include <vector>
#ifdef _OPENMP
#include <omp.h>
#endif

#include "base/control_groups.h"
#include "base/resources.h"

namespace tetfusion {

namespace {

// Those the process is bound to, even where OpenMP has bound the calling thread to one of them.
int bound_processors() {
#ifdef _OPENMP
  return omp_get_num_procs();
#else
  return static_cast<int>(std::thread::hardware_concurrency());
#endif
}

// Processors' time over time, as a group may use it: "QUOTA PERIOD" in one file, or a file for
// each. Infinite where there is no quota ("max", or -1).
double quota_in(const std::string& folder, bool version2) {
  double quota = -1;
  double period = 0;
  if (version2) {
    std::ifstream(folder + "/cpu.max") >> quota >> period;
  } else {
    std::ifstream(folder + "/cpu.cfs_quota_us") >> quota;
    std::ifstream(folder + "/cpu.cfs_period_us") >> period;
  }
  return quota > 0 && period > 0 ? quota / period : std::numeric_limits<double>::infinity();
}

}  // namespace

int available_processors(const std::string& root) {
  double processors = bound_processors();
  for_each_own_group(root, "cpu", [&](const std::string& folder, bool version2) {
    processors = std::min(processors, std::ceil(quota_in(folder, version2)));
  });
  return std::max(1, static_cast<int>(processors));
}

void leave_openmp_place() {
#ifdef _OPENMP
  const int places = omp_get_num_places();
  if (omp_get_proc_bind() == omp_proc_bind_false || places == 0) return;
  std::vector<int> all;
  for (int place = 0; place < places; ++place) {
    const std::size_t before = all.size();
    all.resize(before + static_cast<std::size_t>(omp_get_place_num_procs(place)));
    omp_get_place_proc_ids(place, all.data() + before);
  }
  const int largest = *std::max_element(all.begin(), all.end());
  cpu_set_t* set = CPU_ALLOC(largest + 1);
  if (set == nullptr) return;
  const std::size_t bytes = CPU_ALLOC_SIZE(largest + 1);
  CPU_ZERO_S(bytes, set);
  for (const int processor : all) CPU_SET_S(processor, bytes, set);
  ::sched_setaffinity(0, bytes, set);  // else the thread stays where it is
  CPU_FREE(set);
#endif
}

}  // namespace tetfusion
