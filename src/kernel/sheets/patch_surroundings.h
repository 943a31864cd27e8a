// A part of the boundary moves: may it meet another part of it?
#pragma once

#include <vector>

#include "kernel/sheets/boundary_triangles.h"
#include "kernel/sheets/local_frame.h"
#include "kernel/sheets/patch_distance.h"
#include "kernel/sheets/sheets.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// As in FuseLimits, and the triangles by the grid's cells.
struct SurroundingsLimits {
  double deviation_before = 0;         // so far has a sheet moved at most, in the unit
  const FacingGrid* facing = nullptr;  // null: nothing is in the way
  BoundaryTriangles* triangles = nullptr;
  // The boundary moves but where it is the only part of it that is in reach.
  bool stays_alone = false;
};

// The triangles round a pair, or on one side of it, and what takes their place; in the pair's
// frame.
struct MovingPatch {
  PatchChange change;
  std::vector<Triangle3> old;  // what goes, as it is
  // Where a line moves, the change begins with the line in its new place, at most so far away.
  double outline_moved = 0;
};

// Not thread-safe: the triangles are not.
template <class Real>
class PatchSurroundings {
 public:
  // Mesh, grid and triangles outlive this.
  void begin(const WorkMesh<Real>* mesh, const SurroundingsLimits& limits);

  // The pair in hand, in its frame; a partner that is fixed stays where it is.
  void choose(const LocalFrame<Real>& frame, VertexId v, VertexId partner, bool fixed);

  // The patch moves so far, and the sheet round the pair has moved by `moved_before` since the
  // round began.
  bool may_meet_another(const MovingPatch& patch, const PatchDistance& distance,
                        double moved_before) const;
  // Where sheets stay alone: is the patch, which moves so far in all, the only one in reach? Its
  // vertices have a deviation already.
  bool is_alone(const MovingPatch& patch, double distance, double deviation_before) const;

  // The pair has become one vertex: its new triangles, for those who come after. The fan is that of
  // one of the two, and begins with the other.
  void note_fused(VertexId kept, const Point3& position, const SheetFan& fan) const;

 private:
  // Along the patch's normal.
  struct Heights {
    double least;  // of the old patch and of the fan
    double most_of_fan;
  };
  // Else the pair lies between regions, with volume on both sides.
  bool is_boundary() const { return (mesh_->marks[v_] & kOnBoundary) != 0; }
  Point3 at(VertexId u) const { return frame_.local(mesh_->positions[u]); }
  static Heights heights_along(const MovingPatch& patch, const Point3& normal);
  bool meets_another(const MovingPatch& patch, const Point3& normal) const;
  bool is_in_the_way(const BoundaryTriangles::Corners& corners, const MovingPatch& patch,
                     const FacingBox& box, const Point3& normal, const Heights& heights) const;

  const WorkMesh<Real>* mesh_ = nullptr;
  SurroundingsLimits limits_;
  LocalFrame<Real> frame_;
  VertexId v_ = kNoVertex, partner_ = kNoVertex;
  bool fixed_ = false;
};

extern template class PatchSurroundings<float>;
extern template class PatchSurroundings<double>;

}  // namespace tetfusion
