// One mesh out of several pieces: which points are copies of one another, and new numbers for the
// rest.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/vector.h"
#include "mesh/data_array.h"
#include "mesh/geometry.h"

namespace tetfusion {

struct PiecePoints {
  const Points* points = nullptr;              // of all pieces, one after another
  std::span<const std::uint64_t> piece_begin;  // first point of each piece; one entry more
  std::span<const std::int64_t> global_ids;    // one a point, or empty: compare coordinates. Ids
                                               // that points far from each other have do not count
  bool also_within = false;                    // points of one piece may be copies, too
};

// For each used point the lowest point that it is a copy of (often itself). Points of different
// pieces are copies when their global ids, or without these all three coordinates, are equal (0
// equals -0). Points of one piece never are: where a piece has several equal points (the two sides
// of a crack), its first matches the first of the other pieces, its second the second. With
// also_within all equal points are copies of the first. Unused points stand for themselves.
Vector<VertexId> match_points(const PiecePoints& pieces, const Vector<std::uint8_t>& used);

// Pairs the points of equal key, in ascending order, between pieces: calls put(point, original) for
// each of them. `firsts` is scratch memory.
template <class Record, class Put>
void match_run(std::span<const Record> run, std::span<const std::uint64_t> piece_begin,
               bool also_within, std::vector<VertexId>* firsts, Put put) {
  if (also_within) {
    for (const Record& r : run) put(r.point, run.front().point);
    return;
  }
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
    put(r.point, (*firsts)[copy++]);
  }
}

std::uint64_t hash_of(const std::array<std::uint64_t, 3>& key);

// The point array that has global ids: the one that is marked, or is called like one; npos where
// there is none.
std::size_t find_global_ids(const AttributeSet& point_data);

// Drops unused points and copies from mesh->points, in order, and fills point_source, unused_points
// and merged_points. `copy_of` is empty when no point is a copy. Returns the new number of each old
// point (kNoVertex for unused ones), or nothing when all stay as they are.
Vector<VertexId> compact_points(const Vector<std::uint8_t>& used, const Vector<VertexId>& copy_of,
                                Geometry* mesh);

}  // namespace tetfusion
