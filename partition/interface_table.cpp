#include "partition/interface_table.h"

#include <algorithm>
#include <utility>

#include "partition/id_ranges.h"
#include "partition/radix_sort.h"

namespace tetfusion {

InterfaceTable::InterfaceTable(Vector<InterfaceReport> reports) {
  radix_sort<32>(&reports, [](const InterfaceReport& r) { return r.id; });
  for (const InterfaceReport& report : reports) add(report);
}

InterfaceTable::InterfaceTable(std::vector<Vector<InterfaceReport>> parts) {
  std::size_t all = 0;
  for (const Vector<InterfaceReport>& part : parts) all += part.size();
  entries_.reserve(all);  // what is not written to takes no memory
  for_each_id_range(std::move(parts), [&](const Vector<InterfaceReport>& reports) {
    for (const InterfaceReport& report : reports) add(report);
  });
}

void InterfaceTable::add(const InterfaceReport& report) {
  if (entries_.empty() || entries_.back().id != report.id) {
    entries_.push_back(report);
    return;
  }
  InterfaceReport& to = entries_.back();
  to.low = std::min(to.low, report.low);
  to.high = std::max(to.high, report.high);
  to.marks |= report.marks;
  to.touched |= report.touched;
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
