// The paper's criteria (criteria.h) as bounds on the fusion of two vertices.
#pragma once

#include <optional>
#include <span>

#include "kernel/criteria.h"
#include "kernel/joining.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Keeps its memory from mesh to mesh. Not thread-safe.
template <class Real>
class PaperBounds {
 public:
  // The mesh as it is now is what the stretch is measured against. All outlive this.
  void begin(const PaperLimits& limits, std::span<const SteeringField> fields,
             const WorkMesh<Real>* mesh);

  bool any() const { return any_; }

  // What speaks against it, if the new vertex gets these steering values: they differ by more than
  // the tolerance from those of a vertex that moves, or an affected tetrahedron would stretch, be
  // distorted or outgrow the limit.
  std::optional<Reject> judge(const Joining<Real>& joining, std::span<const double> values) const;

 private:
  bool deviates_from(VertexId v, std::span<const double> values) const;
  bool stretches_too_far(TetId t, const std::array<Vec3<Real>, 4>& after) const;

  PaperLimits limits_;
  std::span<const SteeringField> fields_;
  const WorkMesh<Real>* mesh_ = nullptr;
  bool any_ = false;
  Vector<Vec3<Real>> start_positions_;  // of use only with a stretch factor
  Vector<Tet> start_tets_;
};

extern template class PaperBounds<float>;
extern template class PaperBounds<double>;

}  // namespace tetfusion
