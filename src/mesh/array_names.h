// The names of arrays.
#pragma once

#include <string>

#include "mesh/data_array.h"

namespace tetfusion {

// "pressure, velocity", or "none".
std::string names_of(const AttributeSet& set);

// Is it VTK's array of what is a copy of another piece's, or hidden?
bool is_ghost_mark(const std::string& name);

}  // namespace tetfusion
