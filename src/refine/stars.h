// The tetrahedra of each vertex, as lists that grow.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "io/files/paged_array.h"
#include "mesh/geometry.h"

namespace tetfusion {

class Stars {
 public:
  // `folder` as in PagedBytes.
  Stars(const std::string& folder, std::uint64_t vertices, std::uint64_t tets);

  std::span<const TetId> of(VertexId v) const {
    return {entries_.data() + at(lists_[v].begin), lists_[v].count};
  }
  void add(VertexId v, TetId tet);
  void replace(VertexId v, std::span<const TetId> tets);

  // A number beside each list, 0 at first, for whoever needs one where the list is touched, too.
  std::uint32_t& stamp(VertexId v) { return lists_[v].stamp; }
  const std::uint32_t& stamp(VertexId v) const { return lists_[v].stamp; }

  // Hints: the list, and what is in it, will be wanted soon.
  void expect(VertexId v) const { __builtin_prefetch(&lists_[v]); }
  void expect_entries(VertexId v) const {
    const TetId* begin = entries_.data() + at(lists_[v].begin);
    for (std::uint32_t i = 0; i < lists_[v].count; i += kLine) __builtin_prefetch(begin + i);
  }

  void expect_end(VertexId v) const {
    __builtin_prefetch(entries_.data() + at(lists_[v].begin) + lists_[v].count, 1);
  }

  std::uint64_t size() const { return lists_.size(); }
  void let_go() const;

 private:
  // Rooms begin at multiples of so many entries.
  static constexpr std::uint32_t kUnit = 4;
  static constexpr std::uint32_t kLine = 16;
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;
  struct List {
    std::uint32_t begin = 0;  // in units
    std::uint32_t count = 0, room = 0;
    std::uint32_t stamp = 0;
  };
  static std::uint64_t at(std::uint32_t unit) { return std::uint64_t{unit} * kUnit; }
  void make_room(List* list, std::uint32_t count);

  PagedArray<List> lists_;
  PagedArray<TetId> entries_;
  // Rooms that are free, by their units: the first one of each size, which holds the next one.
  std::vector<std::uint32_t> free_;
};

}  // namespace tetfusion
