// What the steps of a series together say about which region a cell is in.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/run_context.h"
#include "io/files/paged_array.h"
#include "io/source/mesh_stream.h"

namespace tetfusion {

// Cells that some step tells apart are told apart: each has a label made of all steps' values (64
// bits, mixed: two pairs of neighbours in 2^64 would be taken for one region). Labels lie on the
// disk, eight bytes a cell and array.
class CombinedRegions {
 public:
  // `names`: the cell arrays that are regions, as BehaviourOptions::regions has them; outlives
  // this.
  CombinedRegions(std::string folder, std::uint64_t cells,
                  const std::optional<std::vector<std::string>>& names)
      : folder_(std::move(folder)), cells_(cells), names_(names) {}

  // Each step, number 0 before all others; these from several threads at once, in any order. One
  // that has not the array says nothing.
  void add(std::uint64_t step, const MeshDescription& mesh, const MeshStream& stream,
           const RunContext& context);

  // The arrays whose values are not the same in all steps, or that not all have; ascending.
  std::vector<std::string> changing() const;
  bool changes(const std::string& array) const;
  // Labels of that array, of cells from `first` on: Int64.
  void read(const std::string& array, std::uint64_t first, std::span<std::byte> out) const;
  // Is it one of the arrays, in any step?
  bool has(const std::string& array) const { return labels_.contains(array); }

 private:
  struct Labels {
    PagedArray<std::uint64_t> of_cells;
    std::optional<std::uint64_t> print = {};  // of the first step's values, if it has any
    bool changes = false;
  };
  bool is_region(const ArrayInfo& array);
  void add(std::uint64_t step, const ArrayInfo& info, std::size_t index, const MeshStream& stream,
           const RunContext& context);

  const std::string folder_;
  const std::uint64_t cells_;
  const std::optional<std::vector<std::string>>& names_;
  std::map<std::string, Labels> labels_;  // by the array's name
  std::mutex mutex_;                      // for labels, after step 0
};

}  // namespace tetfusion
