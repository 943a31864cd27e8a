// The version of the program.
#pragma once

#include <string>

namespace tetfusion {

std::string version();  // "0.1.0"

}  // namespace tetfusion
