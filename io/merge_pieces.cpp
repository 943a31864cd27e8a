#include "io/merge_pieces.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <variant>
#include <vector>

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

// splitmix64's finaliser, chained.
std::uint64_t mix(const Key& key) {
  std::uint64_t h = 0;
  for (const std::uint64_t word : key) {
    h = (h ^ word) + 0x9E3779B97F4A7C15u;
    h = (h ^ (h >> 30)) * 0xBF58476D1CE4E5B9u;
    h = (h ^ (h >> 27)) * 0x94D049BB133111EBu;
    h ^= h >> 31;
  }
  return h;
}

struct Record {
  std::uint64_t hash;
  VertexId point;
};

// Matches the points of equal key, in ascending order, between pieces.
void match_run(std::span<const Record> run, std::span<const std::uint64_t> piece_begin,
               std::vector<VertexId>* firsts, Vector<VertexId>* copy_of) {
  firsts->clear();
  std::size_t piece = 0;
  std::size_t copy = 0;  // how many of this piece came before
  for (const Record& r : run) {
    if (r.point >= piece_begin[piece + 1]) {
      const auto next = std::upper_bound(piece_begin.begin(), piece_begin.end(), r.point);
      piece = static_cast<std::size_t>(next - piece_begin.begin()) - 1;
      copy = 0;
    }
    if (copy == firsts->size()) firsts->push_back(r.point);
    (*copy_of)[r.point] = (*firsts)[copy++];
  }
}

}  // namespace

Vector<VertexId> match_points(const PiecePoints& pieces, const Vector<std::uint8_t>& used) {
  const KeyOf key_of{pieces};
  Vector<VertexId> copy_of(used.size());
  std::vector<Record> records;
  for (std::size_t v = 0; v < used.size(); ++v) {
    const VertexId point = static_cast<VertexId>(v);
    copy_of[v] = point;
    if (used[v] != 0) records.push_back({mix(key_of(point)), point});
  }
  std::sort(records.begin(), records.end(), [](const Record& a, const Record& b) {
    return a.hash != b.hash ? a.hash < b.hash : a.point < b.point;
  });
  std::vector<VertexId> firsts;
  for (std::size_t begin = 0; begin < records.size();) {
    std::size_t end = begin + 1;
    while (end < records.size() && records[end].hash == records[begin].hash) ++end;
    if (end - begin > 1) {
      // Different keys of one hash are as good as impossible, but not impossible.
      const auto less_key = [&](const Record& a, const Record& b) {
        return key_of(a.point) < key_of(b.point);
      };
      const auto group = records.begin();
      std::stable_sort(group + static_cast<std::ptrdiff_t>(begin),
                       group + static_cast<std::ptrdiff_t>(end), less_key);
      for (std::size_t first = begin; first < end;) {
        std::size_t last = first + 1;
        while (last < end && !less_key(records[first], records[last])) ++last;
        match_run(std::span(records).subspan(first, last - first), pieces.piece_begin, &firsts,
                  &copy_of);
        first = last;
      }
    }
    begin = end;
  }
  return copy_of;
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
