#include "compare/face_match.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <utility>
#include <vector>

#include "base/blocks.h"
#include "base/mix.h"
#include "mesh/faces.h"

namespace tetfusion {

namespace {

// Vertices are in blocks of so many bits, whose sides a processor's cache holds.
constexpr int kBlockBits = 8;
// What a task takes.
constexpr std::size_t kTets = 8192;
constexpr std::size_t kBlocks = 16;

// The corner numbers in ascending order of the vertices.
std::array<std::uint32_t, 4> ascending_corners(const Tet& t) {
  std::array<std::uint32_t, 4> order{0, 1, 2, 3};
  const auto sort2 = [&](int i, int j) {
    if (t[order[i]] > t[order[j]]) std::swap(order[i], order[j]);
  };
  sort2(0, 1);
  sort2(2, 3);
  sort2(0, 2);
  sort2(1, 3);
  sort2(1, 2);
  return order;
}

// Calls take(tet, number in the run, corners ascending) for all that have triangles. From several
// threads.
template <class F>
void for_each_tet(const CellRun& run, F take) {
  for_each_block(run.tets.size(), kTets, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      const Tet& t = run.tets[c];
      if (!names_vertex_twice(t)) take(t, c, ascending_corners(t));
    }
  });
}

// Of a triangle's two larger vertices: another one for each pair, and without pattern.
std::uint64_t edge(VertexId middle, VertexId high) {
  return mix(std::uint64_t{middle} << 32 | high);
}

// Tells vertices all of whose triangles have an even number of sides from the others, without
// holding sides: what a vertex's triangles mix to is added up by exclusive or, so that pairs cancel
// each other.
class OddFaces {
 public:
  OddFaces(std::uint64_t points, const ReadCells& read) {
    sums_.assign(points, 0);
    read([&](const CellRun& run) {
      for_each_tet(run, [&](const Tet& t, std::size_t, const auto& order) {
        const VertexId a = t[order[0]], b = t[order[1]], c = t[order[2]], d = t[order[3]];
        add(a, edge(b, c) ^ edge(b, d) ^ edge(c, d));
        add(b, edge(c, d));
      });
    });
  }
  // As the smallest vertex of a triangle.
  Vector<bool> vertices() const {
    Vector<bool> odd(sums_.size());
    for (std::size_t v = 0; v < sums_.size(); ++v) odd[v] = sums_[v] != 0;
    return odd;
  }

 private:
  void add(VertexId v, std::uint64_t mixed) {
    std::atomic_ref(sums_[v]).fetch_xor(mixed, std::memory_order_relaxed);
  }

  Vector<std::uint64_t> sums_;
};

class Matcher {
 public:
  // Of triangles whose smallest vertex is `wanted`; if that is empty, of all.
  Matcher(std::uint64_t points, const ReadCells& read, const JudgeFace& keep,
          Vector<bool> wanted = {})
      : read_(read), keep_(keep), wanted_(std::move(wanted)), blocks_((points >> kBlockBits) + 1) {
    ends_.assign(blocks_, 0);
  }

  Vector<CellSide> run(std::size_t most_sides) {
    count();
    for (std::size_t first = 0, last; first < blocks_; first = last) {
      std::uint64_t sides = ends_[first];
      for (last = first + 1; last < blocks_ && sides + ends_[last] <= most_sides; ++last) {
        sides += ends_[last];
      }
      if (sides > 0) match(first, last, sides);
    }
    return std::move(kept_);
  }

 private:
  bool is_wanted(VertexId v) const { return wanted_.empty() || wanted_[v]; }
  // Adds to a number that other threads add to. Returns what it was.
  static std::uint64_t add_to(std::uint64_t* number, std::uint64_t count) {
    return std::atomic_ref(*number).fetch_add(count, std::memory_order_relaxed);
  }

  void count() {
    read_([&](const CellRun& run) {
      for_each_tet(run, [&](const Tet& t, std::size_t, const auto& order) {
        const VertexId low = t[order[0]], next = t[order[1]];
        if (is_wanted(low)) add_to(&ends_[low >> kBlockBits], 3);
        if (is_wanted(next)) add_to(&ends_[next >> kBlockBits], 1);
      });
    });
  }

