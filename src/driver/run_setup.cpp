#include "driver/run_setup.h"

#include <algorithm>
#include <limits>

#include "driver/request/error_limits.h"
#include "kernel/quadrics/vertex_quadrics.h"

namespace tetfusion {

namespace {

std::uint32_t quadric_width(const BehaviourOptions& behaviour, std::uint32_t steering_width) {
  if (behaviour.method != Method::kFuse) return 0;
  return quadric_row(steering_width, surfaces_move(behaviour));
}

}  // namespace

OpenOptions open_options(const SimplifyRequest& request, const std::string& spool_folder,
                         const RunContext& context) {
  const BehaviourOptions& b = request.behaviour;
  OpenOptions open{b.tetrahedralize, b.linearize, spool_folder, b.time_step};
  open.merge_points = b.merge_points;
  open.drop_patches = b.drop_patches;
  open.dropped_patches = b.dropped_patches;
  open.memory = request.performance.memory;
  open.cancelled = context.cancelled;
  return open;
}

bool surfaces_move(const BehaviourOptions& behaviour) {
  return behaviour.boundary != Boundary::kExact;
}

bool looks_at_result(const SimplifyRequest& request) {
  return request.verify || !request.map.empty();
}

bool keeps_numbers(const SimplifyRequest& request) {
  return !request.progressive.empty() || !request.map.empty();
}

ColumnsToFit columns_to_fit(const SimplifyRequest& request, const CarriedArrays& carried,
                            const std::vector<SteeringChoice>& choices,
                            const std::vector<std::size_t>& regions) {
  const BehaviourOptions& b = request.behaviour;
  ColumnsToFit columns;
  if (b.method != Method::kFuse || !b.fit_values || b.conserve || !request.progressive.empty()) {
    return columns;
  }
  const bool are_bounded = error_limits(b, tolerances_of(choices)).at_points;
  for (std::uint32_t c = 0; c < carried.point_indices.size(); ++c) {
    const bool is_promised =
        are_bounded && std::ranges::any_of(choices, [&](const SteeringChoice& choice) {
          return choice.association == Association::kPoint &&
                 choice.index == carried.point_indices[c];
        });
    if (is_float(carried.point_data.arrays[c].type) && !is_promised) columns.points.push_back(c);
  }
  const std::vector<std::uint32_t> labels = region_columns(carried, regions);
  for (std::uint32_t c = 0; c < carried.cell_indices.size(); ++c) {
    const bool is_label = std::ranges::find(labels, c) != labels.end();
    if (is_float(carried.cell_data.arrays[c].type) && !is_label) columns.cells.push_back(c);
  }
  // Where interfaces are as they were, a centre is in its region.
  if (surfaces_move(b)) columns.labels = labels;
  return columns;
}

MoveLimits move_limits(const BehaviourOptions& behaviour, const ColumnsToFit& columns,
                       std::span<const SteeringField> fields) {
  const BehaviourOptions& b = behaviour;
  const double off = std::numeric_limits<double>::infinity();
  const bool are_fitted = std::ranges::all_of(fields, [&](const SteeringField& field) {
    return std::ranges::find(columns.points, field.column) != columns.points.end();
  });
  const bool are_bounded = is_on(b.scalar_tolerance) || is_on(b.stretch_factor) ||
                           b.aspect_ratio != off || b.max_volume != off;
  if (!are_fitted || are_bounded || !b.weight.empty()) return {};
  return {
      {fields.begin(), fields.end()}, b.min_quality.value_or(kDefaultMinQuality), columns.labels};
}

SteeringBytes steering_bytes(const SimplifyRequest& request, const MeshDescription& mesh,
                             const std::vector<SteeringChoice>& choices,
                             const std::vector<std::size_t>& regions) {
  const BehaviourOptions& b = request.behaviour;
  const std::uint32_t width = components_of(choices, mesh);
  const std::uint64_t row = width * sizeof(double);
  std::uint64_t vertex = row;
  if (b.method == Method::kFuse) {
    vertex += (quadric_width(b, width) + (surfaces_move(b) ? 1 : 0)) * sizeof(float);
  }
  std::uint64_t means = 0;
  for (const SteeringChoice& c : choices) {
    if (c.association != Association::kCell) continue;
    means += mesh.cell_data.arrays[c.index].components * sizeof(double);
  }
  const CarriedArrays carried(mesh);
  const ColumnsToFit columns = columns_to_fit(request, carried, choices, regions);
  const auto bytes_of = [](const AttributeSet& set, const std::vector<std::uint32_t>& some) {
    std::uint64_t bytes = 0;
    for (const std::uint32_t c : some) {
      bytes += set.arrays[c].row_bytes();
    }
    return bytes;
  };
  const std::uint64_t cells = bytes_of(carried.cell_data, columns.cells);
  return {.vertex = vertex,
          .tet = keeps_numbers(request) ? sizeof(TetId) : 0,
          .removed_point = error_limits(b, tolerances_of(choices)).at_points ? row : 0,
          .point_aside = bytes_of(carried.point_data, columns.points),
          .point_mean = means,
          .cell_aside = cells == 0 ? 0 : cells + bytes_of(carried.cell_data, columns.labels),
          .positions_aside = surfaces_move(b) ? 2 : 1};
}

std::vector<std::uint32_t> region_columns(const CarriedArrays& carried,
                                          const std::vector<std::size_t>& regions) {
  std::vector<std::uint32_t> columns;
  for (const std::size_t i : regions) {
    if (const auto c = carried.column_of(Association::kCell, i)) columns.push_back(*c);
  }
  return columns;
}

template <class Real>
WorkMesh<Real> run_layout(const BehaviourOptions& behaviour, const CarriedArrays& carried,
                          std::uint32_t steering_width) {
  auto layout = layout_of<Real>(carried, steering_width);
  layout.quadric_width = quadric_width(behaviour, steering_width);
  layout.has_deviations = behaviour.method == Method::kFuse && surfaces_move(behaviour);
  return layout;
}

ImportSettings import_settings(const BehaviourOptions& behaviour, const CarriedArrays& carried,
                               const std::vector<std::size_t>& regions,
                               std::uint32_t steering_width) {
  ImportSettings settings;
  settings.chunk_tets = behaviour.chunk_tets;
  settings.quadric_width = quadric_width(behaviour, steering_width);
  settings.surfaces_move = surfaces_move(behaviour);
  const std::vector<std::uint32_t> columns = region_columns(carried, regions);
  settings.regions.assign(columns.begin(), columns.end());
  return settings;
}

std::vector<SteeringField> fields_of(const Steering& steering, const CarriedArrays& carried) {
  std::vector<SteeringField> fields = steering.fields();
  for (std::size_t f = 0; f < fields.size(); ++f) {
    const auto index = steering.point_array(f);
    if (!index) continue;
    fields[f].column = carried.column_of(Association::kPoint, *index).value_or(kNoColumn);
  }
  return fields;
}

template WorkMesh<float> run_layout(const BehaviourOptions&, const CarriedArrays&, std::uint32_t);
template WorkMesh<double> run_layout(const BehaviourOptions&, const CarriedArrays&, std::uint32_t);

}  // namespace tetfusion
