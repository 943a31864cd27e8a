#include "series/combined_regions.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <stdexcept>
#include <utility>

#include "base/mix.h"
#include "io/checksum.h"
#include "mesh/blocks.h"
#include "mesh/region_names.h"
#include "mesh/region_numbers.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kCellWindow = std::uint64_t{1} << 18;
constexpr std::uint64_t kBlock = std::uint64_t{1} << 14;

// Calls f(first, values) with what an array says of regions, window by window.
template <class F>
void for_each_window(const ArrayInfo& info, std::size_t index, std::uint64_t cells,
                     const MeshStream& stream, const RunContext& context, F f) {
  Vector<std::byte> rows;
  Vector<std::uint64_t> values;
  for (std::uint64_t first = 0; first < cells; first += kCellWindow) {
    context.check();
    const std::uint64_t count = std::min(kCellWindow, cells - first);
    rows.resize(count * size_of(info.type));
    values.resize(count);
    stream.read_rows(Association::kCell, index, first, count, rows);
    visit_type(info.type, [&](auto zero) {
      using T = decltype(zero);
      for_each_block(count, kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          T value;
          std::memcpy(&value, rows.data() + i * sizeof value, sizeof value);
          values[i] = region_key(value);
        }
      });
    });
    f(first, values);
  }
}

}  // namespace

CombinedRegions::CombinedRegions(const std::string& folder, const MeshDescription& first,
                                 std::uint64_t cells, const std::vector<std::size_t>& arrays) {
  for (const std::size_t i : arrays) {
    labels_.push_back({first.cell_data.arrays[i].name, {folder, cells}, 0, false});
  }
}

// A step with the values of the first one tells nothing new. Of any other one each value is added,
// mixed with the step's number: the sums are the same in whatever order steps come.
void CombinedRegions::add(std::uint64_t step, const MeshDescription& mesh, const MeshStream& stream,
                          const RunContext& context) {
  for (Labels& labels : labels_) {
    const std::size_t index = mesh.cell_data.find(labels.name);
    if (index == AttributeSet::npos || !can_be_region(mesh.cell_data.arrays[index])) continue;
    const ArrayInfo& info = mesh.cell_data.arrays[index];
    const std::uint64_t cells = labels.of_cells.size();
    std::uint64_t print = 0;
    for_each_window(info, index, cells, stream, context, [&](std::uint64_t, const auto& values) {
      print = checksum(std::as_bytes(std::span(values)), print);
    });
    if (step == 0) labels.print = print;
    if (step != 0 && print == labels.print) continue;
    const std::lock_guard lock(mutex_);
    labels.changes |= step != 0;
    const auto add = [&](std::uint64_t first, const auto& values) {
      for_each_block(values.size(), kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          labels.of_cells[first + i] += mix(values[i] ^ mix(step));
        }
      });
      labels.of_cells.let_go();
    };
    for_each_window(info, index, cells, stream, context, add);
  }
}

std::vector<std::string> CombinedRegions::changing() const {
  std::vector<std::string> names;
  for (const Labels& labels : labels_) {
    if (labels.changes) names.push_back(labels.name);
  }
  return names;
}

bool CombinedRegions::changes(const std::string& array) const {
  return std::any_of(labels_.begin(), labels_.end(),
                     [&](const Labels& labels) { return labels.name == array && labels.changes; });
}

bool CombinedRegions::has(const std::string& array) const {
  return std::any_of(labels_.begin(), labels_.end(),
                     [&](const Labels& labels) { return labels.name == array; });
}

const CombinedRegions::Labels& CombinedRegions::find(const std::string& array) const {
  const auto it = std::find_if(labels_.begin(), labels_.end(),
                               [&](const Labels& labels) { return labels.name == array; });
  if (it == labels_.end()) throw std::logic_error("no labels of " + array);
  return *it;
}

void CombinedRegions::read(const std::string& array, std::uint64_t first,
                           std::span<std::byte> out) const {
  const Labels& labels = find(array);
  std::memcpy(out.data(), labels.of_cells.data() + first, out.size());
  labels.of_cells.let_go();
}

}  // namespace tetfusion
