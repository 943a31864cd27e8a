// Judges what a simplification did, without the program's own code: what was promised for the
// options of a case, with exact signs, by brute force.
#pragma once

#include <string>
#include <vector>

#include "case.h"

namespace corpus {

// A sentence for each promise that is broken; each begins with a word for its kind and a colon.
std::vector<std::string> judge(const Case& c, const Mesh& result);

}  // namespace corpus
