// What shapes the tetrahedra round a vertex would have if it came to another position: four of them
// at a time, in single precision, with what rounding may do to them.
//
// A tetrahedron has the base triangle (b, c, d) with the centre g. If its vertex comes to x, six
// times its volume is m.(x - g), with m = (d - b) x (c - b), and the squares of its edges sum up to
// 3 |x - g|^2 and 4/3 of those of the base triangle: seven numbers a tetrahedron, however many
// places are tried.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "base/lanes.h"
#include "base/vector.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Positions as whole numbers of 2^-29 or less of the mesh's extent: differences of near ones lose
// nothing in single precision.
template <class Real>
class GridPositions {
 public:
  void reset(const Vector<Vec3<Real>>& positions);
  void move(VertexId v, const Vec3<Real>& position);
  LaneMask at(VertexId v) const { return points_[v]; }  // x, y, z, and nothing
  // In units of the grid.
  std::array<double, 3> on_grid(const Vec3<Real>& position) const;
  // Whether no position is further from where it should be than half a unit.
  bool holds() const { return holds_; }

 private:
  std::array<double, 3> origin_{};
  double scale_ = 1;
  bool holds_ = true;
  Vector<LaneMask> points_;
};

// Cubed mean ratios over 432: from `sure` on a shape is good, below `floor` it is bad.
struct ShapeFloors {
  float sure = 0, floor = 0;
};

// Keeps its memory from ball to ball.
template <class Real>
class BallShapes {
 public:
  // The ball of v, as entries (LiveBalls), the mesh, and the positions are to stay as they are
  // until the next call, or forget().
  void begin(const WorkMesh<Real>& mesh, const GridPositions<Real>& grid, VertexId v,
             std::span<const std::uint32_t> ball);
  // To be called before anything is asked about the entries from `first` on, a multiple of kLanes,
  // and for those in front of it first: whoever is refused early needs no more of the ball.
  void gather(std::size_t first) {
    if (first == gathered_) gather_next();
  }
  VertexId vertex() const { return vertex_; }
  void forget() { vertex_ = kNoVertex; }

  std::span<const std::uint32_t> entries() const { return entries_; }
  // Appends the entries of tetrahedra that have not this vertex, and the tetrahedra that have.
  void list(VertexId other, Vector<std::uint32_t>* without, Vector<TetId>* with) const;

  // A position as the ball sees it: about the vertex, in the unit.
  struct LocalPosition {
    std::array<float, 3> x;
    float far;  // the largest coordinate
  };
  LocalPosition local(const Vec3<Real>& position) const;
  // Lane by lane, of the entries from `first` on, a multiple of kLanes (behind the last one there
  // are copies of it): which tetrahedra are certainly good? What has the vertex `other` is: it is
  // deleted.
  LaneMask good(std::size_t first, const LocalPosition& local, VertexId other,
                const ShapeFloors& floors) const;
  // Which of them are certainly bad, and which of these flipped?
  LaneMask bad(std::size_t first, const LocalPosition& local, const ShapeFloors& floors) const;
  LaneMask flipped(std::size_t first, const LocalPosition& local) const;
  // When the vertex has come to the position: the entry of the tetrahedron that has that where it
  // is now, but for rounding. None if that is one that has `other`, or none of the ball.
  std::optional<std::uint32_t> entry_of_vertex(const LocalPosition& local, VertexId other) const;
  // May a tetrahedron be below the floor now? Gathers all.
  bool may_have_bad(const ShapeFloors& floors);

 private:
  // Squares of what is below this may be no numbers any more.
  static constexpr float kTiny = 1e-15F;
  // What rounding does to m.(x - g), as a share of the edges' squares times the largest coordinate,
  // is below nine times 2^-24: coordinates are rounded once, centres and edges of them again, and
  // products and sums of these. What it does to the squares themselves counts a twentieth of that,
  // as the determinant is compared with no more than a twentieth of their power 3/2.
  static constexpr float kRounding = 1.0F / (1 << 20);
  struct Group {
    std::array<Lanes, 3> normal, centre;
    Lanes edges;
    float reach;  // the largest coordinate, and what the grid does to it
    std::array<std::array<Lanes, 3>, 3> base;
    std::array<LaneMask, 4> corners;
    LaneMask have(VertexId v) const {
      const LaneMask id = LaneMask{} + static_cast<std::int32_t>(v);
      return (corners[0] == id) | (corners[1] == id) | (corners[2] == id) | (corners[3] == id);
    }
  };

  // At a position: six times the volume, the edges' squares, what rounding may do to the volume,
  // and whether anything is known of these.
  struct Shapes {
    Lanes det, edges, error;
    LaneMask known;
  };
  Shapes shapes(std::size_t first, const LocalPosition& local) const;
  void gather_next();

  const WorkMesh<Real>* mesh_ = nullptr;
  const GridPositions<Real>* grid_ = nullptr;
  VertexId vertex_ = kNoVertex;
  LaneMask origin_{};
  float scale_ = 1;
  float grid_reach_ = 0;  // a unit of the grid is like rounding of a coordinate so large
  std::size_t gathered_ = 0;
  std::span<const std::uint32_t> entries_;
  Vector<Group> groups_;
};

template <class Real>
inline auto BallShapes<Real>::shapes(std::size_t first, const LocalPosition& local) const
    -> Shapes {
  // In squares of the error: of smaller edges nothing is known. Nor of larger ones, whose cubes
  // would be none.
  constexpr float kLeastEdges = 256;
  constexpr float kMostEdges = 4e12F;
  const Group& group = groups_[first / kLanes];
  const Lanes x = local.x[0] - group.centre[0];
  const Lanes y = local.x[1] - group.centre[1];
  const Lanes z = local.x[2] - group.centre[2];
  const Lanes det = group.normal[0] * x + group.normal[1] * y + group.normal[2] * z;
  const Lanes edges = 3.0F * (x * x + y * y + z * z) + group.edges;
  const float error = kRounding * std::max(group.reach, local.far);
  const LaneMask known = (edges > kLeastEdges * error * error) & (edges < kMostEdges);
  return {det, edges, error * edges, known};
}

template <class Real>
inline LaneMask BallShapes<Real>::good(std::size_t first, const LocalPosition& local,
                                       VertexId other, const ShapeFloors& floors) const {
  const auto [det, edges, error, known] = shapes(first, local);
  const Lanes least = det - error;
  return groups_[first / kLanes].have(other) |
         (known & (least > kTiny) & (least * least >= floors.sure * (edges * edges * edges)));
}

template <class Real>
inline LaneMask BallShapes<Real>::bad(std::size_t first, const LocalPosition& local,
                                      const ShapeFloors& floors) const {
  const auto [det, edges, error, known] = shapes(first, local);
  const Lanes most = det + error;
  return known & ((most <= 0.0F) |
                  ((most > kTiny) & (most * most < floors.floor * (edges * edges * edges))));
}

template <class Real>
inline LaneMask BallShapes<Real>::flipped(std::size_t first, const LocalPosition& local) const {
  return shapes(first, local).det <= 0.0F;
}

extern template class GridPositions<float>;
extern template class GridPositions<double>;
extern template class BallShapes<float>;
extern template class BallShapes<double>;

}  // namespace tetfusion
