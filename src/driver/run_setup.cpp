#include "driver/run_setup.h"

#include <algorithm>

#include "kernel/vertex_quadrics.h"

namespace tetfusion {

namespace {

std::uint32_t quadric_width(Method method, std::uint32_t steering_width) {
  return method == Method::kFuse ? quadric_row(steering_width) : 0;
}

}  // namespace

template <class Real>
WorkMesh<Real> run_layout(Method method, const CarriedArrays& carried,
                          std::uint32_t steering_width) {
  auto layout = layout_of<Real>(carried, steering_width);
  layout.quadric_width = quadric_width(method, steering_width);
  return layout;
}

ImportSettings import_settings(const BehaviourOptions& behaviour, const CarriedArrays& carried,
                               const std::vector<std::size_t>& regions,
                               std::uint32_t steering_width) {
  ImportSettings settings;
  settings.chunk_tets = behaviour.chunk_tets;
  settings.quadric_width = quadric_width(behaviour.method, steering_width);
  for (const std::size_t i : regions) {
    const auto at = std::find(carried.cell_indices.begin(), carried.cell_indices.end(), i);
    if (at == carried.cell_indices.end()) continue;
    settings.regions.push_back(static_cast<std::size_t>(at - carried.cell_indices.begin()));
  }
  return settings;
}

std::vector<SteeringField> fields_of(const Steering& steering, const CarriedArrays& carried) {
  std::vector<SteeringField> fields = steering.fields();
  const std::vector<std::size_t>& indices = carried.point_indices;
  for (std::size_t f = 0; f < fields.size(); ++f) {
    const auto index = steering.point_array(f);
    if (!index) continue;
    const auto at = std::find(indices.begin(), indices.end(), *index);
    fields[f].column = static_cast<std::uint32_t>(at - indices.begin());
  }
  return fields;
}

template WorkMesh<float> run_layout(Method, const CarriedArrays&, std::uint32_t);
template WorkMesh<double> run_layout(Method, const CarriedArrays&, std::uint32_t);

}  // namespace tetfusion
