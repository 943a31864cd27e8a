#include "mesh/geometry.h"

namespace tetfusion {

std::uint64_t point_count(const Points& points) {
  return std::visit([](const auto& p) { return static_cast<std::uint64_t>(p.size()); }, points);
}

ValueType point_type(const Points& points) {
  return std::holds_alternative<Vector<Vec3<float>>>(points) ? ValueType::kFloat32
                                                             : ValueType::kFloat64;
}

void LowerCells::add(std::uint8_t type, std::span<const VertexId> corners) {
  if (offsets.empty()) offsets.push_back(0);
  types.push_back(type);
  connectivity.insert(connectivity.end(), corners.begin(), corners.end());
  offsets.push_back(connectivity.size());
}

void LowerCells::add(const LowerCells& others) {
  if (others.size() == 0) return;
  if (offsets.empty()) offsets.push_back(0);
  const std::uint64_t before = connectivity.size();
  for (std::size_t i = 1; i < others.offsets.size(); ++i) {
    offsets.push_back(before + others.offsets[i]);
  }
  types.insert(types.end(), others.types.begin(), others.types.end());
  connectivity.insert(connectivity.end(), others.connectivity.begin(), others.connectivity.end());
}

}  // namespace tetfusion
