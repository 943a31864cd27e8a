// Two vertices of a sheet become one: may they, and how far does the sheet move?
#pragma once

#include <optional>
#include <vector>

#include "kernel/quadrics/edge_costs.h"
#include "kernel/sheets/local_frame.h"
#include "kernel/sheets/patch_distance.h"
#include "kernel/sheets/patch_surroundings.h"
#include "kernel/sheets/sheet_patch.h"
#include "kernel/sheets/sheets.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

struct SheetLimits {
  double unit = 1;           // of lengths
  double max_deviation = 0;  // so far may a sheet move, in the unit
  SurroundingsLimits surroundings;
};

// Keeps its memory from pair to pair. Not thread-safe.
template <class Real>
class SheetFusion {
 public:
  // Mesh, sheets and limits outlive this.
  void begin(const WorkMesh<Real>* mesh, Sheets<Real>* sheets, const SheetLimits& limits);

  // The pair in hand: v, inside its sheet or on a line of it, and its neighbour along an edge of
  // the sheet, or of the line. A partner that is fixed stays where it is, whatever it is; any other
  // is of v's kind. False where they may never become one, as far as is looked at here.
  bool choose(VertexId v, VertexId partner, bool fixed, Along along);

  // The position, in the plane of the pair's triangles, if they lie in one but for rounding, or on
  // the edge, if that is where a line goes: what has been found in single precision is then not
  // what moves a flat sheet, or a straight line.
  Vec3<Real> flattened(const Vec3<Real>& position) const;
  // On the edge, at a share of it, from v.
  Vec3<Real> on_edge(double t) const;
  // May the pair meet at this position (the partner's, if that is fixed; on the edge, if v lies on
  // a line)? For positions at which the tetrahedra would be good: this takes longer to find out.
  bool allows(const Vec3<Real>& position);
  // After that: they may meet nowhere, for what they have in common.
  bool may_never() const { return may_contract_ == false; }
  // If so: the deviation of the vertex that they become, which is to be noted when they have.
  float deviation() const { return deviation_; }
  void note_fused(VertexId kept);

 private:
  Point3 at(VertexId u) const { return frame_.local(mesh_->positions[u]); }
  void find_places(const SheetFan& fan, std::vector<Point3>* ring) const;
  bool find_sides();
  bool measure_disc(double* distance);
  bool measure_line(double* distance);
  bool may_contract();
  bool may_move(const PatchDistance& distance) const;
  float largest(const Vector<float>& values) const;

  const WorkMesh<Real>* mesh_ = nullptr;
  Sheets<Real>* sheets_ = nullptr;
  SheetLimits limits_;
  PatchSurroundings<Real> surroundings_;

  VertexId v_ = kNoVertex, partner_ = kNoVertex;
  bool fixed_ = false;
  Along along_{};
  SheetFan fan_v_, fan_partner_;      // each begins with the other one
  std::optional<bool> may_contract_;  // nobody has asked yet
  LocalFrame<Real> frame_;            // about v
  SheetPair pair_;                    // where they lie
  float deviation_before_ = 0;
  float deviation_ = 0;

  // How far the sheet round a vertex has moved since begin().
  Vector<float> moved_;
  float moved_before_ = 0, moved_here_ = 0;

  Point3 position_{};
  MovingPatch patch_;
};

extern template class SheetFusion<float>;
extern template class SheetFusion<double>;

}  // namespace tetfusion
