#include "mesh/geometry.h"

namespace tetfusion {

std::uint64_t point_count(const Points& points) {
  return std::visit([](const auto& p) { return static_cast<std::uint64_t>(p.size()); }, points);
}

ValueType point_type(const Points& points) {
  return std::holds_alternative<Vector<Vec3<float>>>(points) ? ValueType::kFloat32
                                                             : ValueType::kFloat64;
}

}  // namespace tetfusion
