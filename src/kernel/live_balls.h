// The tetrahedra round each vertex of a mesh that is being worked on.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>

#include "base/vector.h"
#include "mesh/vertex_tets.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Balls as lists of entries (VertexTets): tet << 2 | corner. Those of deleted tetrahedra are
// dropped when somebody asks. Keeps its memory from mesh to mesh.
class LiveBalls {
 public:
  // Every vertex's incidence must be right from here on: by it a ball knows what is gone.
  void reset(std::size_t vertices, std::span<const Tet> tets) {
    build_vertex_tets(vertices, tets, &start_);
    std::swap(entries_, start_.entries);
    balls_.resize(vertices);
    for (std::size_t v = 0; v < vertices; ++v) {
      const std::uint32_t count = start_.offsets[v + 1] - start_.offsets[v];
      balls_[v] = {start_.offsets[v], count, count};
    }
  }

  // Good until the next call of add().
  std::span<const std::uint32_t> of(VertexId v, std::uint32_t incidence, const Vector<Tet>& tets) {
    Ball& ball = balls_[v];
    std::uint32_t* entries = entries_.data() + ball.begin;
    if (ball.count != incidence) {
      // No branch: who is gone cannot be foretold.
      std::uint32_t kept = 0;
      for (std::uint32_t i = 0; i < ball.count; ++i) {
        const std::uint32_t entry = entries[i];
        entries[kept] = entry;
        kept += is_deleted(tets[entry >> 2]) ? 0 : 1;
      }
      ball.count = kept;
    }
    return {entries, ball.count};
  }

  // Asks the processor for what a ball is looked up by, then for its entries, then for their
  // tetrahedra; each is only known when the one before is there.
  void prefetch_ball(VertexId v) const { __builtin_prefetch(&balls_[v]); }
  void prefetch_entries(VertexId v) const {
    constexpr std::uint32_t kEntriesALine = 16;
    const Ball& ball = balls_[v];
    for (std::uint32_t i = 0; i < ball.count; i += kEntriesALine) {
      __builtin_prefetch(entries_.data() + ball.begin + i);
    }
  }
  void prefetch_tets(VertexId v, const Vector<Tet>& tets) const {
    const Ball& ball = balls_[v];
    for (std::uint32_t i = 0; i < ball.count; ++i) {
      __builtin_prefetch(tets.data() + (entries_[ball.begin + i] >> 2));
    }
  }

  void clear(VertexId v) { balls_[v].count = 0; }

  // Adds entries to a ball, of which nothing is gone.
  void add(VertexId v, std::span<const std::uint32_t> entries) {
    Ball& ball = balls_[v];
    const auto count = static_cast<std::uint32_t>(ball.count + entries.size());
    if (count > ball.room) {
      const std::size_t begin = entries_.size();
      const std::uint32_t room = count + ball.count;  // one that grows does so again
      entries_.resize(entries_.size() + room);
      std::copy_n(entries_.data() + ball.begin, ball.count, entries_.data() + begin);
      ball.begin = begin;
      ball.room = room;
    }
    std::copy(entries.begin(), entries.end(), entries_.data() + ball.begin + ball.count);
    ball.count = count;
  }

 private:
  struct Ball {
    std::uint64_t begin = 0;
    std::uint32_t count = 0, room = 0;
  };
  VertexTets start_;
  Vector<std::uint32_t> entries_;
  Vector<Ball> balls_;
};

}  // namespace tetfusion
