// Which steps of a series have which arrays: outputs have those of their own step alone.
#pragma once

#include <cstddef>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "mesh/data_array.h"

namespace tetfusion {

class ArrayTally {
 public:
  explicit ArrayTally(std::size_t steps) : of_steps_(steps) {}

  // Of one step each; from several threads at once.
  void note(std::size_t step, const AttributeSet& point_data, const AttributeSet& cell_data);

  // Names those that not all steps have, with the first step that lacks them. `labels`: of the
  // steps.
  void say_what_is_missing(const std::vector<std::string>& labels, const RunContext& context) const;

 private:
  std::mutex mutex_;
  std::vector<std::set<std::string>> of_steps_;
};

}  // namespace tetfusion
