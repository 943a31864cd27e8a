// The first few ids of a kind.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tetfusion {

inline constexpr std::size_t kFirstIds = 5;

// Keeps the smallest few of the ids it is given, each once: the same ones in whatever order they
// come.
class FirstIds {
 public:
  void add(std::uint32_t id) {
    if (ids_.size() == kFirstIds && id >= ids_.back()) return;
    const auto at = std::lower_bound(ids_.begin(), ids_.end(), id);
    if (at != ids_.end() && *at == id) return;
    ids_.insert(at, id);
    if (ids_.size() > kFirstIds) ids_.pop_back();
  }
  void add(const FirstIds& other) {
    for (const std::uint32_t id : other.ids_) add(id);
  }
  const std::vector<std::uint32_t>& ids() const { return ids_; }

 private:
  std::vector<std::uint32_t> ids_;  // ascending
};

}  // namespace tetfusion
