#include "refine/resident_limit.h"

#include <sys/resource.h>

#include <algorithm>

#include "base/resources.h"

namespace tetfusion {

namespace {

// Between two looks so much may be touched, which is a part of the caller's margin.
constexpr std::uint64_t kUnseen = std::uint64_t{8} << 20;
// A fault brings what the system has of the 64 kB around a page, or a huge page.
constexpr std::uint64_t kLeastOfFault = std::uint64_t{64} << 10;
constexpr std::uint64_t kMostOfFault = std::uint64_t{2} << 20;

std::uint64_t faults_so_far() {
  struct rusage usage {};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_minflt) + static_cast<std::uint64_t>(usage.ru_majflt);
}

}  // namespace

void ResidentLimit::keep(const std::function<void()>& let_go) {
  if (bytes_ == 0) return;
  const std::uint64_t faults = faults_so_far() - faults_;
  if (faults * of_fault_ < kUnseen) return;
  const std::uint64_t resident = current_rss_bytes();
  const std::uint64_t grown = resident - std::min(resident, resident_);
  of_fault_ = std::clamp(grown / faults, std::max(of_fault_ / 2, kLeastOfFault), kMostOfFault);
  faults_ += faults;
  resident_ = resident;
  if (resident <= bytes_) return;
  let_go();
  resident_ = current_rss_bytes();
}

}  // namespace tetfusion
