// Names in a sentence.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tetfusion {

// "a, b, c and 4 more": the first `most` of them, at least one.
std::string list_names(const std::vector<std::string>& names, std::size_t most);

}  // namespace tetfusion
