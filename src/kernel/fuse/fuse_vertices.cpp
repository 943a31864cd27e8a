#include "kernel/fuse/fuse_vertices.h"

#include <cmath>

#include "kernel/quadrics/quadric.h"

namespace tetfusion {

template <class Real>
void FuseVertices<Real>::begin(const FuseLimits& limits, WorkMesh<Real>* mesh) {
  limits_ = &limits;
  mesh_ = mesh;
  now_ = 1;
  const std::size_t n = mesh->vertex_count();
  balls_.reset(n, mesh->tets);
  begin_weights();
  if (limits.sheets_move()) begin_sheets();
  states_.assign(n, State{});
  for (VertexId v = 0; v < n; ++v) states_[v].kind = kind_of(v);
}

template <class Real>
auto FuseVertices<Real>::kind_of(VertexId v) -> Kind {
  const std::size_t width = mesh_->steering_width;
  for (std::size_t k = 0; k < width; ++k) {
    if (!std::isfinite(mesh_->steering[v * width + k])) return kOut;
  }
  const std::uint8_t marks = mesh_->marks[v];
  if ((marks & kOnInterface) != 0) return kOut;
  if ((marks & kLocked) != 0) return kTarget;
  if (!limits_->sheets_move()) return (marks & kOnBoundary) != 0 ? kTarget : kFree;
  return kind_on_sheet(v);
}

template <class Real>
auto FuseVertices<Real>::kind_on_sheet(VertexId v) -> Kind {
  if (limits_->sheets_rest) return is_on_one(v) ? kTarget : kFree;
  switch (sheets_.feature(v)) {
    case SheetFeature::kNone:
      return kFree;
    case SheetFeature::kSmooth:
      return kOnSheet;
    case SheetFeature::kLine:
      return kOnLine;
    case SheetFeature::kCorner:
      return kTarget;
  }
  return kTarget;
}

template <class Real>
void FuseVertices<Real>::begin_sheets() {
  sheets_.begin(mesh_, &balls_, limits_->regions, limits_->feature_angle);
  if (limits_->sheets_rest) return;
  const std::size_t at = quadric_size(mesh_->steering_width);
  for (VertexId v = 0; v < mesh_->vertex_count(); ++v) {
    if (!is_on_one(v) || (mesh_->marks[v] & kOnInterface) != 0) continue;
    float* quadric = mesh_->quadrics.data() + std::size_t{v} * mesh_->quadric_width + at;
    if (quadric[kQuadricW] == 0) sheets_.add_planes(v, limits_->unit, quadric);
  }
}

template <class Real>
void FuseVertices<Real>::begin_weights() {
  weights_.clear();
  const std::uint32_t number = limits_->weights.column;
  const bool of_cells = limits_->weights.of_cells;
  const double scale = limits_->weights.scale;
  if (number == kNoColumn) return;
  const Column& column = of_cells ? mesh_->cell_columns[number] : mesh_->point_columns[number];
  if (of_cells) weights_.assign(mesh_->vertex_count(), 0);
  visit_type(column.type, [&](auto zero) {
    using T = decltype(zero);
    const T* const rows = reinterpret_cast<const T*>(column.rows.data());
    for (std::size_t v = 0; v < mesh_->vertex_count() && !of_cells; ++v) {
      weights_.push_back(static_cast<float>(scale * static_cast<double>(rows[v])));
    }
    for (TetId t = 0; t < mesh_->tets.size() && of_cells; ++t) {
      const auto weight = static_cast<float>(scale * static_cast<double>(rows[t]));
      for (const VertexId v : mesh_->tets[t]) weights_[v] = std::max(weights_[v], weight);
    }
  });
}

template class FuseVertices<float>;
template class FuseVertices<double>;

}  // namespace tetfusion
