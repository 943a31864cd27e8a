// Two vertices of a sheet become one: may they, and how far does the sheet move?
#pragma once

#include <optional>
#include <span>

#include "kernel/boundary_triangles.h"
#include "kernel/edge_costs.h"
#include "kernel/patch_distance.h"
#include "kernel/sheet_patch.h"
#include "kernel/sheets.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

struct SheetLimits {
  double unit = 1;              // of lengths
  double max_deviation = 0;     // so far may a sheet move, in the unit
  double deviation_before = 0;  // so far has one moved at most
  // As in FuseLimits, and the triangles by its cells. Null: nothing is in the way.
  const FacingGrid* facing = nullptr;
  BoundaryTriangles* triangles = nullptr;
  // The boundary moves but where it is the only part of it that is in reach.
  bool stays_alone = false;
};

// Keeps its memory from pair to pair. Not thread-safe.
template <class Real>
class SheetFusion {
 public:
  // Mesh, sheets and limits outlive this.
  void begin(const WorkMesh<Real>* mesh, Sheets<Real>* sheets, const SheetLimits& limits);

  // The pair in hand: v, inside its sheet or on a line of it, and its neighbour along an edge of
  // the sheet, or of the line. A partner that is fixed stays where it is, whatever it is; any other
  // is of v's kind. False where they may never become one.
  bool choose(VertexId v, VertexId partner, bool fixed, Along along);

  // The position, in the plane of the pair's triangles, if they lie in one but for rounding, or on
  // the edge, if that is where a line goes: what has been found in single precision is then not
  // what moves a flat sheet, or a straight line.
  Vec3<Real> flattened(const Vec3<Real>& position) const;
  // On the edge, at a share of it, from v.
  Vec3<Real> on_edge(double t) const;
  // May the pair meet at this position (the partner's, if that is fixed; on the edge, if v lies on
  // a line)?
  bool allows(const Vec3<Real>& position);
  // If so: the deviation of the vertex that they become, which is to be noted when they have.
  float deviation() const { return deviation_; }
  void note_fused(VertexId kept);

 private:
  Point3 about_v(const Vec3<Real>& p) const;
  Point3 in_mesh(const Point3& p) const;
  Point3 at(VertexId u) const { return about_v(mesh_->positions[u]); }
  void find_places(const SheetFan& fan, std::vector<Point3>* ring) const;
  bool find_sides();
  bool measure_disc(double* distance);
  bool measure_line(double* distance);
  bool may_meet_another(const PatchDistance& patch, double rise) const;
  bool meets_another(const Point3& normal) const;
  // Along the patch's normal.
  struct Heights {
    double least;  // of the old patch and of the fan
    double most_of_fan;
  };
  Heights heights_along(const Point3& normal) const;
  template <class Use>
  bool for_each_of_fan(Use use) const;
  bool is_in_the_way(const BoundaryTriangles::Corners& corners, const FacingBox& box,
                     const Point3& normal, const Heights& heights) const;
  bool is_alone(double distance) const;
  FacingBox box_of_patch(double wider) const;
  FacingBox in_mesh(const FacingBox& box) const { return {in_mesh(box.lo), in_mesh(box.hi)}; }
  float largest(const Vector<float>& values) const;

  const WorkMesh<Real>* mesh_ = nullptr;
  Sheets<Real>* sheets_ = nullptr;
  SheetLimits limits_;

  VertexId v_ = kNoVertex, partner_ = kNoVertex;
  bool fixed_ = false;
  Along along_{};
  SheetFan fan_v_, fan_partner_;  // each begins with the other one
  SheetPair pair_;                // where they lie
  float deviation_before_ = 0;
  float deviation_ = 0;

  // How far the sheet round a vertex has moved since begin().
  Vector<float> moved_;
  float moved_before_ = 0, moved_here_ = 0;

  Point3 position_{};
  PatchChange change_;
  // What goes, as it is: for a line, the triangles on the side in hand. With a line the outline may
  // move, too.
  std::vector<Triangle3> old_;
  bool outline_moves_ = false;
};

extern template class SheetFusion<float>;
extern template class SheetFusion<double>;

}  // namespace tetfusion
