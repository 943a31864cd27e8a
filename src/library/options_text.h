// The public options as a text, for languages that have no such struct.
#pragma once

#include <string_view>

#include "tetfusion.h"

namespace tetfusion {

// A JSON object as tetfusion_c.h says. Throws Error(kUsage).
Options read_options(std::string_view text);

// Is there a public option of that name?
bool is_option(std::string_view name);

}  // namespace tetfusion
