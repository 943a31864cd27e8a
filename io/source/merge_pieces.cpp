#include "io/source/merge_pieces.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <numeric>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/blocks.h"
#include "io/source/differing_copies.h"

namespace tetfusion {

namespace {

using Key = std::array<std::uint64_t, 3>;

// Adding zero turns -0 into 0.
std::uint64_t coordinate_bits(double x) { return std::bit_cast<std::uint64_t>(x + 0.0); }

struct KeyOf {
  const PiecePoints& pieces;

  Key operator()(VertexId v) const {
    if (!pieces.global_ids.empty()) {
      return {static_cast<std::uint64_t>(pieces.global_ids[v]), 0, 0};
    }
    return std::visit(
        [v](const auto& points) {
          const auto& p = points[v];
          return Key{coordinate_bits(p.x), coordinate_bits(p.y), coordinate_bits(p.z)};
        },
        *pieces.points);
  }
};

struct PointRecord {
  std::uint64_t hash;
  VertexId point;
};

// Matches the points of one bucket, which holds all points of its hashes.
void match_bucket(const PiecePoints& pieces, std::span<PointRecord> records,
                  Vector<VertexId>* copy_of) {
  std::sort(records.begin(), records.end(), [](const PointRecord& a, const PointRecord& b) {
    return a.hash != b.hash ? a.hash < b.hash : a.point < b.point;
  });
  const KeyOf key_of{pieces};
  const auto less_key = [&](const PointRecord& a, const PointRecord& b) {
    return key_of(a.point) < key_of(b.point);
  };
  std::vector<VertexId> firsts;
  for (std::size_t begin = 0; begin < records.size();) {
    std::size_t end = begin + 1;
    while (end < records.size() && records[end].hash == records[begin].hash) ++end;
    const std::span<PointRecord> group = records.subspan(begin, end - begin);
    begin = end;
    if (group.size() == 1) continue;
    // Different keys of one hash are as good as impossible, but not impossible.
    std::stable_sort(group.begin(), group.end(), less_key);
    for (std::size_t first = 0; first < group.size();) {
      std::size_t last = first + 1;
      while (last < group.size() && !less_key(group[first], group[last])) ++last;
      match_run(std::span<const PointRecord>(group.subspan(first, last - first)),
                pieces.piece_begin, pieces.also_within, &firsts,
                [&](VertexId point, VertexId original) { (*copy_of)[point] = original; });
      first = last;
    }
  }
}

// Small enough to be sorted in a core's cache for meshes of some millions of points.
constexpr std::size_t kBuckets = 1024;
constexpr std::size_t kPointsPerBlock = 65536;

std::size_t bucket_of(std::uint64_t hash) { return hash >> 54; }
static_assert(kBuckets == std::size_t{1} << (64 - 54));

}  // namespace

// splitmix64's finaliser, chained.
std::uint64_t hash_of(const std::array<std::uint64_t, 3>& key) {
  std::uint64_t h = 0;
  for (const std::uint64_t word : key) {
    h = (h ^ word) + 0x9E3779B97F4A7C15u;
    h = (h ^ (h >> 30)) * 0xBF58476D1CE4E5B9u;
    h = (h ^ (h >> 27)) * 0x94D049BB133111EBu;
    h ^= h >> 31;
  }
  return h;
}

std::size_t find_global_ids(const AttributeSet& point_data) {
  const auto marked = point_data.active.find("GlobalIds");
  const std::string marked_name = marked == point_data.active.end() ? "" : marked->second;
  for (const std::string_view name :
       {std::string_view(marked_name), std::string_view("GlobalNodeIds"),
        std::string_view("GlobalNodeId"), std::string_view("GlobalPointIds")}) {
    const std::size_t index = point_data.find(name);
    if (name.empty() || index == AttributeSet::npos) continue;
    const ArrayInfo& info = point_data.arrays[index];
    if (!is_float(info.type) && info.components == 1) return index;
  }
  return AttributeSet::npos;
}

namespace {

Vector<VertexId> match_by_keys(const PiecePoints& pieces, const Vector<std::uint8_t>& used) {
  const KeyOf key_of{pieces};
  Vector<VertexId> copy_of(used.size());
  Vector<std::uint64_t> hashes(used.size());
  for_each_block(used.size(), kPointsPerBlock,
                 [&](std::size_t, std::size_t begin, std::size_t end) {
                   for (std::size_t v = begin; v < end; ++v) {
                     copy_of[v] = static_cast<VertexId>(v);
                     hashes[v] = hash_of(key_of(static_cast<VertexId>(v)));
                   }
                 });
  std::vector<std::size_t> bucket_end(kBuckets + 1, 0);
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (used[v] != 0) ++bucket_end[bucket_of(hashes[v]) + 1];
  }
  std::partial_sum(bucket_end.begin(), bucket_end.end(), bucket_end.begin());
  Vector<PointRecord> records(bucket_end[kBuckets]);
  // bucket_end[b] starts as the begin of bucket b and ends as its end.
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (used[v] == 0) continue;
    records[bucket_end[bucket_of(hashes[v])]++] = {hashes[v], static_cast<VertexId>(v)};
  }
  for_each_block(kBuckets, 1, [&](std::size_t b, std::size_t, std::size_t) {
    const std::size_t begin = b == 0 ? 0 : bucket_end[b - 1];
    match_bucket(pieces, std::span(records).subspan(begin, bucket_end[b] - begin), &copy_of);
  });
  return copy_of;
}

}  // namespace

Vector<VertexId> match_points(const PiecePoints& pieces, const Vector<std::uint8_t>& used) {
  Vector<VertexId> copy_of = match_by_keys(pieces, used);
  if (pieces.global_ids.empty() || lie_together(copy_of, used, *pieces.points)) return copy_of;
  PiecePoints by_places = pieces;
  by_places.global_ids = {};
  return match_by_keys(by_places, used);
}

Vector<VertexId> compact_points(const Vector<std::uint8_t>& used, const Vector<VertexId>& copy_of,
                                Geometry* mesh) {
  const auto stays = [&](std::size_t v) {
    return used[v] != 0 && (copy_of.empty() || copy_of[v] == v);
  };
  Vector<VertexId> new_ids(used.size());
  VertexId count = 0;
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (used[v] == 0) {
      ++mesh->unused_points;
      new_ids[v] = kNoVertex;
    } else if (stays(v)) {
      new_ids[v] = count++;
    } else {
      ++mesh->merged_points;
      new_ids[v] = new_ids[copy_of[v]];  // a copy's original comes before it
    }
  }
  if (count == used.size()) return {};
  mesh->point_source.resize(count);
  std::visit(
      [&](auto& points) {
        for (std::size_t v = 0; v < used.size(); ++v) {
          if (!stays(v)) continue;
          points[new_ids[v]] = points[v];
          mesh->point_source[new_ids[v]] = v;
        }
        points.resize(count);
      },
      mesh->points);
  return new_ids;
}

}  // namespace tetfusion
