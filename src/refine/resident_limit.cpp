#include "refine/resident_limit.h"

#include <sys/resource.h>

#include "base/resources.h"

namespace tetfusion {

namespace {

// A fault brings a page, or with it what the system has of the 64 kB around it.
constexpr std::uint64_t kFaults = 128;

std::uint64_t faults_so_far() {
  struct rusage usage {};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_minflt) + static_cast<std::uint64_t>(usage.ru_majflt);
}

}  // namespace

void ResidentLimit::keep(const std::function<void()>& let_go) {
  if (bytes_ == 0) return;
  const std::uint64_t faults = faults_so_far();
  if (faults - faults_ < kFaults) return;
  faults_ = faults;
  if (current_rss_bytes() > bytes_) let_go();
}

}  // namespace tetfusion
