// Comparing meshes that a test has made.
#pragma once

#include <string>
#include <string_view>

#include "compare/compare.h"
#include "support/mesh_file.h"

namespace tetfusion::testing {

// Writes both meshes to files and compares these.
Comparison compare_files(const MeshFile& original, const MeshFile& simplified);

// Throws where there is none of that name.
const ArrayComparison& array_of(const Comparison& comparison, std::string_view name);

// All numbers of a comparison, to the last bit.
std::string describe(const Comparison& comparison);

}  // namespace tetfusion::testing
