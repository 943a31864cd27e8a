// Values of cells, taken over by what they overlap: integrals over the mesh stay.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/vector.h"
#include "mesh/tet_neighbours.h"
#include "mesh/tet_overlap.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Not thread-safe.
template <class Real>
class CellTransfer {
 public:
  // Remembers the tetrahedra of the mesh as they are. While they change, what is deleted is marked
  // in place, and rows of cells stay as they are.
  explicit CellTransfer(const WorkMesh<Real>& mesh);

  // What has changed since fills the same domain as it did, and has positive volumes now and then.
  // The rows of these columns, of floating-point numbers, become the means of what each tetrahedron
  // overlaps of the old ones, by volume. What is no number does not spread.
  void run(std::span<const std::uint32_t> columns, WorkMesh<Real>* mesh);

 private:
  struct Share {
    TetId old;
    double weight;  // of the new one
  };
  // An old tetrahedron on the way through what a new one overlaps.
  struct Stop {
    TetId old;
    unsigned open = 15;  // of its faces, as bits: what is beyond is no stop yet
  };
  TetCorners old_corners(TetId t) const;
  void find_changes(const WorkMesh<Real>& mesh);
  void find_shares(TetId tet, const TetCorners& corners);
  void add_stop(TetId old);
  void go_on_from(std::size_t stop, unsigned faces);
  template <class T>
  void mix(TetId tet, const Column& column, Vector<std::byte>* rows) const;

  Vector<Tet> tets_;
  Vector<Vec3<Real>> positions_;
  Vector<std::uint8_t> changed_;  // of each tetrahedron: it is gone, or somewhere else
  TetNeighbours neighbours_;
  TetId tet_ = kNoTet;      // the new one in hand
  Vector<TetId> stop_for_;  // of each old one: on whose way it was last
  std::vector<Stop> stops_;
  std::vector<Share> shares_;
};

extern template class CellTransfer<float>;
extern template class CellTransfer<double>;

}  // namespace tetfusion
