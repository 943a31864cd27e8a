// What the steps of a series together say about which region a cell is in.
#pragma once

#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "io/mesh_stream.h"
#include "io/paged_array.h"

namespace tetfusion {

// Cells that some step tells apart are told apart: each has a label made of all steps' values (64
// bits, mixed: two pairs of neighbours in 2^64 would be taken for one region). Labels lie on the
// disk, eight bytes a cell and array.
class CombinedRegions {
 public:
  // `arrays`: the cell arrays of the first step that are regions, numbers of one component.
  CombinedRegions(const std::string& folder, const MeshDescription& first, std::uint64_t cells,
                  const std::vector<std::size_t>& arrays);

  // Each step, number 0 before all others; these from several threads at once, in any order. One
  // that has not the array says nothing.
  void add(std::uint64_t step, const MeshDescription& mesh, const MeshStream& stream,
           const RunContext& context);

  // The arrays whose values are not the same in all steps.
  std::vector<std::string> changing() const;
  bool changes(const std::string& array) const;
  // Labels of that array, of cells from `first` on: Int64.
  void read(const std::string& array, std::uint64_t first, std::span<std::byte> out) const;
  // Is it one of the arrays?
  bool has(const std::string& array) const;

 private:
  struct Labels {
    std::string name;
    PagedArray<std::uint64_t> of_cells;
    std::uint64_t print = 0;  // of the first step's values
    bool changes = false;
  };
  const Labels& find(const std::string& array) const;

  std::vector<Labels> labels_;
  std::mutex mutex_;  // for labels, after step 0
};

}  // namespace tetfusion
