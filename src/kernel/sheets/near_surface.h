// The surface round two vertices that become one, as it will be: what of it is nearest to a point
// of the original that has come to lie outside?
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kernel/joining.h"
#include "kernel/live_balls.h"
#include "kernel/point3.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// The point of a triangle that is nearest to another one, by the weights of its corners.
struct NearestOnTriangle3 {
  std::array<double, 3> weights{};
  Point3 at{};
  double squared = 0;  // of the distance
};
NearestOnTriangle3 nearest_on(const Point3& x, const std::array<Point3, 3>& corners);

// So far from a surface, in the unit, a point counts as lying on it.
inline constexpr double kOnSurface = 0x1p-17;

// All lengths are in the unit. Keeps its memory from pair to pair. Not thread-safe.
template <class Real>
class NearSurface {
 public:
  // A triangle that may lie on the surface; all that do are among these.
  struct Face {
    std::array<VertexId, 3> ids;  // the new vertex has the partner's id, if that stays, else v's
    std::array<Point3, 3> at;
    TetId tet;
    std::uint32_t entry;  // of the affected ones; kUnaffected: it stays as it is
    // The corner that is not in it: of affected ones the new vertex is the first, so that with 0
    // it lies opposite to that.
    std::uint8_t omitted;
  };
  static constexpr std::uint32_t kUnaffected = 0xFFFFFFFFu;
  struct Hit {
    const Face* face;  // good until the next set()
    NearestOnTriangle3 nearest;
  };

  // The surface may move so far, in the unit. Mesh and balls outlive this.
  void begin(const WorkMesh<Real>* mesh, LiveBalls* balls, double unit, double max_deviation);

  // The fusion in hand. Those of the same pair in succession share what they can.
  void set(const Joining<Real>& joining);
  // To be called when the mesh has changed.
  void forget() { joining_ = {}; }

  // Does the surface move?
  bool moves() const { return moves_; }

  // Finds the faces of affected tetrahedra that are nearest to a point outside: one first, then
  // others that are as near but for rounding. Returns the squared distance.
  double find(const Vec3<Real>& p, std::vector<Hit>* hits);

  // Adds what else there is. False if something that is not known here might be nearer, or come
  // nearer later on.
  bool settle(const Vec3<Real>& p, std::vector<Hit>* hits);

  // Looks at what touches the patch; false if some of it is not here. Its tetrahedra are
  // neighbours() then.
  bool know_neighbours();
  const std::vector<TetId>& neighbours() const { return ring_tets_; }
  // Does a point of a neighbour, if it is outside, stay nearest to that?
  bool spares(TetId neighbour, const Vec3<Real>& p) const;

 private:
  struct Segment {
    Point3 from, to;
  };
  bool is_on(VertexId v) const { return (mesh_->marks[v] & kOnBoundary) != 0; }
  Point3 about_v(const Vec3<Real>& p) const;
  bool is_in_cavity(const Tet& tet) const;
  void know_faces();
  void know_faces_behind();
  void look_at(const Point3& x, const std::vector<Face>& faces, std::vector<Hit>* hits) const;
  void find_ring();
  void collect_ring(VertexId u);
  void note_ring_face(const Tet& tet, TetId t, std::uint8_t omitted);
  bool is_inside(TetId t, const Vec3<Real>& p) const;
  bool is_within(const Hit& hit) const;
  bool is_clear(const Hit& hit) const;

  const WorkMesh<Real>* mesh_ = nullptr;
  LiveBalls* balls_ = nullptr;
  double unit_ = 1;
  bool may_move_ = false;

  Joining<Real> joining_;
  VertexId apex_ = kNoVertex;
  bool moves_ = false;
  bool faces_known_ = false, ring_known_ = false;
  std::vector<Face> faces_;
  std::vector<Segment> outline_;

  // What touches the patch.
  bool ring_is_whole_ = false;
  std::vector<VertexId> ring_;
  std::vector<Face> ring_faces_;
  std::vector<TetId> ring_tets_;
  std::vector<Segment> ring_outline_;
  Vector<std::uint32_t> stamp_;
  std::uint32_t stamped_ = 0;
};

extern template class NearSurface<float>;
extern template class NearSurface<double>;

}  // namespace tetfusion
