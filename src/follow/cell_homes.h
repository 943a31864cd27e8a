// Where the cells of a mesh went when it was simplified, found by looking at both meshes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/vector.h"
#include "compare/locator.h"
#include "compare/original_mesh.h"
#include "compare/simplified_mesh.h"
#include "io/progressive/map_file.h"

namespace tetfusion {

// Of the cells of a simplified mesh, the numbers that they had in the original, and of its points;
// -1 for points that are new. As SimplifiedMesh::tet_ids and point_ids count.
struct OriginalNumbers {
  Vector<TetId> cells;
  Vector<std::int64_t> points;
};

// Shown the original window by window, in order. Not thread-safe, but threads are used inside; the
// same for any number of them.
class CellHomes {
 public:
  // All of it outlives this. Rows of cells, in `mesh` and in windows, say which region they are in.
  CellHomes(const SimplifiedMesh& mesh, const Locator& locator, const OriginalNumbers& numbers);

  // Sets the home of each tetrahedron of the window that has one; in the beginning none has.
  void find(const OriginalCells& window, std::size_t row_width, std::span<MapHome> homes);

  // When all windows have been seen: of all cells, by `numbers`.
  Vector<MapOrigin> origins() const;

 private:
  bool is_left(const OriginalCells& window, std::size_t i);
  MapHome home_of(const OriginalCells& window, std::size_t i, const Point& centre,
                  std::size_t row_width, LocatorHint* hint) const;

  const SimplifiedMesh& mesh_;
  const Locator& locator_;
  const OriginalNumbers& numbers_;
  Vector<TetId> order_;  // tetrahedra of `mesh`, ascending by their numbers in the original
  std::size_t next_ = 0;
  Vector<double> filled_;  // by cells whose home it is, as a share; below 0: it is left as it was
};

}  // namespace tetfusion
