// Which cell arrays say what the mesh is made of: interfaces between materials stay.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/source/mesh_source.h"

namespace tetfusion {

// The cell arrays whose interfaces are kept: the named ones, of numbers of one component, or by
// default those of integers that look like regions (mesh/regions/region_names.h). Throws
// Error(kUsage) for a name that is none of these, which `option` gave.
std::vector<std::size_t> choose_regions(const MeshDescription& mesh,
                                        const std::optional<std::vector<std::string>>& names,
                                        std::string_view option = "--regions");

// The first of them; empty where none was.
std::string region_that_was_named(const std::optional<std::vector<std::string>>& names);

std::vector<std::string> names_of_cell_arrays(const MeshDescription& mesh,
                                              const std::vector<std::size_t>& arrays);

}  // namespace tetfusion
