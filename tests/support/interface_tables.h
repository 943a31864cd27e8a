// Interface tables of a list of reports.
#pragma once

#include <utility>
#include <vector>

#include "partition/id_ranges.h"
#include "partition/interface_table.h"

namespace tetfusion::testing {

// In any order.
inline InterfaceTable table_of(Vector<InterfaceReport> reports) {
  sort_by_id(&reports);
  std::vector<Vector<InterfaceReport>> parts;
  parts.push_back(std::move(reports));
  return InterfaceTable(std::move(parts));
}

}  // namespace tetfusion::testing
