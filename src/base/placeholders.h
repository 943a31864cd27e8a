// What stands for a label, or a number, in the names of several files or arrays.
#pragma once

#include <string>
#include <string_view>

namespace tetfusion {

inline constexpr std::string_view kStepField = "{step}";  // of a series
inline constexpr std::string_view kLodField = "{lod}";    // the number of a level

// The text with the value in the place of each such field, which the value does not hold.
std::string with_field(std::string text, std::string_view field, std::string_view value);

}  // namespace tetfusion
