// The steps' files, and each step's mesh with the step's own arrays.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "io/source/mesh_source.h"
#include "series/series_plan.h"

namespace tetfusion {

// Safe to use from several threads. What it is made of outlives it.
class StepFiles {
 public:
  // `open`: how to open each of them, but for its time step and whether it was read.
  StepFiles(const BehaviourOptions& behaviour, const SeriesPlan& plan, OpenOptions open);

  std::size_t count() const { return plan_.steps.size(); }
  const Step& operator[](std::size_t step) const { return plan_.steps[step]; }
  bool are_one_mesh() const { return plan_.in_one_mesh(); }
  std::vector<std::string> labels() const { return labels_of(plan_); }

  // Where steps are arrays of one mesh, other steps' arrays are left out (but not the weights), and
  // the step's own ones have the names that hold {step}. Else it is the file itself, with arrays of
  // cells that steer as arrays of points (point_means.h). Throw what open_mesh() throws.
  std::unique_ptr<MeshSource> open(std::size_t step) const;
  std::unique_ptr<MeshSource> open_whole(std::size_t step) const;  // the file itself

 private:
  const BehaviourOptions& behaviour_;
  const SeriesPlan& plan_;
  const OpenOptions open_;
  std::unordered_set<std::string> of_steps_;  // the arrays of all steps, where they are one mesh
  mutable std::vector<std::atomic<bool>> was_read_;  // one for each step: OpenOptions::was_read
};

}  // namespace tetfusion