  // Blocks [first, last) have so many sides.
  void match(std::size_t first, std::size_t last, std::uint64_t sides) {
    sides_.resize(sides);
    std::uint64_t begin = 0;
    for (std::size_t b = first; b < last; ++b) begin += std::exchange(ends_[b], begin);
    collect(first, last);
    judge(first, last);
  }

  // Into their blocks, in any order.
  void collect(std::size_t first, std::size_t last) {
    read_([&](const CellRun& run) {
      for_each_tet(run, [&](const Tet& t, std::size_t c, const auto& order) {
        const auto [a, b, d, e] = order;
        const std::uint64_t cell = run.labels.empty() ? run.first + c : run.labels[c];
        const auto side = static_cast<std::uint32_t>(4 * cell);
        const std::size_t low = t[a] >> kBlockBits, next = t[b] >> kBlockBits;
        if (low >= first && low < last && is_wanted(t[a])) {
          CellSide* const to = sides_.data() + add_to(&ends_[low], 3);
          to[0] = {t[a], t[b], t[d], side + e};
          to[1] = {t[a], t[b], t[e], side + d};
          to[2] = {t[a], t[d], t[e], side + b};
        }
        if (next >= first && next < last && is_wanted(t[b])) {
          sides_[add_to(&ends_[next], 1)] = {t[b], t[d], t[e], side + a};
        }
      });
    });
  }

  void judge(std::size_t first, std::size_t last) {
    std::vector<Vector<CellSide>> kept(block_count(last - first, kBlocks));
    for_each_block(last - first, kBlocks, [&](std::size_t i, std::size_t from, std::size_t to) {
      Vector<CellSide> sorted;
      for (std::size_t b = from; b < to; ++b) {
        const std::uint64_t begin = b == 0 ? 0 : ends_[first + b - 1];
        judge_block({sides_.data() + begin, sides_.data() + ends_[first + b]}, &sorted, &kept[i]);
      }
    });
    for (const auto& sides : kept) kept_.insert(kept_.end(), sides.begin(), sides.end());
  }

  void judge_block(std::span<const CellSide> sides, Vector<CellSide>* sorted,
                   Vector<CellSide>* kept) const {
    constexpr std::size_t kVertices = std::size_t{1} << kBlockBits;
    std::array<std::uint32_t, kVertices + 1> ends{};
    for (const CellSide& s : sides) ++ends[s.low % kVertices + 1];
    for (std::size_t v = 0; v < kVertices; ++v) ends[v + 1] += ends[v];
    sorted->resize(sides.size());
    for (const CellSide& s : sides) (*sorted)[ends[s.low % kVertices]++] = s;
    for (std::size_t v = 0, begin = 0; v < kVertices; begin = ends[v++]) {
      judge_vertex({sorted->data() + begin, sorted->data() + ends[v]}, kept);
    }
  }

  void judge_vertex(std::span<CellSide> sides, Vector<CellSide>* kept) const {
    const auto key = [](const CellSide& s) { return std::uint64_t{s.middle} << 32 | s.high; };
    std::sort(sides.begin(), sides.end(), [&](const CellSide& s, const CellSide& t) {
      return key(s) != key(t) ? key(s) < key(t) : s.side < t.side;
    });
    for (std::size_t i = 0, end; i < sides.size(); i = end) {
      for (end = i + 1; end < sides.size() && key(sides[end]) == key(sides[i]);) ++end;
      if (keep_(sides.subspan(i, end - i))) kept->push_back(sides[i]);
    }
  }

  const ReadCells& read_;
  const JudgeFace& keep_;
  const Vector<bool> wanted_;
  const std::size_t blocks_;
  Vector<std::uint64_t> ends_;  // of each block: how many sides; then where they end in sides_
  Vector<CellSide> sides_;
  Vector<CellSide> kept_;
};

}  // namespace

Vector<CellSide> match_faces(std::uint64_t points, std::size_t most_sides, const ReadCells& read,
                             const JudgeFace& keep) {
  return Matcher(points, read, keep).run(most_sides);
}

Vector<CellSide> find_single_sides(std::uint64_t points, std::size_t most_sides,
                                   const ReadCells& read) {
  const JudgeFace keep = [](std::span<const CellSide> face) { return face.size() == 1; };
  return Matcher(points, read, keep, OddFaces(points, read).vertices()).run(most_sides);
}

}  // namespace tetfusion
