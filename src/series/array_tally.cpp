#include "series/array_tally.h"

#include <fmt/format.h>

#include <utility>

namespace tetfusion {

void ArrayTally::note(std::size_t step, const AttributeSet& point_data,
                      const AttributeSet& cell_data) {
  std::set<std::string> names;
  for (const ArrayInfo& array : point_data.arrays) {
    if (!array.steers_only) names.insert(array.name);
  }
  for (const ArrayInfo& array : cell_data.arrays) names.insert("cell:" + array.name);
  const std::lock_guard lock(mutex_);
  of_steps_[step] = std::move(names);
}

void ArrayTally::say_what_is_missing(const std::vector<std::string>& labels,
                                     const RunContext& context) const {
  std::set<std::string> all;
  for (const auto& names : of_steps_) all.insert(names.begin(), names.end());
  std::string text;
  for (const std::string& name : all) {
    std::size_t lacking = 0, first = 0;
    for (std::size_t i = of_steps_.size(); i-- > 0;) {
      if (of_steps_[i].contains(name)) continue;
      ++lacking;
      first = i;
    }
    if (lacking == 0) continue;
    text += fmt::format("{}{} (not in step {}{})", text.empty() ? "" : ", ", name, labels[first],
                        lacking > 1 ? fmt::format(" and {} others", lacking - 1) : "");
  }
  if (!text.empty()) context.say("arrays that not all steps have: " + text);
}

}  // namespace tetfusion
