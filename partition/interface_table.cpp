#include "partition/interface_table.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "partition/id_ranges.h"

namespace tetfusion {

InterfaceTable::InterfaceTable(std::vector<Vector<InterfaceReport>> parts) {
  std::size_t all = 0;
  for (const Vector<InterfaceReport>& part : parts) all += part.size();
  entries_.reserve(all);  // what is not written to takes no memory
  for_each_id_range(std::move(parts), [&](const Vector<InterfaceReport>& reports) {
    for (const InterfaceReport& report : reports) {
      if (entries_.empty() || entries_.back().id != report.id) {
        entries_.push_back(report);
        continue;
      }
      InterfaceReport& to = entries_.back();
      to.low = std::min(to.low, report.low);
      to.high = std::max(to.high, report.high);
      to.marks |= report.marks;
      to.touched |= report.touched;
    }
  });
  index();
}

void InterfaceTable::add_marks(const InterfaceTable& other) {
  auto from = other.entries_.begin();
  for (InterfaceReport& entry : entries_) {
    while (from != other.entries_.end() && from->id < entry.id) ++from;
    if (from != other.entries_.end() && from->id == entry.id) entry.marks |= from->marks;
  }
}

// About four entries for each place of the index.
void InterfaceTable::index() {
  begins_.clear();
  if (entries_.empty()) return;
  VertexId largest = 0;
  for (const InterfaceReport& entry : entries_) largest = std::max(largest, entry.id);
  shift_ = 0;
  constexpr int kMostShift = std::numeric_limits<VertexId>::digits - 1;
  while (shift_ < kMostShift && (largest >> shift_) >= entries_.size() / 4 + 1) ++shift_;
  begins_.assign((largest >> shift_) + std::size_t{2}, 0);
  for (const InterfaceReport& entry : entries_) ++begins_[(entry.id >> shift_) + std::size_t{1}];
  std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
}

const InterfaceReport* InterfaceTable::find(VertexId id) const {
  const InterfaceReport* first = entries_.data();
  const InterfaceReport* last = first + entries_.size();
  if (!begins_.empty()) {
    const std::size_t place = id >> shift_;
    if (place + 1 >= begins_.size()) return nullptr;
    last = first + begins_[place + 1];
    first += begins_[place];
  }
  first = std::lower_bound(first, last, id, [](const InterfaceReport& entry, VertexId wanted) {
    return entry.id < wanted;
  });
  return first != last && first->id == id ? first : nullptr;
}

}  // namespace tetfusion
