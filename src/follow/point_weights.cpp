#include "follow/point_weights.h"

#include <algorithm>
#include <numeric>

#include "base/blocks.h"

namespace tetfusion {

namespace {

// Calls f(k) for the corners that count, of those that are new.
template <class F>
void for_each_new(const PointPlace& place, const Vector<std::uint8_t>& is_new, F f) {
  if (place.corners[0] == kNoVertex) return;
  for (std::size_t k = 0; k < 4; ++k) {
    if (place.weights[k] > 0 && is_new[place.corners[k]] != 0) f(k);
  }
}

}  // namespace

PointPlace place_of(const MapFile& map, std::uint64_t point) {
  const MapPlace& place = map.places()[point];
  PointPlace out{{kNoVertex, kNoVertex, kNoVertex, kNoVertex}, place.weights};
  if (place.cell == kNoCell) return out;
  const auto corners = map.corners(place.cell);
  const auto most = static_cast<std::size_t>(
      std::max_element(place.weights.begin(), place.weights.end()) - place.weights.begin());
  for (std::size_t k = 0; k < 4; ++k) {
    out.corners[k] = static_cast<VertexId>(corners[place.weights[k] == 0 ? most : k]);
  }
  return out;
}

PointWeights::PointWeights(const MapFile& map, const std::string& folder)
    : places_(folder, map.counts().original_points) {
  find_new_points(map);
  count_parts(map);
  parts_ = PagedArray<Part>(folder, ends_.empty() ? 0 : ends_.back());
  for_each_block(windows(), 1, [&](std::size_t w, std::size_t, std::size_t) { fill(w); });
}

void PointWeights::find_new_points(const MapFile& map) {
  is_new_.assign(map.counts().points, 1);
  for (const MapShare& share : map.shares()) {
    if (share.weight == 1) is_new_[share.point] = 0;
  }
  map.forget(map.shares());
}

void PointWeights::count_parts(const MapFile& map) {
  const std::size_t windows = block_count(points(), kWindow);
  ends_.assign(windows * kRanges, 0);
  for_each_block(points(), kWindow, [&](std::size_t w, std::size_t begin, std::size_t end) {
    const std::span<std::uint64_t, kRanges> counts(ends_.data() + w * kRanges, kRanges);
    for (std::size_t i = begin; i < end; ++i) {
      places_.data()[i] = place_of(map, i);
      const PointPlace& place = places_[i];
      for_each_new(place, is_new_, [&](std::size_t k) { ++counts[range_of(place.corners[k])]; });
    }
    map.forget(map.places().subspan(begin, end - begin));
    places_.let_go();
  });
  std::partial_sum(ends_.begin(), ends_.end(), ends_.begin());
}

void PointWeights::fill(std::size_t window) {
  std::array<std::uint64_t, kRanges> next{};
  for (std::size_t r = 0; r < kRanges; ++r) {
    next[r] = static_cast<std::uint64_t>(parts(window, r).data() - parts_.data());
  }
  const auto here = places(window);
  for (std::size_t i = 0; i < here.size(); ++i) {
    for_each_new(here[i], is_new_, [&](std::size_t k) {
      const VertexId to = here[i].corners[k];
      parts_.data()[next[range_of(to)]++] = {to, static_cast<std::uint32_t>(i), here[i].weights[k]};
    });
  }
  let_go();
}

auto PointWeights::places(std::size_t window) const -> std::span<const PointPlace> {
  const std::uint64_t first = first_of(window);
  return {places_.data() + first, std::min(kWindow, points() - first)};
}

auto PointWeights::parts(std::size_t window, std::size_t range) const -> std::span<const Part> {
  const std::size_t i = window * kRanges + range;
  const std::uint64_t begin = i == 0 ? 0 : ends_[i - 1];
  return {parts_.data() + begin, ends_[i] - begin};
}

void PointWeights::let_go() const {
  places_.let_go();
  parts_.let_go();
}

}  // namespace tetfusion
