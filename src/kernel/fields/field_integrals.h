// Conservation: the integrals of all floating-point fields over a cavity stay what they are when
// two vertices become one.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "kernel/criteria.h"
#include "kernel/fields/cell_transfer.h"
#include "kernel/fusions.h"
#include "kernel/joining.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Keeps its memory from mesh to mesh. Not thread-safe.
template <class Real>
class FieldIntegrals {
 public:
  // Mesh and fields outlive this. Cell columns that are regions are no fields: a mean of two of
  // their values would be a third region.
  void begin(bool stay, std::span<const SteeringField> fields,
             std::span<const std::uint32_t> regions, WorkMesh<Real>* mesh);
  bool stay() const { return stay_; }

  // Finds the values of the new vertex for which the integrals stay; those that steer go to
  // `values`, which keeps those of fields that are no point array. False if one would leave the
  // range of its cavity or, where the partner keeps its own, if its integral would change; or if
  // some values of the cavity's cells are not finite, and not all alike. Where some of its points'
  // values are not, there is no integral. The cavity fills the same domain before and after, with
  // positive volumes.
  bool find(const Joining<Real>& joining, std::span<double> values);

  // To be called before the mesh changes, with what find() has found last. Writes the rows of the
  // vertex that stays, but for columns that steer. Integers are those of the nearest vertex of the
  // two. Where there is no integral, the value is the interpolated one.
  void apply(VertexId kept, const Interpolation& interpolation);

  // When no more fusions come. Writes the rows of tetrahedra that have changed: what they take over
  // of what was there in the beginning, by volume. Integers stay.
  void finish();

 private:
  // Component k of rows of `width`; how exact its type is.
  struct Values {
    std::size_t width, k;
    double exactness;
  };
  struct Range {
    double least, most;
  };
  // False: no value will do. The value is no number where there is no integral.
  template <class T>
  bool solve(const T* rows, const Values& of, double* value) const;
  template <class T>
  Range range_of(const T* rows, const Values& of) const;
  void measure();
  bool can_mix_cells() const;
  template <class T>
  bool can_mix(const Column& column) const;

  WorkMesh<Real>* mesh_ = nullptr;
  std::span<const SteeringField> fields_;
  bool stay_ = false;
  std::vector<std::uint32_t> mixed_columns_;  // floating-point fields of tetrahedra
  std::vector<std::uint32_t> gap_columns_;    // of them those with values that are not finite
  std::vector<std::uint8_t> steers_;          // of a point column

  Joining<Real> joining_;
  std::vector<TetId> old_tets_;                 // the affected ones first
  std::vector<double> before_, after_;          // volumes of old tetrahedra, and of affected ones
  double sum_ = 0;                              // of the latter
  std::vector<double> rows_;                    // what find() has found, column by column
  std::optional<CellTransfer<Real>> transfer_;  // from the first fusion on
};

extern template class FieldIntegrals<float>;
extern template class FieldIntegrals<double>;

}  // namespace tetfusion
