#include "compare/region_labels.h"

#include <cstring>

namespace tetfusion {

RegionLabels::RegionLabels(const MeshDescription& mesh, const std::vector<std::size_t>& cell_arrays)
    : mesh_(mesh), arrays_(cell_arrays), numbers_(cell_arrays.size()) {}

std::span<const std::uint32_t> RegionLabels::read(const MeshStream& stream, std::uint64_t first,
                                                  std::uint64_t count, const CellWindow& window) {
  labels_.assign(window.tets.size(), 0);
  for (array_ = 0; array_ < arrays_.size(); ++array_) {
    const ArrayInfo& info = mesh_.cell_data.arrays[arrays_[array_]];
    bytes_.resize(count * size_of(info.type));
    stream.read_rows(Association::kCell, arrays_[array_], first, count, bytes_);
    refine(info, first, window);
  }
  return labels_;
}

void RegionLabels::refine(const ArrayInfo& info, std::uint64_t first, const CellWindow& window) {
  auto& numbers = numbers_[array_];
  visit_type(info.type, [&](auto zero) {
    using T = decltype(zero);
    // Neighbours in the file are mostly of one region.
    std::pair<std::uint32_t, std::int64_t> last{};
    std::uint32_t label = 0;
    for (std::size_t t = 0; t < labels_.size(); ++t) {
      const std::uint64_t row = window.tet_rows.empty() ? t : window.tet_rows[t] - first;
      T value;
      std::memcpy(&value, bytes_.data() + row * sizeof value, sizeof value);
      const std::pair key{labels_[t], static_cast<std::int64_t>(value)};
      if (t == 0 || key != last) {
        label = numbers.try_emplace(key, static_cast<std::uint32_t>(numbers.size())).first->second;
      }
      last = key;
      labels_[t] = label;
    }
  });
}

}  // namespace tetfusion
