// The words of the public header, and those of the driver.
#pragma once

#include <string>

#include "driver/request/options.h"
#include "driver/request/report.h"
#include "io/source/mesh_source.h"
#include "io/source/mesh_view.h"
#include "mesh/data_array.h"
#include "tetfusion.h"

namespace tetfusion {

// Throws Error(kUsage) for options that the method has no use for; the driver looks at the others.
SimplifyRequest to_request(const Options& options);

// Throws Error(kUsage) for steering arrays that the mesh does not have. A request has them as
// texts, "cell:NAME:1%", in which a name with colons might be read otherwise.
void check_steering(const Options& options, const MeshDescription& mesh);

// Refers to the mesh's values. Throws Error(kBadInput).
MeshView to_view(const Mesh& mesh);

Report to_report(const SimplifyReport& report);

// "--max-error must be" is "max_error must be".
std::string in_words_of_library(const std::string& message);

ValueType to_value_type(Type type);
Type to_type(ValueType type);

}  // namespace tetfusion
