#include "mesh/faces.h"

#include <algorithm>

namespace tetfusion {

namespace {

// The place of each corner among the four when they are sorted, and whether sorting them swaps an
// odd number of times. Without branches, because half of them would be guessed wrong.
struct Ranks {
  explicit Ranks(const Tet& t) {
    const std::uint32_t ab = t[0] > t[1], ac = t[0] > t[2], ad = t[0] > t[3];
    const std::uint32_t bc = t[1] > t[2], bd = t[1] > t[3], cd = t[2] > t[3];
    of = {ab + ac + ad, 1 - ab + bc + bd, 2 - ac - bc + cd, 3 - ad - bd - cd};
    odd = ab ^ ac ^ ad ^ bc ^ bd ^ cd;
  }
  std::array<std::uint32_t, 4> of;
  std::uint32_t odd;
};

}  // namespace

void FaceMatcher::load(std::span<const Tet> tets, std::span<const TetId> cells, VertexId begin,
                       VertexId end, std::size_t vertices) {
  if (!place_.empty()) forget_neighbours();
  neighbours_ = {};
  place_.resize(std::max<std::size_t>(vertices, 1), 0);
  cells_ = cells;
  begin_ = begin;
  const std::size_t count = cells.empty() ? tets.size() : cells.size();
  const VertexId size = end - begin;
  sorted_.resize(count);
  odd_.resize(count);
  entries_.resize(3 * count);
  ends_.assign(4 * (std::size_t{size} + 2), 0);

  // All that lies outside the range is counted as one more vertex.
  std::uint32_t* const slots = ends_.data() + 4;
  const auto slot_of = [&](VertexId v) {
    return slots + 4 * std::size_t{std::min(v - begin, size)};
  };
  for (std::size_t i = 0; i < count; ++i) {
    const Tet& t = tets[cells.empty() ? i : cells[i]];
    Tet& sorted = sorted_[i];
    if (names_vertex_twice(t)) {
      sorted = {end, end, end, end};
      odd_[i] = 0;
      for (std::uint32_t rank = 0; rank < 3; ++rank) ++slots[4 * std::size_t{size} + rank];
      continue;
    }
    const Ranks ranks(t);
    odd_[i] = static_cast<std::uint8_t>(ranks.odd);
    for (std::uint32_t corner = 0; corner < 4; ++corner) {
      sorted[ranks.of[corner]] = t[corner];
      ++slot_of(t[corner])[ranks.of[corner]];
    }
  }
  // Slots become where to put the next entry, which in the end is where its entries end.
  std::uint32_t sum = 0;
  for (std::size_t s = 0; s < 4 * (std::size_t{size} + 1); ++s) {
    if (s % 4 == 3) continue;
    const std::uint32_t n = slots[s];
    slots[s] = sum;
    sum += n;
  }
  std::uint32_t* const entries = entries_.data();
  for (std::size_t i = 0; i < count; ++i) {
    const auto entry = static_cast<std::uint32_t>(i << 1 | odd_[i]);
    const Tet& t = sorted_[i];
    for (std::uint32_t rank = 0; rank < 3; ++rank) entries[slot_of(t[rank])[rank]++] = entry;
  }
}

void FaceMatcher::forget_neighbours() {
  // A fixed number at least, because a varying one is often guessed wrong: it does no harm to
  // forget what is not there.
  for (std::uint32_t i = 0; i < std::max(count_, kUsual); ++i) {
    place_[neighbours_[i]] = 0;
    out_[i] = 0;
    in_[i] = 0;
  }
  count_ = 0;
}

bool FaceMatcher::match(VertexId v) {
  forget_neighbours();
  // No branches in what follows: whether a neighbour is new, and which way a cell's corners run, is
  // guessed wrong too often.
  std::uint32_t count = 0;
  std::uint64_t twice = 0;  // not 0: an edge was there already
  const auto place = [&, places = place_.data()](VertexId w) {
    const std::uint32_t known = places[w];
    const std::uint32_t is_new = (known - 1) >> 31;
    neighbours_[count] = w;
    count += is_new;
    const std::uint32_t number = known | (count & (0 - is_new));
    places[w] = static_cast<std::uint8_t>(number);
    return number - 1;
  };
  // From a to b, or the other way if odd.
  const auto add_edge = [&](std::uint32_t a, std::uint32_t b, std::uint32_t odd) {
    const std::uint32_t swap = (a ^ b) & (0 - odd);
    const std::uint32_t from = a ^ swap, to = b ^ swap;
    twice |= out_[from] >> to & 1;
    out_[from] |= std::uint64_t{1} << to;
    in_[to] |= std::uint64_t{1} << from;
  };
  const std::uint32_t* const ends = ends_of(v);
  const std::uint32_t* entry = entries_.data() + ends[-2];
  const std::uint32_t* const firsts_end = entries_.data() + ends[0];
  const std::uint32_t* const seconds_end = entries_.data() + ends[1];
  const std::uint32_t* const thirds_end = entries_.data() + ends[2];
  for (; entry != firsts_end && count <= kMost - 3; ++entry) {
    const Tet& t = sorted_[*entry >> 1];
    const std::uint32_t b = place(t[1]), c = place(t[2]), d = place(t[3]);
    const std::uint32_t odd = *entry & 1;
    add_edge(c, b, odd);
    add_edge(b, d, odd);
    add_edge(d, c, odd);
  }
  for (; entry != seconds_end && count <= kMost - 3; ++entry) {
    const Tet& t = sorted_[*entry >> 1];
    const std::uint32_t c = place(t[2]), d = place(t[3]);
    add_edge(c, d, *entry & 1);
  }
  for (; entry != thirds_end && count <= kMost - 3; ++entry) place(sorted_[*entry >> 1][3]);
  count_ = count;
  any_single_ = 0;
  for (std::uint32_t m = 0; m < std::max(count, kUsual); ++m) any_single_ |= out_[m] ^ in_[m];
  return twice == 0 && count <= kMost - 3;
}

void FaceMatcher::collect(VertexId v) {
  sides_.clear();
  const std::uint32_t* const ends = ends_of(v);
  const auto add = [&](std::uint32_t entry, VertexId middle, VertexId largest, VertexId apex,
                       std::uint32_t odd) {
    sides_.push_back({std::uint64_t{middle} << 32 | largest, id_of(entry >> 1), apex, odd});
  };
  for (std::uint32_t i = ends[-2]; i < ends[1]; ++i) {
    const Tet& t = sorted_[entries_[i] >> 1];
    const std::uint32_t odd = entries_[i] & 1;
    if (i < ends[0]) {
      add(entries_[i], t[1], t[2], t[3], odd ^ 1);
      add(entries_[i], t[1], t[3], t[2], odd);
      add(entries_[i], t[2], t[3], t[1], odd ^ 1);
    } else {
      add(entries_[i], t[2], t[3], t[0], odd);
    }
  }
  std::sort(sides_.begin(), sides_.end(), [](const FaceSide& a, const FaceSide& b) {
    return a.key != b.key ? a.key < b.key : a.tet < b.tet;
  });
}

std::span<const VertexId> FaceMatcher::larger_neighbours(VertexId v) {
  larger_.clear();
  for_each_cell(v, [&](TetId, const Tet& t) {
    for (const VertexId w : t) {
      if (w > v) larger_.push_back(w);
    }
  });
  std::sort(larger_.begin(), larger_.end());
  larger_.erase(std::unique(larger_.begin(), larger_.end()), larger_.end());
  return larger_;
}

}  // namespace tetfusion
