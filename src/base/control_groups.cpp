#include "base/control_groups.h"

#include <algorithm>
#include <fstream>
#include <optional>
#include <sstream>
#include <vector>

#include "base/numbers.h"

namespace tetfusion {

namespace {

// A hierarchy of control groups that is mounted: the folder shows `group` and what is below.
struct Hierarchy {
  std::string folder;
  std::string group;
  bool version2;
};

bool is_among(const std::string& name, const std::vector<std::string>& names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// proc/self/mountinfo: ID PARENT DEVICE GROUP FOLDER OPTIONS [FIELDS] - TYPE SOURCE OPTIONS
std::vector<Hierarchy> hierarchies_with(const std::string& controller, const std::string& root) {
  std::vector<Hierarchy> hierarchies;
  std::ifstream file(root + "/proc/self/mountinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t dash = line.find(" - ");
    if (dash == std::string::npos) continue;
    std::string id, parent, device, group, folder, type, source, options;
    std::istringstream(line) >> id >> parent >> device >> group >> folder;
    std::istringstream(line.substr(dash + 3)) >> type >> source >> options;
    const bool version2 = type == "cgroup2";
    const bool version1 = type == "cgroup" && is_among(controller, split(options, ','));
    if (version1 || version2) hierarchies.push_back({root + folder, group, version2});
  }
  return hierarchies;
}

// The process's group in a hierarchy, from proc/self/cgroup: NUMBER:CONTROLLERS:GROUP
std::optional<std::string> own_group(const std::string& root, const std::string& controller,
                                     bool version2) {
  std::ifstream file(root + "/proc/self/cgroup");
  for (std::string line; std::getline(file, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string names = line.substr(first + 1, second - first - 1);
    const bool found = version2 ? names.empty() : is_among(controller, split(names, ','));
    if (found) return line.substr(second + 1);
  }
  return std::nullopt;
}

}  // namespace

void for_each_own_group(const std::string& root, const std::string& controller,
                        const std::function<void(const std::string& folder, bool version2)>& look) {
  for (const Hierarchy& hierarchy : hierarchies_with(controller, root)) {
    std::string group = own_group(root, controller, hierarchy.version2).value_or("/");
    // In a container the mount may show the process's group as its root: what lies below it counts.
    if (hierarchy.group != "/") {
      const bool inside = group == hierarchy.group || group.starts_with(hierarchy.group + "/");
      group = inside ? group.substr(hierarchy.group.size()) : "";
    }
    while (true) {
      look(hierarchy.folder + group, hierarchy.version2);
      const std::size_t slash = group.rfind('/');
      if (slash == std::string::npos) break;
      group.resize(slash);
    }
  }
}

}  // namespace tetfusion
