#include "series/step_source.h"

#include <cstddef>
#include <utility>

#include "io/open_mesh.h"
#include "series/other_arrays.h"
#include "series/point_means.h"

namespace tetfusion {

StepFiles::StepFiles(const BehaviourOptions& behaviour, const SeriesPlan& plan, OpenOptions open)
    : behaviour_(behaviour), plan_(plan), open_(std::move(open)), was_read_(plan.steps.size()) {
  for (const Step& step : plan.steps) {
    for (const auto& [pattern, own] : step.arrays) of_steps_.insert(own);
  }
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
    if (!of_steps_.contains(name) || name == behaviour_.weight) {
      arrays.points.push_back(own_array(mesh, Association::kPoint, i));
    }
  }
  for (std::size_t i = 0; i < mesh.cell_data.arrays.size(); ++i) {
    arrays.cells.push_back(own_array(mesh, Association::kCell, i));
  }
  return with_arrays(std::move(file), std::move(arrays));
}

}  // namespace tetfusion
