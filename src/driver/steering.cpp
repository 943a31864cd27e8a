#include "driver/steering.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/numbers.h"
#include "mesh/predicates.h"

namespace tetfusion {

namespace {

std::string names_of(const AttributeSet& set) {
  std::string names;
  for (const ArrayInfo& a : set.arrays) names += (names.empty() ? "" : ", ") + a.name;
  return names.empty() ? "none" : names;
}

std::optional<SteeringChoice> find_choice(const MeshDescription& mesh, const std::string& name) {
  constexpr std::string_view kCellPrefix = "cell:";
  SteeringChoice choice;
  choice.name = name;
  choice.index = mesh.point_data.find(name);
  if (choice.index != AttributeSet::npos) return choice;
  if (name.starts_with(kCellPrefix)) {
    choice.association = Association::kCell;
    choice.index = mesh.cell_data.find(name.substr(kCellPrefix.size()));
    if (choice.index != AttributeSet::npos) return choice;
  }
  return std::nullopt;
}

SteeringChoice resolve(const MeshDescription& mesh, const std::string& text) {
  if (auto choice = find_choice(mesh, text)) return *choice;
  const std::size_t colon = text.rfind(':');
  if (colon != std::string::npos) {
    const auto tolerance = parse_share(text.substr(colon + 1));
    auto choice = find_choice(mesh, text.substr(0, colon));
    if (choice && tolerance && *tolerance > 0) {
      choice->tolerance = tolerance;
      return *choice;
    }
  }
  throw Error(
      ErrorCode::kUsage,
      fmt::format("{}: no array \"{}\" to steer by; point arrays: {}; cell arrays (name them "
                  "cell:NAME): {}",
                  mesh.path, text, names_of(mesh.point_data), names_of(mesh.cell_data)));
}

// Values of a point array at the geometry's points, as doubles.
void gather_points(const DataArray& array, const Geometry& geometry, std::uint32_t first,
                   Steering* steering) {
  const std::size_t points = point_count(geometry.points);
  const std::size_t components = array.info.components;
  visit_type(array.info.type, [&](auto zero) {
    const auto values = array.as<decltype(zero)>();
    for (std::size_t p = 0; p < points; ++p) {
      const std::size_t row = geometry.point_source.empty() ? p : geometry.point_source[p];
      for (std::size_t k = 0; k < components; ++k) {
        steering->values[p * steering->width + first + k] =
            static_cast<double>(values[row * components + k]);
      }
    }
  });
}

// Volume-weighted means of a cell array round each point.
void average_cells(const DataArray& array, const Geometry& geometry, std::uint32_t first,
                   Steering* steering) {
  const std::size_t points = point_count(geometry.points);
  const std::size_t components = array.info.components;
  const std::size_t width = steering->width;
  Vector<double> weight;
  weight.assign(points, 0.0);
  const auto add = [&](auto values, std::size_t t, double volume) {
    const std::size_t row = geometry.tet_source.empty() ? t : geometry.tet_source[t];
    for (const VertexId v : geometry.tets[t]) {
      weight[v] += volume;
      for (std::size_t k = 0; k < components; ++k) {
        steering->values[v * width + first + k] +=
            volume * static_cast<double>(values[row * components + k]);
      }
    }
  };
  visit_type(array.info.type, [&](auto zero) {
    const auto values = array.as<decltype(zero)>();
    std::visit(
        [&](const auto& positions) {
          for (std::size_t t = 0; t < geometry.tets.size(); ++t) {
            add(values, t, std::abs(determinant(positions, geometry.tets[t]).value));
          }
        },
        geometry.points);
  });
  for (std::size_t p = 0; p < points; ++p) {
    for (std::size_t k = 0; k < components; ++k) {
      steering->values[p * width + first + k] /= weight[p] > 0 ? weight[p] : 1;
    }
  }
}

// Scales a field's values by a power of two, so that its range lies between a half and one and no
// square overflows or vanishes, and returns the range; 0 when all values are the same. Marks the
// vertices where the field has no value.
double scale_to_range(std::uint32_t first, std::uint32_t count, Steering* steering) {
  const std::size_t points = steering->not_finite.size();
  double half_range = 0;  // a whole one may overflow
  for (std::uint32_t k = first; k < first + count; ++k) {
    double lo = std::numeric_limits<double>::infinity();
    double hi = -lo;
    for (std::size_t p = 0; p < points; ++p) {
      const double value = steering->values[p * steering->width + k];
      if (!std::isfinite(value)) {
        steering->not_finite[p] = 1;
        continue;
      }
      lo = std::min(lo, value);
      hi = std::max(hi, value);
    }
    if (hi > lo) half_range = std::hypot(half_range, hi / 2 - lo / 2);
  }
  if (!(half_range > 0)) return 0;
  int exponent = 0;
  const double range = std::frexp(half_range, &exponent);
  for (std::size_t p = 0; p < points; ++p) {
    double* tuple = steering->values.data() + p * steering->width;
    for (std::uint32_t k = first; k < first + count; ++k)
      tuple[k] = std::ldexp(tuple[k], -exponent - 1);
  }
  return range;
}

}  // namespace

std::vector<SteeringChoice> choose_steering(const MeshDescription& mesh,
                                            const std::vector<std::string>& names) {
  std::vector<SteeringChoice> choices;
  for (const std::string& name : names) choices.push_back(resolve(mesh, name));
  if (!choices.empty()) return choices;

  SteeringChoice choice;
  const auto scalars = mesh.point_data.active.find("Scalars");
  choice.index = scalars == mesh.point_data.active.end() ? AttributeSet::npos
                                                         : mesh.point_data.find(scalars->second);
  for (std::size_t i = 0; i < mesh.point_data.arrays.size() && choice.index == AttributeSet::npos;
       ++i) {
    if (is_float(mesh.point_data.arrays[i].type)) choice.index = i;
  }
  if (choice.index == AttributeSet::npos) return {};
  choice.name = mesh.point_data.arrays[choice.index].name;
  return {choice};
}

Steering load_steering(const std::vector<SteeringChoice>& choices, const Geometry& geometry,
                       const RunContext& context, MeshSource* source) {
  const MeshDescription& mesh = source->description();
  Steering steering;
  for (const SteeringChoice& c : choices) {
    const AttributeSet& set =
        c.association == Association::kCell ? mesh.cell_data : mesh.point_data;
    steering.width += set.arrays[c.index].components;
  }
  const std::size_t points = point_count(geometry.points);
  steering.values.assign(points * steering.width, 0.0);
  steering.not_finite.assign(points, 0);
  std::uint32_t first = 0;
  for (const SteeringChoice& c : choices) {
    context.check();
    const DataArray array = source->read_array(c.association, c.index);
    if (c.association == Association::kCell) {
      average_cells(array, geometry, first, &steering);
    } else {
      gather_points(array, geometry, first, &steering);
    }
    const std::uint32_t count = array.info.components;
    const double range = scale_to_range(first, count, &steering);
    if (range > 0) {
      steering.fields.push_back({first, count, range, c.tolerance});
      steering.names.push_back(c.name);
    } else {
      context.say(fmt::format("array {} has the same value everywhere: it does not steer", c.name));
    }
    first += count;
  }
  return steering;
}

}  // namespace tetfusion
