// Numbers for the points of a mesh in several pieces, where no more than a few bits a point may be
// in memory: points that no cell uses have none, copies of a point have that of the first.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "base/vector.h"
#include "io/source/differing_copies.h"
#include "mesh/geometry.h"

namespace tetfusion {

// What makes two points of different pieces copies of each other: a global id, or coordinates.
using PointKey = std::array<std::uint64_t, 3>;

// Here points are counted through all pieces, from 0 on. Which of them are copies is decided as by
// match_points() (merge_pieces.h), and they are numbered as by compact_points().
class PieceNumbers {
 public:
  explicit PieceNumbers(std::uint64_t points);

  // From several threads; before the rest.
  void use(VertexId point);

  // Finds the copies among the used points. keys(first, count, out) gives those of a range within
  // one piece. `piece_begin`: the first point of each piece; one entry more. Takes 32 bytes for
  // each point that it has in hand, and goes through all points again where those are more than
  // `memory` holds. `also_within`: as in PiecePoints.
  using ReadKeys = std::function<void(std::uint64_t first, std::uint64_t count, PointKey* out)>;
  void find_copies(std::span<const std::uint64_t> piece_begin, const ReadKeys& keys,
                   std::uint64_t memory, bool also_within = false);

  // As if it had not been called.
  void forget_copies();

  std::uint64_t points() const { return ranks_.back(); }  // that have numbers of their own
  std::uint64_t merged() const { return copies_.size(); }
  std::uint64_t unused() const { return points_ - points() - merged(); }
  std::uint64_t bytes() const;                              // of memory
  JoinedPoints joined() const { return {bits_, copies_}; }  // as long as this is there

  // Of a used point.
  VertexId number(VertexId point) const;
  // Does it have a number of its own?
  bool stays(std::uint64_t point) const { return (bits_[point / 64] >> (point % 64) & 1) != 0; }
  // The point that has this number of its own; for points() the end.
  std::uint64_t point_of(std::uint64_t number) const;

 private:
  static constexpr std::uint64_t kWords = 8;  // of bits, a rank

  void match(std::span<const std::uint64_t> piece_begin, const ReadKeys& keys, bool also_within,
             std::uint64_t passes, std::uint64_t pass);
  void rank();
  VertexId rank_of(VertexId point) const;

  std::uint64_t points_;
  Vector<std::uint64_t> bits_;   // used, and no copy
  Vector<std::uint64_t> ranks_;  // points with numbers before each kWords words; one entry more
  Vector<PointCopy> copies_;     // ascending
};

// Coordinates as a key: 0 equals -0.
PointKey key_of_coordinates(double x, double y, double z);

}  // namespace tetfusion
