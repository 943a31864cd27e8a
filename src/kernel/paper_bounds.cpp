#include "kernel/paper_bounds.h"

#include <array>
#include <cmath>

namespace tetfusion {

namespace {

template <class Real>
bool is_at(const Vec3<Real>& a, const Vec3<Real>& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}

}  // namespace

template <class Real>
void PaperBounds<Real>::begin(const PaperLimits& limits, std::span<const SteeringField> fields,
                              const WorkMesh<Real>* mesh) {
  limits_ = limits;
  fields_ = fields;
  mesh_ = mesh;
  any_ = PaperLimits::is_on(limits.scalar_tolerance) || limits.judge_shapes();
  if (!PaperLimits::is_on(limits.stretch_factor)) return;
  start_positions_ = mesh->positions;
  start_tets_ = mesh->tets;
}

template <class Real>
bool PaperBounds<Real>::deviates_from(VertexId v, std::span<const double> values) const {
  const double* own = mesh_->steering.data() + std::size_t{v} * mesh_->steering_width;
  for (const SteeringField& f : fields_) {
    double square = 0;
    for (std::uint32_t k = f.first; k < f.first + f.count; ++k) {
      square += (values[k] - own[k]) * (values[k] - own[k]);
    }
    if (!(std::sqrt(square) < limits_.scalar_tolerance * f.range)) return true;
  }
  return false;
}

// At every corner that has moved since the start.
template <class Real>
bool PaperBounds<Real>::stretches_too_far(TetId t, const std::array<Vec3<Real>, 4>& after) const {
  const auto before = corners(start_positions_, start_tets_[t]);
  for (int c = 0; c < 4; ++c) {
    const auto i = static_cast<std::size_t>(c);
    if (!is_at(before[i], after[i]) && stretches(before, after, c, limits_.stretch_factor)) {
      return true;
    }
  }
  return false;
}

template <class Real>
std::optional<Reject> PaperBounds<Real>::judge(const Joining<Real>& joining,
                                               std::span<const double> values) const {
  if (!any_) return std::nullopt;
  if (PaperLimits::is_on(limits_.scalar_tolerance) &&
      (deviates_from(joining.v, values) ||
       (!joining.fixed && deviates_from(joining.partner, values)))) {
    return Reject::kScalar;
  }
  return judge_shapes(limits_, *mesh_, joining.affected, joining.position,
                      [&](std::uint32_t entry, const auto&, const auto& after) {
                        return stretches_too_far(entry >> 2, after);
                      });
}

template class PaperBounds<float>;
template class PaperBounds<double>;

}  // namespace tetfusion
