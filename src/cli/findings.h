// What is odd about a mesh, in words and as JSON: for `check` and `info`.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "driver/request/report_json.h"
#include "mesh/inspection/inspection_summary.h"
#include "mesh/quality.h"

namespace tetfusion {

using Json = nlohmann::ordered_json;

enum class Severity : std::uint8_t { kNote, kWarning, kFailure };

struct Finding {
  std::string_view key;    // in JSON
  std::string_view label;  // for people
  Severity severity;
  std::uint64_t count;
  std::string_view sample_kind;               // "cells" or "points"
  std::vector<std::uint64_t> samples;         // the first few, as the file counts them
  std::vector<std::array<double, 3>> places;  // where they are
  std::string remark = {};                    // for people, where there are no samples
};

// All kinds, those that were not found too, the gravest first. `point_data` is the mesh's.
std::vector<Finding> list_findings(const InspectionSummary& mesh, const AttributeSet& point_data);

// "cells 3, 17, 18, ...; the first at (0.5, 1, 2)"; without samples the remark.
std::string describe_samples(const Finding& finding);

// "All cells are wound ..." or "12 cells are ..."; empty if none is.
std::string describe_winding(const InspectionSummary& mesh);

Json counts_json(const InspectionSummary& mesh);  // sizes, boundary, volume, box
// Array and share, or null.
Json difference_json(const LargestDifference& largest, const AttributeSet& point_data);
Json findings_json(const std::vector<Finding>& findings);  // key: count, and "samples"
Json quality_json(const Quality& quality);
// Time since `start`, of the wall and of processors, memory and threads, to the end of a report.
void add_resources(double start, Json* report);

}  // namespace tetfusion
