// Values of the tetrahedra of a simplified mesh: means of those of the original that lie in them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "base/vector.h"
#include "kernel/fit/tet_walk.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Does not depend on the order of the corners.
template <class Real>
Vec3<double> centre_of(const Vector<Vec3<Real>>& positions, const Tet& tet);

// By which tetrahedra with other corners are told apart, whatever their order.
template <class Real>
std::uint64_t corners_hash(const Vector<Vec3<Real>>& positions, const Tet& tet);

// Six times that of the tetrahedron, as it is rounded; not positive where that may be.
template <class Real>
double volume_of(const Vector<Vec3<Real>>& positions, const Tet& tet);

// Of the original, none without volume.
struct CellsToAverage {
  std::span<const Vec3<double>> centres;  // centre_of()
  std::span<const double> volumes;        // volume_of()
  std::span<const std::uint64_t> hashes;  // corners_hash()
  std::vector<const std::byte*> labels;   // rows of each label
};

// A tetrahedron that is left has the values of one of the original, which has become a small part
// of it, if it is inside at all.
//
// Begin with a mesh, add cells, and average; keeps its scratch memory; one a thread.
template <class Real>
class CellMeans {
 public:
  // The mesh is not changed until average(), and outlives that, as does the walk, which has begun
  // with it. Columns and labels are some of those of its tetrahedra: means are made of columns of
  // floating-point numbers, of cells in the region of the tetrahedron (region_keys()).
  void begin(WorkMesh<Real>* mesh, std::span<const std::uint32_t> columns,
             std::span<const std::uint32_t> labels, TetWalk<Real>* walk);

  // This one keeps the values that it has.
  void keep(TetId tet) { enough_[tet] = kNever; }

  // Every step-th of these cells, from that one on. Neighbours are best near each other in the
  // list. A cell counts where its centre is.
  void add(const CellsToAverage& cells, std::uint64_t first, std::uint64_t step);

  // Calls use(volumes, rows) with those of the cells of each add(), and the rows that they have of
  // one of the columns, the first being 0; as often as it is called itself.
  using UseRows = std::function<void(const double* volumes, const std::byte* rows)>;
  using ReadRows = std::function<void(std::size_t column, const UseRows& use)>;

  // Sets the values of each tetrahedron to the means of those of its cells, weighted by volume and
  // within their range. One that is itself one of the cells, or has none but small ones, or no
  // volume, keeps what it has. Values that are not finite do not count, unless most of the volume
  // is theirs: then the first one is taken.
  void average(const ReadRows& read);

  // Bytes that takes beside the mesh and the walk, for so many cells and tetrahedra.
  static std::uint64_t memory(std::uint64_t cells, std::uint64_t tets);

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  // Of the values in a tetrahedron, and their weight. Of those that are not finite, weight and the
  // first one.
  struct Mean {
    double mean = 0, weight = 0;
    double lost = 0, other = 0;
  };
  // A tetrahedron in the table of those there are, with a part of its hash.
  struct Slot {
    TetId tet = kNoTet;
    std::uint32_t tag = 0;
  };
  // Which of the cells of an add() were looked at.
  struct Added {
    std::uint64_t first, step, end;
  };

  void list_tets();
  Slot& slot_of(std::uint64_t hash);
  bool is_left(std::uint64_t hash);
  using Keys = std::vector<Vector<std::uint64_t>>;  // of each label, of each tetrahedron or cell
  bool is_in_region_of(TetId tet, const Keys& keys, std::uint64_t cell) const;
  template <class T>
  void average_column(Column* column, const std::function<void(const UseRows& use)>& read);
  void add_up(double volume, double value, Mean* mean) const;

  WorkMesh<Real>* mesh_ = nullptr;
  TetWalk<Real>* walk_ = nullptr;
  std::vector<std::uint32_t> columns_, labels_;
  Keys keys_;
  Vector<double> enough_;  // volume of cells, for each tetrahedron; infinite: it keeps what it has
  Vector<Slot> slots_;     // of the others, by their hashes; a power of two
  Vector<TetId> tet_of_;   // of each cell that was looked at; kNoTet: it does not count
  std::vector<Added> added_;
  Vector<Mean> means_;  // of the component in hand
};

extern template class CellMeans<float>;
extern template class CellMeans<double>;

}  // namespace tetfusion
