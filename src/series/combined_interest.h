// Where the steps of a series together are in a region of interest by the values of an array.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "compare/original_mesh.h"
#include "io/source/mesh_stream.h"
#include "series/other_arrays.h"

namespace tetfusion {

// A point is inside if it is in some step. In memory is a bit for each point.
class CombinedInterest {
 public:
  // Of the texts (mesh/regions/region_of_interest.h) those that go by values; the others are left
  // to whoever has the places. `first` is a step's mesh, `points` how many its stream has. Throws
  // Error(kUsage) where a text is wrong.
  CombinedInterest(const std::vector<std::string>& texts, const MeshDescription& first,
                   std::uint64_t points);

  bool empty() const { return by_values_.empty(); }

  // Each step once, from several threads at once, in any order. Throws Error(kUsage) where it has
  // not the arrays.
  void add(const MeshDescription& mesh, const MeshStream& stream, const RunContext& context);

  // After all steps: the texts for a mesh that has this array in place of theirs. It only steers,
  // and reads what is here.
  std::vector<std::string> texts() const;
  ArrayFrom array() const;

 private:
  std::vector<std::string> by_values_, by_place_;
  PointSet inside_;
  std::mutex mutex_;  // for inside_
};

}  // namespace tetfusion
