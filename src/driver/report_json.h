// A report as a JSON value, for whoever puts it into a larger one.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "driver/report.h"

namespace tetfusion {

nlohmann::ordered_json to_json_value(const SimplifyReport& report);

}  // namespace tetfusion
