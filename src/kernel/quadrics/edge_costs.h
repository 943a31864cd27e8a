// What it costs to make two neighbours one, and where they would best come together.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/lanes.h"
#include "kernel/criteria.h"
#include "kernel/quadrics/quadric.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Two neighbours as one: their quadrics added up, about the first of them.
struct MergedQuadric {
  std::vector<float> sum;
  std::array<float, quadric_size(0)> sheet{};  // of vertices on a sheet
  Reduced reduced;                             // on a sheet: the mean of both
  Offset edge{};                               // from the first to the second
  Offset best{};                               // where it is least, or nearly
};

// Where two vertices of a sheet may come together.
enum class Along : std::uint8_t {
  kSheet,  // anywhere near their edge
  kLine,   // on it
};

// What an edge's squared length (in units of the mesh) adds to the cost, so that where fields do
// not tell, short edges go first: an edge of a tenth of the mesh is worth an error of 1e-4. Without
// fields there is nothing else.
constexpr float length_cost(bool have_fields) { return have_fields ? 1e-6F : 1.0F; }

// Keeps its memory from mesh to mesh. Not thread-safe.
template <class Real>
class EdgeCosts {
 public:
  // The mesh outlives this; its quadrics, positions and steering values may change between calls.
  // `unit` is that of begin_quadrics(), and the squared distance from a sheet counts as a squared
  // error times `sheet_weight`.
  void begin(const WorkMesh<Real>* mesh, std::span<const SteeringField> fields, double unit,
             double sheet_weight = 0);

  // Of v and each of the partners, if both may move: at the best position, with the best values.
  void between(VertexId v, std::span<const VertexId> partners, float* costs);
  // If the partner stays where it is, with the values that it has.
  float onto(VertexId v, VertexId partner);
  // The same for two vertices of a sheet.
  float between_on_sheet(VertexId v, VertexId partner, Along along);
  float onto_on_sheet(VertexId v, VertexId partner);

  // Of the two, if both may move; keeps the memory of *out.
  void merge(VertexId v, VertexId partner, MergedQuadric* out);
  void merge_on_sheet(VertexId v, VertexId partner, Along along, MergedQuadric* out);
  // Adds v's quadric to the row of a vertex that has this position and these values.
  void add(VertexId v, const Vec3<Real>& position, const double* values, float* row);
  // The same of what v has been merged to.
  void add(const MergedQuadric& merged, VertexId v, const Vec3<Real>& position,
           const double* values, float* row);
  void add_sheet(VertexId v, const Vec3<Real>& position, float* row);
  void add_sheet(const MergedQuadric& merged, VertexId v, const Vec3<Real>& position, float* row);

  // One over the range of a steering value's field.
  float scale(std::size_t k) const { return scale_[k]; }
  Offset offset(const Vec3<Real>& from, const Vec3<Real>& to) const;
  Vec3<Real> position_at(VertexId from, const Offset& u) const;

 private:
  template <std::size_t kWidth>
  void between_lanes(VertexId v, std::span<const VertexId> partners, float* costs);
  const float* quadric(VertexId v) const {
    return mesh_->quadrics.data() + std::size_t{v} * mesh_->quadric_width;
  }
  const float* sheet_quadric(VertexId v) const { return quadric(v) + quadric_size(width_); }
  const double* values(VertexId v) const {
    return mesh_->steering.data() + std::size_t{v} * width_;
  }
  const float* differences(const double* from, const double* to);

  const WorkMesh<Real>* mesh_ = nullptr;
  double unit_ = 1;
  float sheet_weight_ = 0;
  std::size_t width_ = 0;
  std::vector<float> scale_, differences_, sum_;
  std::vector<Lanes> lanes_;  // of a group of partners: quadrics, sums, differences
  MergedQuadric on_sheet_;    // of a pair whose costs are asked for
};

extern template class EdgeCosts<float>;
extern template class EdgeCosts<double>;

}  // namespace tetfusion
