#include "io/gmsh/gmsh_groups.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "base/name_list.h"

namespace tetfusion {

void PhysicalGroups::add(int dimension, const Tags& groups, std::uint64_t elements) {
  if (elements == 0) return;
  for (const std::int64_t tag : groups) elements_[{dimension, tag}] += elements;
  if (groups.size() > 1) several_[{dimension, groups}] += elements;
}

std::int64_t PhysicalGroups::choose(int dimension, const Tags& groups) const {
  const auto elements = [&](std::int64_t tag) {
    const auto found = elements_.find({dimension, tag});
    return found == elements_.end() ? 0 : found->second;
  };
  const auto least =
      std::min_element(groups.begin(), groups.end(),
                       [&](std::int64_t a, std::int64_t b) { return elements(a) < elements(b); });
  return least == groups.end() ? 0 : *least;
}

std::string PhysicalGroups::left_out(const std::vector<GmshName>& names) const {
  std::set<Group> losing;
  for (const auto& [key, elements] : several_) {
    const auto& [dimension, groups] = key;
    const std::int64_t kept = choose(dimension, groups);
    for (const std::int64_t tag : groups) {
      if (tag != kept) losing.insert({dimension, tag});
    }
  }
  std::vector<std::string> words;
  for (const Group& group : losing) {
    const auto named = std::find_if(names.begin(), names.end(), [&](const GmshName& name) {
      return name.dimension == group.first && name.tag == group.second;
    });
    const std::string word = named == names.end() ? std::to_string(group.second) : named->name;
    if (std::find(words.begin(), words.end(), word) == words.end()) words.push_back(word);
  }
  if (words.empty()) return "";
  constexpr std::size_t kMost = 8;
  return fmt::format("elements of the physical group{} {} that are in another one, too",
                     words.size() == 1 ? "" : "s", list_names(words, kMost));
}

}  // namespace tetfusion
