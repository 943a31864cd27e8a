#include "series/combined_regions.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "mesh/blocks.h"
#include "mesh/region_names.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kWindow = std::uint64_t{1} << 18;
constexpr std::uint64_t kBlock = std::uint64_t{1} << 14;

// splitmix64's finaliser.
std::uint64_t mix(std::uint64_t h) {
  h += 0x9E3779B97F4A7C15u;
  h = (h ^ (h >> 30)) * 0xBF58476D1CE4E5B9u;
  h = (h ^ (h >> 27)) * 0x94D049BB133111EBu;
  return h ^ (h >> 31);
}

}  // namespace

CombinedRegions::CombinedRegions(const std::string& folder, const MeshDescription& first,
                                 std::uint64_t cells, const std::vector<std::size_t>& arrays) {
  for (const std::size_t i : arrays) {
    labels_.push_back({first.cell_data.arrays[i].name, {folder, cells}, 0, false});
  }
}

void CombinedRegions::add(const MeshDescription& mesh, const MeshStream& stream,
                          const RunContext& context) {
  for (Labels& labels : labels_) add(&labels, mesh, stream, context);
  first_ = false;
}

void CombinedRegions::add(Labels* labels, const MeshDescription& mesh, const MeshStream& stream,
                          const RunContext& context) const {
  const std::size_t index = mesh.cell_data.find(labels->name);
  if (index == AttributeSet::npos || !can_be_region(mesh.cell_data.arrays[index])) return;
  const std::size_t width = size_of(mesh.cell_data.arrays[index].type);
  Vector<std::byte> bytes;
  std::array<std::uint64_t, kWindow / kBlock> prints;  // of the window's blocks
  std::uint64_t print = 0;
  for (std::uint64_t begin = 0; begin < labels->of_cells.size(); begin += kWindow) {
    context.check();
    const std::uint64_t count = std::min(kWindow, labels->of_cells.size() - begin);
    bytes.resize(count * width);
    stream.read_rows(Association::kCell, index, begin, count, bytes);
    visit_type(mesh.cell_data.arrays[index].type, [&](auto zero) {
      using T = decltype(zero);
      for_each_block(count, kBlock, [&](std::size_t b, std::size_t from, std::size_t to) {
        std::uint64_t print_of_block = 0;
        for (std::size_t i = from; i < to; ++i) {
          T value;
          std::memcpy(&value, bytes.data() + i * sizeof value, sizeof value);
          std::uint64_t& label = labels->of_cells[begin + i];
          const auto number = static_cast<std::uint64_t>(static_cast<std::int64_t>(value));
          print_of_block = mix(print_of_block ^ number);
          label = mix(label ^ number);
        }
        prints[b] = print_of_block;
      });
    });
    for (std::size_t b = 0; b < block_count(count, kBlock); ++b) print = mix(print ^ prints[b]);
    labels->of_cells.let_go();
  }
  if (first_) labels->print = print;
  labels->changes |= print != labels->print;
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
