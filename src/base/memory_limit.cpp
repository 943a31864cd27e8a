// Resident memory and its limits, as the kernel's files tell them.
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>

#include "base/control_groups.h"
#include "base/page_pool.h"
#include "base/resources.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

// A file that holds one number. Nothing for "max", and for a file that is not there.
std::optional<std::uint64_t> read_number(const std::string& path) {
  std::ifstream file(path);
  std::uint64_t value = 0;
  if (!(file >> value)) return std::nullopt;
  return value;
}

// "KEY:   123 kB" in a file of such lines, in bytes.
std::optional<std::uint64_t> read_kilobytes(const std::string& path, std::string_view key) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(key) || line.substr(key.size(), 1) != ":") continue;
    std::istringstream rest(line.substr(key.size() + 1));
    std::uint64_t value = 0;
    if (rest >> value) return value * 1024;
  }
  return std::nullopt;
}

std::uint64_t limit_in(const std::string& folder, bool version2) {
  if (!version2) return read_number(folder + "/memory.limit_in_bytes").value_or(kNoLimit);
  // Above memory.high a process is not killed, but slowed down beyond use.
  return std::min(read_number(folder + "/memory.max").value_or(kNoLimit),
                  read_number(folder + "/memory.high").value_or(kNoLimit));
}

std::uint64_t limit_of_groups(const std::string& root) {
  std::uint64_t limit = kNoLimit;
  for_each_own_group(root, "memory", [&](const std::string& folder, bool version2) {
    limit = std::min(limit, limit_in(folder, version2));
  });
  return limit;
}

std::uint64_t own_limit() {
  std::uint64_t limit = kNoLimit;
  for (const auto resource : {RLIMIT_AS, RLIMIT_DATA}) {
    rlimit r{};
    if (::getrlimit(resource, &r) == 0 && r.rlim_cur != RLIM_INFINITY) {
      limit = std::min<std::uint64_t>(limit, r.rlim_cur);
    }
  }
  return limit;
}

std::uint64_t installed_memory() {
  const long pages = ::sysconf(_SC_PHYS_PAGES);
  const long page = ::sysconf(_SC_PAGESIZE);
  return static_cast<std::uint64_t>(std::max(pages, 1L)) * static_cast<std::uint64_t>(page);
}

}  // namespace

std::uint64_t memory_limit(const std::string& root) {
  const auto total = read_kilobytes(root + "/proc/meminfo", "MemTotal");
  return std::min({total ? *total : installed_memory(), limit_of_groups(root), own_limit()});
}

std::uint64_t memory_to_use(std::uint64_t asked) { return asked != 0 ? asked : memory_limit() / 2; }

std::uint64_t available_memory(const std::string& root) {
  const std::string file = root + "/proc/meminfo";
  const auto memory = read_kilobytes(file, "MemAvailable");
  return memory ? *memory + read_kilobytes(file, "SwapFree").value_or(0) : kNoLimit;
}

std::uint64_t written_memory(int process) {
  const std::string file = "/proc/" + std::to_string(process) + "/status";
  return read_kilobytes(file, "RssAnon").value_or(0) + read_kilobytes(file, "VmSwap").value_or(0);
}

// ru_maxrss is no substitute where there is no /proc but a bound: an exec inherits it.
std::uint64_t peak_rss_bytes() {
  if (const auto peak = read_kilobytes("/proc/self/status", "VmHWM")) return *peak;
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

std::uint64_t current_rss_bytes() {
  return read_kilobytes("/proc/self/status", "VmRSS").value_or(0);
}

void return_freed_memory() {
  // Fixed: the threshold that glibc adapts by itself rises to 32 MiB, and heaps then keep that
  // much.
  ::mallopt(M_MMAP_THRESHOLD, 1 << 20);
  ::mallopt(M_TRIM_THRESHOLD, 4 << 20);
}

void trim_memory() {
  free_spare_pages();
  // Where another allocator is in glibc's place, as a sanitizer's, nobody has set up glibc's heap
  // yet: the first call does, and not safely from several threads at once.
  static const int first = ::malloc_trim(0);
  static_cast<void>(first);
  ::malloc_trim(0);
}

}  // namespace tetfusion
