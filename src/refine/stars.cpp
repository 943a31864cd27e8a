#include "refine/stars.h"

#include <algorithm>

namespace tetfusion {

namespace {

constexpr std::uint32_t kFreeSizes = 64;

}  // namespace

Stars::Stars(const std::string& folder, std::uint64_t vertices, std::uint64_t tets)
    : lists_(folder, vertices), entries_(folder, 6 * tets), free_(kFreeSizes, kNone) {
  entries_.resize(0);
}

// Rooms that are left are taken again, by who needs as much.
void Stars::make_room(List* list, std::uint32_t count) {
  if (count <= list->room) return;
  const std::uint32_t units = (count + count / 4 + kUnit - 1) / kUnit;
  std::uint32_t begin = units < kFreeSizes ? free_[units] : kNone;
  if (begin != kNone) {
    free_[units] = entries_[at(begin)];
  } else {
    begin = static_cast<std::uint32_t>(entries_.size() / kUnit);
    entries_.resize(entries_.size() + at(units));
  }
  std::copy_n(entries_.data() + at(list->begin), list->count, entries_.data() + at(begin));
  const std::uint32_t old = list->room / kUnit;
  if (old > 0 && old < kFreeSizes) {
    entries_[at(list->begin)] = free_[old];
    free_[old] = list->begin;
  }
  list->begin = begin;
  list->room = units * kUnit;
}

void Stars::add(VertexId v, TetId tet) {
  List& list = lists_[v];
  make_room(&list, list.count + 1);
  entries_[at(list.begin) + list.count++] = tet;
}

void Stars::replace(VertexId v, std::span<const TetId> tets) {
  List& list = lists_[v];
  list.count = 0;
  make_room(&list, static_cast<std::uint32_t>(tets.size()));
  std::copy(tets.begin(), tets.end(), entries_.data() + at(list.begin));
  list.count = static_cast<std::uint32_t>(tets.size());
}

void Stars::let_go() const {
  lists_.let_go();
  entries_.let_go();
}

}  // namespace tetfusion
