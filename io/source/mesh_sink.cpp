#include "io/source/mesh_sink.h"

#include <limits>

namespace tetfusion {

ValueType id_type_for(const MeshLayout& layout, ValueType wanted) {
  const bool fits = layout.corners <= std::numeric_limits<std::int32_t>::max();
  return fits ? wanted : ValueType::kInt64;
}

}  // namespace tetfusion
