// Reports as JSON values, for whoever puts them into larger ones, and as text.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <string>

#include "driver/request/report.h"

namespace tetfusion {

nlohmann::ordered_json to_json_value(const SimplifyReport& report);

// As all reports are written: bytes that are no UTF-8 are replaced, as in names of files; numbers
// that are not finite are null.
std::string dump(const nlohmann::ordered_json& json);

}  // namespace tetfusion
