#include "compare/region_labels.h"

namespace tetfusion {

RegionLabels::RegionLabels(const MeshDescription& mesh, const std::vector<std::size_t>& cell_arrays)
    : mesh_(mesh), arrays_(cell_arrays), numbers_(cell_arrays.size()) {}

std::span<const std::uint32_t> RegionLabels::read(const MeshStream& stream, std::uint64_t first,
                                                  std::uint64_t count, const CellWindow& window) {
  labels_.assign(window.tets.size(), 0);
  for (std::size_t a = 0; a < arrays_.size(); ++a) {
    const ArrayInfo& info = mesh_.cell_data.arrays[arrays_[a]];
    bytes_.resize(count * size_of(info.type));
    stream.read_rows(Association::kCell, arrays_[a], first, count, bytes_);
    const Vector<std::uint64_t> keys = region_keys(info.type, bytes_);
    for (std::size_t t = 0; t < labels_.size(); ++t) {
      const std::uint64_t row = window.tet_rows.empty() ? t : window.tet_rows[t] - first;
      labels_[t] = numbers_[a].number(labels_[t], keys[row]);
    }
  }
  return labels_;
}

}  // namespace tetfusion
