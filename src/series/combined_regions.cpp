#include "series/combined_regions.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>

#include "base/blocks.h"
#include "base/mix.h"
#include "io/files/checksum.h"
#include "io/source/stream_windows.h"
#include "mesh/regions/region_names.h"
#include "mesh/regions/region_numbers.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kBlock = std::uint64_t{1} << 14;

// Calls f(first, values) with what an array says of regions, window by window.
template <class F>
void for_each_window_of_regions(const ArrayInfo& info, std::size_t index, const MeshStream& stream,
                                const RunContext& context, F f) {
  Vector<std::uint64_t> values;
  const auto take = [&](std::uint64_t first, std::span<const std::byte> rows) {
    values.resize(rows.size() / size_of(info.type));
    visit_type(info.type, [&](auto zero) {
      using T = decltype(zero);
      for_each_block(values.size(), kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          T value;
          std::memcpy(&value, rows.data() + i * sizeof value, sizeof value);
          values[i] = region_key(value);
        }
      });
    });
    f(first, values);
  };
  for_each_window_of(stream, Association::kCell, index, info, context, take);
}

}  // namespace

// What is one in the first step is one in each.
bool CombinedRegions::is_region(const ArrayInfo& array) {
  if (!can_be_region(array)) return false;
  if (names_) return std::find(names_->begin(), names_->end(), array.name) != names_->end();
  if (looks_like_region(array)) return true;
  const std::lock_guard lock(mutex_);
  const auto it = labels_.find(array.name);
  return it != labels_.end() && it->second.print;
}

void CombinedRegions::add(std::uint64_t step, const MeshDescription& mesh, const MeshStream& stream,
                          const RunContext& context) {
  for (std::size_t i = 0; i < mesh.cell_data.arrays.size(); ++i) {
    const ArrayInfo& array = mesh.cell_data.arrays[i];
    if (is_region(array)) add(step, array, i, stream, context);
  }
}

// A step with the values of the first one tells nothing new. Of any other one each value is added,
// mixed with the step's number: the sums are the same in whatever order steps come.
void CombinedRegions::add(std::uint64_t step, const ArrayInfo& info, std::size_t index,
                          const MeshStream& stream, const RunContext& context) {
  std::uint64_t print = 0;
  for_each_window_of_regions(info, index, stream, context, [&](std::uint64_t, const auto& values) {
    print = checksum(std::as_bytes(std::span(values)), print);
  });
  const std::lock_guard lock(mutex_);
  auto it = labels_.find(info.name);
  if (it == labels_.end()) it = labels_.emplace(info.name, Labels{{folder_, cells_}}).first;
  Labels& labels = it->second;
  if (step == 0) labels.print = print;
  if (step != 0 && print == labels.print) return;
  labels.changes |= step != 0;
  const auto add = [&](std::uint64_t first, const auto& values) {
    for_each_block(values.size(), kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        labels.of_cells[first + i] += mix(values[i] ^ mix(step));
      }
    });
    labels.of_cells.let_go();
  };
  for_each_window_of_regions(info, index, stream, context, add);
}

std::vector<std::string> CombinedRegions::changing() const {
  std::vector<std::string> names;
  for (const auto& [name, labels] : labels_) {
    if (labels.changes) names.push_back(name);
  }
  return names;
}

bool CombinedRegions::changes(const std::string& array) const {
  const auto it = labels_.find(array);
  return it != labels_.end() && it->second.changes;
}

void CombinedRegions::read(const std::string& array, std::uint64_t first,
                           std::span<std::byte> out) const {
  const Labels& labels = labels_.at(array);
  std::memcpy(out.data(), labels.of_cells.data() + first, out.size());
  labels.of_cells.let_go();
}

}  // namespace tetfusion
