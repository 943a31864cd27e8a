// A mesh read in windows, in any order and again and again, so that no more than a window needs to
// be in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "base/vector.h"
#include "io/source/mesh_source.h"
#include "mesh/geometry.h"

namespace tetfusion {

// The cells of a window that stay, in order. Rows are what leads to the tuples of cell arrays;
// those of a window's cells ascend and lie within the window, so that its arrays are read_rows() of
// the same range.
struct CellWindow {
  Vector<Tet> tets;  // ids of points; not rewound; a tetrahedron may name a point twice
  Vector<std::uint64_t> tet_rows;  // empty: tets[i] is row first + i
  LowerCells lower;
  Vector<std::uint64_t> lower_rows;  // one for each cell of `lower`
  std::uint64_t ghost_cells = 0;     // dropped; over windows that cover the mesh, all there are
};

// Cells of lower dimension, and how many corners they have together.
struct LowerCount {
  std::uint64_t cells = 0, corners = 0;
};

// Points are numbered from 0 to points() - 1; some may be used by no cell. Windows of cells lie in
// [0, cells()): in the order of the file where windows of it are read, where the whole mesh is in
// memory its tetrahedra and then its cells of lower dimension.
//
// Several threads may read at once. Reading is parallel inside (OpenMP) where it is called from
// outside a parallel region: a std::thread that must not start threads of its own has a
// LoopThreads(1) (base/resources.h) first. A window that does not lie within the mesh throws
// std::out_of_range.
class MeshStream {
 public:
  virtual ~MeshStream() = default;

  virtual std::uint64_t points() const = 0;
  virtual std::uint64_t cells() const = 0;  // those of lower dimension, too, and ghosts, if windows
                                            // of the file are read
  virtual LowerCount lower_cells() const = 0;  // that read_cells() gives, over all windows

  // What reading left out, as in Geometry. Known from the start, but for what the copies had: who
  // asks first for that waits until their rows have been read (differing_copies.h).
  virtual std::uint64_t ghost_cells() const = 0;
  virtual std::uint64_t merged_points() const = 0;
  virtual std::uint64_t differing_points() const { return 0; }
  virtual LargestDifference largest_difference() const { return {}; }
  virtual std::uint64_t dropped_points() const = 0;  // unused points that have no number here

  // Three coordinates a point, of the description's point_type, into `out`, in native byte order.
  virtual void read_points(std::uint64_t first, std::uint64_t count,
                           std::span<std::byte> out) const = 0;

  // Replaces *out. Throws Error(kBadInput) for cells that cannot be taken; InvalidMesh for an id
  // out of range, naming the window's lowest cell with one, and for a tetrahedron or cell of lower
  // dimension that uses a point with a coordinate that is not finite.
  virtual void read_cells(std::uint64_t first, std::uint64_t count, CellWindow* out) const = 0;

  // Tuples of the array at `index` of the description's point_data or cell_data, in native byte
  // order: kPoint by the points' numbers, kCell by rows.
  virtual void read_rows(Association association, std::size_t index, std::uint64_t first,
                         std::uint64_t count, std::span<std::byte> out) const = 0;

  // Sets locked[i] to 1 where point first + i must stay where it is, because cells of it were left
  // out that are another part's. Not for the copies that pieces of one mesh have of each other.
  virtual void read_locks(std::uint64_t /*first*/, std::uint64_t /*count*/,
                          std::uint8_t* /*locked*/) const {}

  // False: the whole mesh is in memory, and so is each array from its first read_rows() on. True:
  // nothing that was read stays in memory, mapped pages included.
  virtual bool streams_from_disk() const = 0;
  // What it keeps for its numbers, where that grows with the mesh.
  virtual std::uint64_t bytes() const { return 0; }
};

// Throws std::out_of_range for a window that does not lie within `size` points or cells.
void check_window(std::uint64_t first, std::uint64_t count, std::uint64_t size);

// A stream over a source, which must outlive it. Sources that can give windows do (files whose
// cells need no splitting or linearizing, and that are not VTK's to read); of others the whole mesh
// is read here, after `reserve`, where there is one, has been called with source->memory_to_read():
// it may throw. Throws what read_geometry() throws, what can only be seen in a window at the latest
// when it is read.
std::unique_ptr<MeshStream> open_stream(
    MeshSource* source, const std::function<void(std::uint64_t bytes)>& reserve = {});

// The same to read_rows() and read_points() only, for a mesh whose cells are looked at elsewhere,
// or never: what is wrong with points and cells need not be seen here.
std::unique_ptr<MeshStream> open_rows(MeshSource* source);

}  // namespace tetfusion
