#include "follow/apply_cells.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

#include "base/running_mean.h"
#include "io/source/stream_windows.h"
#include "mesh/array_names.h"

namespace tetfusion {

namespace {

// The means of one array, of values of type T, in the tetrahedra that have some.
template <class T>
class TetMeans {
 public:
  TetMeans(const MapFile& map, std::size_t width) : map_(map), width_(width) {
    means_.assign(map.counts().tets * width, 0);
    weights_.assign(map.counts().tets, 0);
  }

  // Of the original's cells from that one on.
  void add(std::uint64_t first, std::span<const T> values) {
    const std::size_t count = values.size() / width_;
    const std::span<const MapHome> homes = map_.homes().subspan(first, count);
    for (std::size_t i = 0; i < count; ++i) {
      const auto [tet, share] = homes[i];
      if (tet == kNoTet || map_.origins()[tet].is_mean == 0) continue;
      const double before = std::exchange(weights_[tet], weights_[tet] + share);
      for (std::size_t c = 0; c < width_; ++c) {
        const T value = values[i * width_ + c];
        const std::size_t at = std::size_t{tet} * width_ + c;
        if (std::isfinite(value)) {
          add_to_mean(value, share, before - (lost_.empty() ? 0 : lost_[at]), &means_[at]);
        } else {
          if (lost_.empty()) {
            lost_.assign(means_.size(), 0);
            others_.resize(means_.size());
          }
          if (lost_[at] == 0) others_[at] = value;
          lost_[at] += share;
        }
      }
    }
    map_.forget(homes);
  }

  void put(std::span<T> out) const {
    for (std::size_t at = 0; at < means_.size(); ++at) {
      if (map_.origins()[at / width_].is_mean == 0 || !(weights_[at / width_] > 0)) continue;
      if (!lost_.empty() && lost_[at] > 0.5 * weights_[at / width_]) {
        if (std::isfinite(out[at])) out[at] = others_[at];
      } else {
        out[at] = static_cast<T>(means_[at]);
      }
    }
  }

 private:
  const MapFile& map_;
  const std::size_t width_;
  Vector<double> means_, weights_;
  Vector<double> lost_;  // weight of what is not finite, once there is any
  Vector<T> others_;     // the first of that
};

}  // namespace

bool has_cells_of(const MapFile& map, MeshSource* source, const RunContext& context) {
  const auto stream = open_stream(source);
  if (stream->cells() != map.counts().original_cells) return false;
  TetsChecksum sum;
  CellWindow window;
  for_each_window(stream->cells(), context, [&](std::uint64_t first, std::uint64_t count) {
    stream->read_cells(first, count, &window);
    for (std::size_t t = 0; t < window.tets.size(); ++t) {
      sum.add(window.tet_rows.empty() ? first + t : window.tet_rows[t], window.tets[t]);
    }
  });
  return sum.value() == map.tets_sum();
}

CellMover::CellMover(const MapFile& map)
    : map_(map), order_(count_up<std::uint32_t>(map.counts().cells)) {
  const std::span<const MapOrigin> origins = map.origins();
  std::stable_sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return origins[a].cell < origins[b].cell;
  });
}

std::vector<MovedCells> CellMover::move(MeshSource* source, const std::vector<std::size_t>& arrays,
                                        const RunContext& context) const {
  const auto stream = open_rows(source);
  std::vector<MovedCells> moved;
  for (const std::size_t i : arrays) {
    context.report("moving cells",
                   static_cast<double>(moved.size()) / static_cast<double>(arrays.size()));
    const ArrayInfo& info = source->description().cell_data.arrays[i];
    moved.push_back(move_one(*stream, info, i, context));
  }
  map_.check();
  return moved;
}

MovedCells CellMover::move_one(const MeshStream& stream, const ArrayInfo& info, std::size_t index,
                               const RunContext& context) const {
  MovedCells moved;
  moved.array.info = info;
  moved.array.info.tuples = map_.counts().cells;
  const std::size_t stride = info.row_bytes();
  moved.array.bytes.resize(map_.counts().cells * stride);
  visit_type(info.type, [&](auto zero) {
    using T = decltype(zero);
    constexpr bool kHasMeans = std::is_floating_point_v<T>;
    std::optional<TetMeans<std::conditional_t<kHasMeans, T, double>>> means;
    if (kHasMeans) means.emplace(map_, info.components);
    auto next = order_.begin();
    const auto take = [&](std::uint64_t first, std::span<const std::byte> rows) {
      const std::uint64_t end = first + rows.size() / stride;
      for (; next != order_.end() && map_.origins()[*next].cell < end; ++next) {
        std::memcpy(moved.array.bytes.data() + *next * stride,
                    rows.data() + (map_.origins()[*next].cell - first) * stride, stride);
      }
      if constexpr (kHasMeans) {
        moved.has_means = moved.has_means || has_fractions(info.type, rows);
        means->add(first, {reinterpret_cast<const T*>(rows.data()), rows.size() / sizeof(T)});
      }
      return kHasMeans || next != order_.end();
    };
    for_each_window_of(stream, Association::kCell, index, info, context, take);
    if constexpr (kHasMeans) {
      if (moved.has_means) means->put(moved.array.template as<T>());
    }
  });
  return moved;
}

std::vector<std::size_t> cell_arrays_to_move(const AttributeSet& cell_data) {
  std::vector<std::size_t> some;
  for (std::size_t i = 0; i < cell_data.arrays.size(); ++i) {
    if (!is_ghost_mark(cell_data.arrays[i].name)) some.push_back(i);
  }
  return some;
}

}  // namespace tetfusion
