#include "follow/cell_homes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/blocks.h"
#include "compare/hilbert_curve.h"
#include "compare/measure.h"
#include "mesh/predicates.h"

namespace tetfusion {

namespace {

constexpr std::size_t kCellsInBlock = 4096;

// Cells that are a smaller share of a tetrahedron say little of it.
constexpr double kEnough = 1.0 / 8;
constexpr double kLeft = -std::numeric_limits<double>::infinity();

bool are_in_one_region(const double* a, const double* b, std::size_t width) {
  for (std::size_t c = 0; c < width; ++c) {
    if (!(a[c] == b[c] || (std::isnan(a[c]) && std::isnan(b[c])))) return false;
  }
  return true;
}

}  // namespace

CellHomes::CellHomes(const SimplifiedMesh& mesh, const Locator& locator,
                     const OriginalNumbers& numbers)
    : mesh_(mesh), locator_(locator), numbers_(numbers), order_(count_up<TetId>(mesh.tets.size())) {
  std::sort(order_.begin(), order_.end(), [&](TetId a, TetId b) {
    return numbers.cells[mesh.tet_ids[a]] < numbers.cells[mesh.tet_ids[b]];
  });
  filled_.assign(mesh.tets.size(), 0);
}

void CellHomes::find(const OriginalCells& window, std::size_t row_width, std::span<MapHome> homes) {
  const std::size_t count = window.tets.size();
  Vector<std::uint8_t> left(count);
  Vector<Point> centres(count);
  for (std::size_t i = 0; i < count; ++i) {
    left[i] = is_left(window, i) ? 1 : 0;
    centres[i] = {};
    for (const VertexId v : window.tets[i]) {
      centres[i] = centres[i] + 0.25 * window.points.points[v];
    }
  }
  const Vector<std::uint32_t> order = curve_order(centres);
  for_each_block(count, kCellsInBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    LocatorHint hint;
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t i = order[k];
      if (left[i] == 0) homes[i] = home_of(window, i, centres[i], row_width, &hint);
    }
  });
  for (MapHome& home : homes) {
    if (home.tet == kNoTet) continue;
    filled_[home.tet] += home.share;
    home.tet = mesh_.tet_ids[home.tet];
  }
}

// Is the cell still there, with all of its points where they were?
bool CellHomes::is_left(const OriginalCells& window, std::size_t i) {
  const std::uint64_t row = window.row(i);
  const auto number_of_next = [&] { return numbers_.cells[mesh_.tet_ids[order_[next_]]]; };
  while (next_ < order_.size() && number_of_next() < row) ++next_;
  if (next_ == order_.size() || number_of_next() != row) return false;
  const TetId tet = order_[next_];
  std::array<std::int64_t, 4> before{}, now{};
  for (std::size_t k = 0; k < 4; ++k) {
    before[k] = window.points.ids[window.tets[i][k]];
    now[k] = numbers_.points[mesh_.point_ids[mesh_.tets[tet][k]]];
  }
  if (!std::is_permutation(before.begin(), before.end(), now.begin())) return false;
  filled_[tet] = kLeft;
  return true;
}

// By its number in `mesh`.
MapHome CellHomes::home_of(const OriginalCells& window, std::size_t i, const Point& centre,
                           std::size_t row_width, LocatorHint* hint) const {
  const Determinant volume = determinant(window.points.points, window.tets[i]);
  if (volume.sign() == 0) return {};
  const Place place = locator_.locate(centre, hint, window.points.part_of(window.tets[i][0]));
  if (place.outside || mesh_.flat[place.tet] != 0) return {};
  const double* row = window.cell_rows.data() + i * row_width;
  const double* own = mesh_.cell_rows.data() + std::size_t{place.tet} * row_width;
  if (!are_in_one_region(row, own, row_width)) return {};
  const double whole = determinant(mesh_.points, mesh_.tets[place.tet]).value;
  const auto share = static_cast<float>(std::abs(volume.value) / whole);
  return share > 0 && std::isfinite(share) ? MapHome{place.tet, share} : MapHome{};
}

Vector<MapOrigin> CellHomes::origins() const {
  Vector<MapOrigin> origins(numbers_.cells.size());
  for (std::size_t c = 0; c < origins.size(); ++c) origins[c] = {numbers_.cells[c], 0};
  for (std::size_t t = 0; t < filled_.size(); ++t) {
    if (filled_[t] >= kEnough) origins[mesh_.tet_ids[t]].is_mean = 1;
  }
  return origins;
}

}  // namespace tetfusion
