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
#include <vector>

#include "base/numbers.h"
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

// A hierarchy of control groups that is mounted: the folder shows `group` and what is below.
struct Hierarchy {
  std::string folder;
  std::string group;
  bool version2;
};

// proc/self/mountinfo: ID PARENT DEVICE GROUP FOLDER OPTIONS [FIELDS] - TYPE SOURCE OPTIONS
std::vector<Hierarchy> memory_hierarchies(const std::string& root) {
  std::vector<Hierarchy> hierarchies;
  std::ifstream file(root + "/proc/self/mountinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t dash = line.find(" - ");
    if (dash == std::string::npos) continue;
    std::string id, parent, device, group, folder, type, source, options;
    std::istringstream(line) >> id >> parent >> device >> group >> folder;
    std::istringstream(line.substr(dash + 3)) >> type >> source >> options;
    const std::vector<std::string> controllers = split(options, ',');
    const bool version2 = type == "cgroup2";
    const bool version1 = type == "cgroup" && std::find(controllers.begin(), controllers.end(),
                                                        "memory") != controllers.end();
    if (version1 || version2) hierarchies.push_back({root + folder, group, version2});
  }
  return hierarchies;
}

// The process's group in a hierarchy, from proc/self/cgroup: NUMBER:CONTROLLERS:GROUP
std::optional<std::string> own_group(const std::string& root, bool version2) {
  std::ifstream file(root + "/proc/self/cgroup");
  for (std::string line; std::getline(file, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string names = line.substr(first + 1, second - first - 1);
    const std::vector<std::string> controllers = split(names, ',');
    const bool found =
        version2 ? names.empty()
                 : std::find(controllers.begin(), controllers.end(), "memory") != controllers.end();
    if (found) return line.substr(second + 1);
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
  for (const Hierarchy& hierarchy : memory_hierarchies(root)) {
    std::string group = own_group(root, hierarchy.version2).value_or("/");
    // In a container the mount may show the process's group as its root: what lies below it counts.
    if (hierarchy.group != "/") {
      const bool inside = group == hierarchy.group || group.starts_with(hierarchy.group + "/");
      group = inside ? group.substr(hierarchy.group.size()) : "";
    }
    while (true) {
      limit = std::min(limit, limit_in(hierarchy.folder + group, hierarchy.version2));
      const std::size_t slash = group.rfind('/');
      if (slash == std::string::npos) break;
      group.resize(slash);
    }
  }
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
