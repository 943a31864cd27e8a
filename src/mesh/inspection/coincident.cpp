#include "mesh/inspection/coincident.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/blocks.h"

namespace tetfusion {

namespace {

template <class Real>
std::uint64_t hash_point(const Vec3<Real>& p) {
  std::uint64_t hash = 0;
  for (const double x : {double{p.x}, double{p.y}, double{p.z}}) {
    hash = (hash ^ std::bit_cast<std::uint64_t>(x + 0.0)) * 0x9E3779B97F4A7C15u;  // -0 becomes 0
    hash ^= hash >> 32;
  }
  return hash;
}

using Pairs = Vector<std::pair<VertexId, VertexId>>;

constexpr std::size_t kPointsPerBlock = 1 << 16;  // points
constexpr std::size_t kShards = kCoordinateShards;

// The points of each shard, ascending: those of shard s are points[offsets[s]] up to
// points[offsets[s + 1]].
struct Shards {
  Vector<std::size_t> offsets;
  Vector<VertexId> points;
};

template <class Real>
Shards make_shards(const Vector<Vec3<Real>>& points) {
  const std::size_t blocks = block_count(points.size(), kPointsPerBlock);
  Vector<std::size_t> places(blocks * kShards, 0);  // counts, then where to put the next point
  for_each_block(points.size(), kPointsPerBlock,
                 [&](std::size_t b, std::size_t begin, std::size_t end) {
                   for (std::size_t v = begin; v < end; ++v)
                     ++places[b * kShards + coordinate_shard(points[v])];
                 });
  Shards shards;
  std::size_t sum = 0;
  for (std::size_t s = 0; s < kShards; ++s) {
    shards.offsets.push_back(sum);
    for (std::size_t b = 0; b < blocks; ++b) {
      sum += std::exchange(places[b * kShards + s], sum);
    }
  }
  shards.offsets.push_back(sum);
  shards.points.resize(sum);
  for_each_block(points.size(), kPointsPerBlock,
                 [&](std::size_t b, std::size_t begin, std::size_t end) {
                   for (std::size_t v = begin; v < end; ++v) {
                     shards.points[places[b * kShards + coordinate_shard(points[v])]++] =
                         static_cast<VertexId>(v);
                   }
                 });
  return shards;
}

template <class Real>
Pairs find_in(const Vector<Vec3<Real>>& points, std::span<const VertexId> shard) {
  Pairs found;
  const std::size_t mask = std::bit_ceil(2 * shard.size() + 1) - 1;
  Vector<VertexId> slots(mask + 1, kNoVertex);
  for (const VertexId v : shard) {
    const Vec3<Real>& p = points[v];
    for (std::size_t i = hash_point(p);; ++i) {
      VertexId& slot = slots[i & mask];
      if (slot == kNoVertex) {
        slot = v;
        break;
      }
      const Vec3<Real>& q = points[slot];
      if (p.x == q.x && p.y == q.y && p.z == q.z) {
        found.push_back({v, slot});
        break;
      }
    }
  }
  return found;
}

template <class Real>
Pairs find(const Vector<Vec3<Real>>& points) {
  const Shards shards = make_shards(points);
  std::vector<Pairs> parts(kShards);
  for_each_block(kShards, 1, [&](std::size_t s, std::size_t, std::size_t) {
    parts[s] = find_in(points, {shards.points.data() + shards.offsets[s],
                                shards.points.data() + shards.offsets[s + 1]});
  });
  Pairs found;
  for (const Pairs& part : parts) found.insert(found.end(), part.begin(), part.end());
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

template <class Real>
std::uint32_t coordinate_shard(const Vec3<Real>& p) {
  return static_cast<std::uint32_t>(hash_point(p) >> 56);
}
template std::uint32_t coordinate_shard(const Vec3<float>&);
template std::uint32_t coordinate_shard(const Vec3<double>&);

Vector<std::pair<VertexId, VertexId>> coincident_points(const Points& points) {
  return std::visit([](const auto& p) { return find(p); }, points);
}

}  // namespace tetfusion
