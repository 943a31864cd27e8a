// The names of arrays, for messages.
#pragma once

#include <string>

#include "mesh/data_array.h"

namespace tetfusion {

// "pressure, velocity", or "none".
std::string names_of(const AttributeSet& set);

}  // namespace tetfusion
