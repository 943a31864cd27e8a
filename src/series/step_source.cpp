#include "series/step_source.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "io/open_mesh.h"
#include "series/other_arrays.h"
#include "series/point_means.h"

namespace tetfusion {

std::optional<std::string> pattern_of(const Step& step, const std::string& name) {
  for (const auto& [pattern, own] : step.arrays) {
    if (own == name) return pattern;
  }
  return std::nullopt;
}

std::unique_ptr<MeshSource> StepFiles::open_whole(std::size_t step) const {
  OpenOptions options = open_;
  options.time_step = plan_.steps[step].time_step;
  options.was_read = was_read_[step];
  auto source = open_mesh(plan_.steps[step].input, options);
  was_read_[step] = true;
  return source;
}

std::unique_ptr<MeshSource> StepFiles::open(std::size_t step) const {
  auto file = open_whole(step);
  if (!plan_.in_one_mesh()) {
    return with_point_means(std::move(file), behaviour_.arrays, open_.cancelled);
  }
  const MeshDescription& mesh = file->description();
  OtherArrays arrays;
  for (std::size_t i = 0; i < mesh.point_data.arrays.size(); ++i) {
    const std::string& name = mesh.point_data.arrays[i].name;
    if (const auto pattern = pattern_of(plan_.steps[step], name)) {
      arrays.points.push_back(own_array(mesh, Association::kPoint, i));
      arrays.points.back().info.name = *pattern;
    }
    const bool is_step =
        std::any_of(plan_.steps.begin(), plan_.steps.end(),
                    [&](const Step& other) { return pattern_of(other, name).has_value(); });
    if (!is_step || name == behaviour_.weight) {
      arrays.points.push_back(own_array(mesh, Association::kPoint, i));
    }
  }
  for (std::size_t i = 0; i < mesh.cell_data.arrays.size(); ++i) {
    arrays.cells.push_back(own_array(mesh, Association::kCell, i));
  }
  return with_arrays(std::move(file), std::move(arrays));
}

}  // namespace tetfusion
