#include "base/version.h"

namespace tetfusion {

std::string version() { return TETFUSION_VERSION; }

}  // namespace tetfusion
