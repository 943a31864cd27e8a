// Which chunks have tetrahedra of each point: found in one pass over the tetrahedra, in any order,
// in four bytes a point and eight bytes for every point on the interface of more than two chunks.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>

#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

class VertexChunks {
 public:
  static constexpr std::uint32_t kMaxChunks = 0x7FFF;

  explicit VertexChunks(std::size_t points);

  // A point's chunk on the curve, below kMaxChunks. Different points from several threads.
  void set_home(VertexId v, std::uint32_t chunk) { places_[v] = kNoneAway | chunk; }

  // Notes, for a run of tetrahedra, that chunks have their points. One a thread; what it holds goes
  // to the table with hand_over(), after which nothing is added.
  class Notes {
   public:
    explicit Notes(VertexChunks* table) : table_(table) {
      recent_.assign(kRecent, ~std::uint64_t{0});
    }
    void hand_over();
    Notes(const Notes&) = delete;
    Notes& operator=(const Notes&) = delete;
    void add(VertexId v, std::uint32_t chunk);
    // Of a tetrahedron in the lowest of its points' own chunks, which it returns.
    std::uint32_t add(const Tet& tet);

   private:
    static constexpr std::size_t kRecent = 4096;
    VertexChunks* table_;
    Vector<std::uint64_t> more_;    // point << 16 | chunk
    Vector<std::uint64_t> recent_;  // of those
  };

  // After the last note.
  void finish();

  // The chunks that have tetrahedra of the point, ascending, appended to *chunks. After finish();
  // from several threads.
  void chunks_of(VertexId v, Vector<std::uint32_t>* chunks) const;

  bool is_used(VertexId v) const {
    return (places_[v] & kAtHome) != 0 || (places_[v] & kNoneAway) != kNoneAway;
  }

  std::size_t points() const { return places_.size(); }

 private:
  std::uint32_t place(VertexId v) const {
    // Reading does not write, but there is no atomic reference to what is const before C++26.
    auto& place = const_cast<std::uint32_t&>(places_[v]);
    return std::atomic_ref(place).load(std::memory_order_relaxed);
  }

  // Of a place: the home chunk in the low bits; whether it has tetrahedra of the point; one other
  // chunk that has in the upper half.
  static constexpr std::uint32_t kChunkBits = 0x7FFF;
  static constexpr std::uint32_t kAtHome = 0x8000;
  static constexpr std::uint32_t kNoneAway = 0xFFFF0000;

  Vector<std::uint32_t> places_;
  std::mutex mutex_;
  Vector<std::uint64_t> more_;  // point << 16 | chunk: other chunks beyond the first
  std::size_t sorted_ = 0;      // so many of them are sorted and differ
};

}  // namespace tetfusion
