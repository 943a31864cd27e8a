#include "partition/interface_table.h"

#include <algorithm>

#include "partition/radix_sort.h"

namespace tetfusion {

InterfaceTable::InterfaceTable(Vector<InterfaceReport> reports) : entries_(std::move(reports)) {
  radix_sort<32>(&entries_, [](const InterfaceReport& r) { return r.id; });
  std::size_t last = 0;  // entries that are joined already, the last of them open
  for (std::size_t i = 1; i < entries_.size(); ++i) {
    const InterfaceReport& from = entries_[i];
    if (from.id != entries_[last].id) {
      entries_[++last] = from;
      continue;
    }
    InterfaceReport& to = entries_[last];
    to.low = std::min(to.low, from.low);
    to.high = std::max(to.high, from.high);
    to.marks |= from.marks;
    to.touched |= from.touched;
  }
  if (!entries_.empty()) entries_.resize(last + 1);
}

void InterfaceTable::add_marks(const InterfaceTable& other) {
  auto from = other.entries_.begin();
  for (InterfaceReport& entry : entries_) {
    while (from != other.entries_.end() && from->id < entry.id) ++from;
    if (from != other.entries_.end() && from->id == entry.id) entry.marks |= from->marks;
  }
}

const InterfaceReport* InterfaceTable::find(VertexId id) const {
  const auto it = std::lower_bound(
      entries_.begin(), entries_.end(), id,
      [](const InterfaceReport& entry, VertexId wanted) { return entry.id < wanted; });
  return it != entries_.end() && it->id == id ? &*it : nullptr;
}

}  // namespace tetfusion
