// Points with the same coordinates in a mesh that is read in windows.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "base/blocks.h"
#include "base/run_context.h"
#include "io/source/mesh_stream.h"
#include "mesh/inspection/coincident.h"

namespace tetfusion {

// Calls found(later, earlier) for each point that counts with the coordinates of an earlier one,
// and the earliest of those. Points with the same coordinates are of the same shard: as many shards
// at a time as fit into about 32 MiB, and all points are read for each of these turns.
// counts(point) is called from several threads, begin_turn(turn, turns) and found() from one.
template <class Real, class Counts, class BeginTurn, class Found>
void find_coincident(const MeshStream& stream, const RunContext& context, Counts counts,
                     BeginTurn begin_turn, Found found) {
  constexpr std::uint64_t kBytes = std::uint64_t{32} << 20;
  constexpr std::uint64_t kWindow = std::uint64_t{1} << 18;
  struct Window {
    Vector<VertexId> ids;
    Vector<Vec3<Real>> positions;
  };
  const std::uint64_t points = stream.points();
  const std::uint64_t turns = std::clamp<std::uint64_t>(
      block_count(points * (sizeof(Vec3<Real>) + 20), kBytes), 1, kCoordinateShards);
  for (std::uint64_t turn = 0; turn < turns; ++turn) {
    begin_turn(turn, turns);
    const auto first_shard = static_cast<std::uint32_t>(kCoordinateShards * turn / turns);
    const auto end_shard = static_cast<std::uint32_t>(kCoordinateShards * (turn + 1) / turns);
    std::vector<Window> windows(block_count(points, kWindow));
    for_each_block(points, kWindow, [&](std::size_t w, std::size_t begin, std::size_t end) {
      context.check();
      Vector<Vec3<Real>> positions(end - begin);
      stream.read_points(begin, end - begin, std::as_writable_bytes(std::span(positions)));
      for (std::size_t v = begin; v < end; ++v) {
        const std::uint32_t shard = coordinate_shard(positions[v - begin]);
        if (shard < first_shard || shard >= end_shard || !counts(v)) continue;
        windows[w].ids.push_back(static_cast<VertexId>(v));
        windows[w].positions.push_back(positions[v - begin]);
      }
    });
    Vector<VertexId> ids;
    Vector<Vec3<Real>> positions;
    for (Window& window : windows) {
      ids.insert(ids.end(), window.ids.begin(), window.ids.end());
      positions.insert(positions.end(), window.positions.begin(), window.positions.end());
      window = {};
    }
    for (const auto& [later, earlier] : coincident_points(Points(std::move(positions)))) {
      found(ids[later], ids[earlier]);
    }
  }
}

}  // namespace tetfusion
