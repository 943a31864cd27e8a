#include "compare/face_match.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "mesh/blocks.h"
#include "mesh/faces.h"

namespace tetfusion {

namespace {

constexpr int kBlockBits = 10;  // of vertices, in which sides are counted

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

class Matcher {
 public:
  Matcher(std::uint64_t points, const ReadCells& read, const JudgeFace& keep)
      : points_(points), read_(read), keep_(keep) {}

  Vector<CellSide> run(std::size_t most_sides) {
    count();
    const std::size_t blocks = counts_.size();
    for (std::size_t first = 0, last; first < blocks; first = last) {
      std::uint64_t sides = counts_[first];
      for (last = first + 1; last < blocks && sides + counts_[last] <= most_sides; ++last) {
        sides += counts_[last];
      }
      if (sides > 0)
        match(first << kBlockBits, std::min<std::uint64_t>(last << kBlockBits, points_), sides);
    }
    return std::move(kept_);
  }

 private:
  void count() {
    counts_.assign((points_ >> kBlockBits) + 1, 0);
    read_([&](const CellRun& run) {
      for (const Tet& t : run.tets) {
        if (names_vertex_twice(t)) continue;
        const auto order = ascending_corners(t);
        counts_[t[order[0]] >> kBlockBits] += 3;
        counts_[t[order[1]] >> kBlockBits] += 1;
      }
    });
  }

  void match(std::uint64_t begin, std::uint64_t end, std::uint64_t count) {
    collect(begin, end, count);
    sort(begin, end);
    judge(end - begin);
  }

  void collect(std::uint64_t begin, std::uint64_t end, std::uint64_t count) {
    sides_.clear();
    sides_.reserve(count);
    const auto inside = [&](VertexId v) { return v >= begin && v < end; };
    read_([&](const CellRun& run) {
      for (std::size_t c = 0; c < run.tets.size(); ++c) {
        const Tet& t = run.tets[c];
        if (names_vertex_twice(t)) continue;
        const auto [a, b, d, e] = ascending_corners(t);
        const std::uint64_t cell = run.labels.empty() ? run.first + c : run.labels[c];
        const auto side = static_cast<std::uint32_t>(4 * cell);
        if (inside(t[a])) {
          sides_.push_back({t[a], t[b], t[d], side + e});
          sides_.push_back({t[a], t[b], t[e], side + d});
          sides_.push_back({t[a], t[d], t[e], side + b});
        }
        if (inside(t[b])) sides_.push_back({t[b], t[d], t[e], side + a});
      }
    });
  }

  // By the smallest vertex.
  void sort(std::uint64_t begin, std::uint64_t end) {
    ends_.assign(end - begin + 1, 0);
    for (const CellSide& s : sides_) ++ends_[s.low - begin + 1];
    for (std::size_t v = 0; v + 1 < ends_.size(); ++v) ends_[v + 1] += ends_[v];
    sorted_.resize(sides_.size());
    for (const CellSide& s : sides_) sorted_[ends_[s.low - begin]++] = s;
  }

  void judge(std::size_t vertices) {
    constexpr std::size_t kVertices = 4096;
    std::vector<Vector<CellSide>> kept(block_count(vertices, kVertices));
    for_each_block(vertices, kVertices, [&](std::size_t b, std::size_t first, std::size_t last) {
      for (std::size_t v = first; v < last; ++v) {
        judge_vertex({sorted_.data() + (v == 0 ? 0 : ends_[v - 1]), sorted_.data() + ends_[v]},
                     &kept[b]);
      }
    });
    for (const auto& sides : kept) kept_.insert(kept_.end(), sides.begin(), sides.end());
  }

  void judge_vertex(std::span<CellSide> sides, Vector<CellSide>* kept) const {
    const auto key = [](const CellSide& s) { return std::uint64_t{s.middle} << 32 | s.high; };
    // Sides come in the order of their cells.
    std::sort(sides.begin(), sides.end(), [&](const CellSide& s, const CellSide& t) {
      return key(s) != key(t) ? key(s) < key(t) : s.side < t.side;
    });
    for (std::size_t i = 0, end; i < sides.size(); i = end) {
      for (end = i + 1; end < sides.size() && key(sides[end]) == key(sides[i]);) ++end;
      if (keep_(sides.subspan(i, end - i))) kept->push_back(sides[i]);
    }
  }

  const std::uint64_t points_;
  const ReadCells& read_;
  const JudgeFace& keep_;
  Vector<std::uint64_t> counts_;
  Vector<CellSide> sides_, sorted_;
  Vector<std::uint64_t> ends_;  // of each vertex in sorted_
  Vector<CellSide> kept_;
};

}  // namespace

Vector<CellSide> match_faces(std::uint64_t points, std::size_t most_sides, const ReadCells& read,
                             const JudgeFace& keep) {
  return Matcher(points, read, keep).run(most_sides);
}

}  // namespace tetfusion
