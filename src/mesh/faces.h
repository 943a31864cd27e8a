// The triangles of a mesh, found vertex by vertex, without a table of all faces: a face belongs to
// its smallest vertex.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

// The corners of the face opposite to a corner, wound so that the right-hand normal points out of a
// tetrahedron of positive volume.
inline constexpr std::array<std::array<std::uint8_t, 3>, 4> kFaceCorners{
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

inline bool names_vertex_twice(const Tet& t) {
  return t[0] == t[1] || t[0] == t[2] || t[0] == t[3] || t[1] == t[2] || t[1] == t[3] ||
         t[2] == t[3];
}

// One cell's side of a face.
struct FaceSide {
  std::uint64_t key;  // of the face among its smallest vertex's: middle << 32 | largest vertex
  TetId tet;
  VertexId apex;      // the cell's fourth vertex
  std::uint32_t odd;  // 1 if, seen from outside the cell, the face runs smallest, largest, middle

  VertexId middle() const { return static_cast<VertexId>(key >> 32); }
  VertexId largest() const { return static_cast<VertexId>(key); }
};

// Calls use(tet) for each cell of a face that has the vertices of another one, but for the first of
// them. A cell is met here with the face that lacks its largest vertex alone; so are its copies,
// and they have the same.
template <class Use>
void for_each_copy(std::span<const FaceSide> sides, Use use) {
  // Sorted, because hostile files have faces with very many cells.
  std::vector<std::pair<VertexId, TetId>> apexes;
  for (const FaceSide& side : sides) {
    if (side.apex >= side.largest()) apexes.emplace_back(side.apex, side.tet);
  }
  std::sort(apexes.begin(), apexes.end());
  for (std::size_t i = 1; i < apexes.size(); ++i) {
    if (apexes[i].first == apexes[i - 1].first) use(apexes[i].second);
  }
}

// Finds the faces of the vertices of a range. Cells that name a vertex twice have no faces and do
// not count. Keeps its memory from range to range: 29 bytes a cell, 16 a vertex of the range and 1
// a vertex of the mesh. One a thread.
class FaceMatcher {
 public:
  // The vertices begin up to end of a mesh with `vertices` of them. `cells`: all cells that use one
  // of them, and perhaps others; empty: all of the mesh. The tetrahedra must not change while the
  // matcher is used; there are at most kMaxTets.
  void load(std::span<const Tet> tets, std::span<const TetId> cells, VertexId begin, VertexId end,
            std::size_t vertices);

  // Loaded cells that use the vertex.
  std::uint32_t cell_count(VertexId v) const {
    const std::uint32_t* ends = ends_of(v);
    return ends[2] - ends[-2] + ends[3];
  }

  // Matches the vertex's faces the fast way. False if that does not do: two cells see a face the
  // same way round (so it is whenever there are more than two), or there are many neighbours.
  bool match(VertexId v);

  // The rest of this block is valid after match(v) was true, until the next match().
  //
  // The larger vertices with which v shares a cell.
  std::span<const VertexId> neighbours() const { return {neighbours_.data(), count_}; }
  // The number of a neighbour in neighbours().
  std::uint32_t number_of(VertexId neighbour) const { return place_[neighbour] - 1u; }
  // Calls f(m, l) for each face v, m, l with one cell; from outside the cell it runs like that.
  template <class F>
  void for_each_single(F f) const {
    if (any_single_ == 0) return;
    for (std::uint32_t m = 0; m < count_; ++m) {
      visit_bits(out_[m] & ~in_[m], [&](unsigned l) { f(neighbours_[m], neighbours_[l]); });
    }
  }
  // Calls f(m, l) for each face v, m, l with two cells, if both neighbours' bits are set.
  template <class F>
  void for_each_pair(std::uint64_t among, F f) const {
    for (std::uint32_t m = 0; m < count_; ++m) {
      if ((among >> m & 1) == 0) continue;
      visit_bits(out_[m] & in_[m] & among & ~((std::uint64_t{2} << m) - 1),
                 [&](unsigned l) { f(neighbours_[m], neighbours_[l]); });
    }
  }

  // Calls f(tet, corners) for each cell of v but those where it is the largest vertex; the corners
  // ascend.
  template <class F>
  void for_each_cell(VertexId v, F f) const {
    const std::uint32_t* ends = ends_of(v);
    for (std::uint32_t i = ends[-2]; i < ends[2]; ++i) {
      f(id_of(entries_[i] >> 1), sorted_[entries_[i] >> 1]);
    }
  }

  // Calls f(tet, apex) for each cell of the face v, m, l, whose smallest vertex is v.
  template <class F>
  void for_each_cell_of_face(VertexId v, VertexId m, VertexId l, F f) const {
    const std::uint32_t* ends = ends_of(v);
    for (std::uint32_t i = ends[-2]; i < ends[1]; ++i) {
      const Tet& t = sorted_[entries_[i] >> 1];
      const bool has_m = t[1] == m || t[2] == m || t[3] == m;
      const bool has_l = t[1] == l || t[2] == l || t[3] == l;
      if (has_m && has_l) f(id_of(entries_[i] >> 1), t[0] ^ t[1] ^ t[2] ^ t[3] ^ v ^ m ^ l);
    }
  }

  // The slow way, for any vertex: calls visit(std::span<const FaceSide>) for each face, ascending
  // by (middle, largest); the sides ascend by cell.
  template <class Visit>
  void for_each_face(VertexId v, Visit&& visit) {
    collect(v);
    for (std::size_t begin = 0, end; begin < sides_.size(); begin = end) {
      end = begin + 1;
      while (end < sides_.size() && sides_[end].key == sides_[begin].key) ++end;
      visit(std::span<const FaceSide>(sides_.data() + begin, end - begin));
    }
  }
  // The larger vertices with which v shares a cell, ascending; until the next call.
  std::span<const VertexId> larger_neighbours(VertexId v);

 private:
  static constexpr std::uint32_t kMost = 64;   // neighbours that match() can do: bits of a word
  static constexpr std::uint32_t kUsual = 12;  // most vertices have no more

  template <class F>
  static void visit_bits(std::uint64_t bits, F f) {
    for (; bits != 0; bits &= bits - 1) f(static_cast<unsigned>(std::countr_zero(bits)));
  }
  // Entries where the vertex is the smallest, second and third end at [0], [1], [2] and begin where
  // the ones before end; [-2] is the end of the vertex before. [3]: cells where it is the largest.
  const std::uint32_t* ends_of(VertexId v) const { return ends_.data() + 4 * (v - begin_) + 4; }
  TetId id_of(std::uint32_t cell) const { return cells_.empty() ? cell : cells_[cell]; }
  void collect(VertexId v);
  void forget_neighbours();

  std::span<const TetId> cells_;
  VertexId begin_ = 0;
  Vector<Tet> sorted_;             // corners ascend
  Vector<std::uint8_t> odd_;       // whether sorting them was an odd number of swaps
  Vector<std::uint32_t> entries_;  // cell << 1 | whether sorting its corners was odd
  Vector<std::uint32_t> ends_;

  // Of match(): the neighbours, and the edges opposite to the vertex in its faces, as seen from
  // outside: bit l of out_[m] and bit m of in_[l] are set for the edge from m to l.
  std::uint32_t count_ = 0;
  std::array<VertexId, kMost + 4> neighbours_{};
  std::array<std::uint64_t, kMost + 4> out_{};
  std::array<std::uint64_t, kMost + 4> in_{};
  std::uint64_t any_single_ = 0;  // 0: no face has one cell
  Vector<std::uint8_t> place_;    // number in neighbours_, plus 1; 0: none

  Vector<FaceSide> sides_;
  Vector<VertexId> larger_;
};

}  // namespace tetfusion
