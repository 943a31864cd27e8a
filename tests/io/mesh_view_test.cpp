// Meshes that lie in somebody's memory. What is refused is tested with the library's public header.
#include "io/source/mesh_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <numeric>

#include "base/error.h"
#include "io/source/mesh_stream.h"
#include "support/stream_check.h"

namespace tetfusion {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::write_out_whole;
using testing::write_out_windows;

// Owns what a view refers to.
template <class Id>
struct Cells {
  std::vector<double> points;
  std::vector<Id> ids, offsets{0};
  std::vector<std::uint8_t> types, ghosts;
  std::vector<float> field;
  std::vector<std::int16_t> number;

  void add(std::uint8_t type, std::initializer_list<Id> corners, std::uint8_t ghost = 0) {
    ids.insert(ids.end(), corners);
    offsets.push_back(static_cast<Id>(ids.size()));
    types.push_back(type);
    ghosts.push_back(ghost);
    number.push_back(static_cast<std::int16_t>(7 * number.size()));
  }
  template <class T>
  static ValuesView values(const std::vector<T>& v) {
    return {value_type_of<T>(), std::as_bytes(std::span(v))};
  }
  MeshView view() {
    field.resize(points.size() / 3);
    std::iota(field.begin(), field.end(), 0.5f);
    MeshView view;
    view.points = values(points);
    view.connectivity = values(ids);
    view.offsets = values(offsets);
    view.types = types;
    view.ghosts = ghosts;
    view.point_arrays = {{"field", 1, values(field)}};
    view.cell_arrays = {{"number", 1, values(number)}, {"vtkGhostType", 1, values(ghosts)}};
    return view;
  }
};

// Two layers of four points, a ninth that only a line has, and one of no cell.
template <class Id>
Cells<Id> eight_points() {
  Cells<Id> cells;
  cells.points = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 9, 9, 9,
                  0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1, 5, 5, 5};
  return cells;
}

template <class Id>
Cells<Id> mixed_cells() {
  auto cells = eight_points<Id>();
  cells.add(5, {0, 1, 2});
  cells.add(10, {0, 1, 2, 5});
  cells.add(10, {2, 5, 6, 7}, 1);
  cells.add(1, {3});
  cells.add(10, {0, 2, 3, 5}, 2);  // a flag that is not looked at
  cells.add(3, {3, 9});
  cells.add(10, {2, 3, 5, 8}, 32);
  cells.add(10, {1, 2, 5, 6});
  return cells;
}

void expect_windows_like_whole(const MeshView& view, const OpenOptions& options = {}) {
  const auto source = open_view(view, options);
  const auto stream = open_stream(source.get());
  const testing::WrittenMesh whole = write_out_whole(source.get());
  for (const std::uint64_t window : {1, 2, 3, 100}) {
    EXPECT_EQ(write_out_windows(*source, *stream, window), whole) << window;
  }
}

TEST(MeshViews, WindowsAreTheWholeMesh) {
  expect_windows_like_whole(mixed_cells<std::int32_t>().view());
  auto wide = mixed_cells<std::int64_t>();
  expect_windows_like_whole(wide.view());
}

TEST(MeshViews, MixedCellsComeApart) {
  auto cells = mixed_cells<std::int32_t>();
  const MeshView view = cells.view();
  const auto source = open_view(view);
  EXPECT_EQ(source->description().points, 10u);
  EXPECT_EQ(source->description().cells, 8u);
  const auto stream = source->stream();
  EXPECT_EQ(stream->ghost_cells(), 2u);
  EXPECT_EQ(stream->lower_cells().cells, 3u);
  EXPECT_EQ(stream->lower_cells().corners, 6u);
  CellWindow window;
  stream->read_cells(0, 8, &window);
  EXPECT_THAT(window.tets, ElementsAre(Tet{0, 1, 2, 5}, Tet{0, 2, 3, 5}, Tet{1, 2, 5, 6}));
  EXPECT_THAT(window.tet_rows, ElementsAre(1, 4, 7));
  EXPECT_THAT(window.lower.types, ElementsAre(5, 1, 3));
  EXPECT_THAT(window.lower.connectivity, ElementsAre(0, 1, 2, 3, 3, 9));
  EXPECT_THAT(window.lower_rows, ElementsAre(0, 3, 5));
  EXPECT_EQ(window.ghost_cells, 2u);
  EXPECT_THROW(stream->read_cells(7, 2, &window), std::out_of_range);

  std::vector<std::int16_t> numbers(3);
  stream->read_rows(Association::kCell, 0, 2, 3, std::as_writable_bytes(std::span(numbers)));
  EXPECT_THAT(numbers, ElementsAre(14, 21, 28));
  // Nothing that is left is a ghost.
  std::vector<std::uint8_t> ghosts(8);
  stream->read_rows(Association::kCell, 1, 0, 8, std::as_writable_bytes(std::span(ghosts)));
  EXPECT_THAT(ghosts, ElementsAre(0, 0, 0, 0, 2, 0, 0, 0));
}

TEST(MeshViews, PointsOfGhostCellsAreLocked) {
  auto cells = mixed_cells<std::int64_t>();
  const MeshView view = cells.view();
  const auto source = open_view(view);
  const auto stream = source->stream();
  std::vector<std::uint8_t> locked(9, 0);
  locked[1] = 1;  // for a reason of its own
  stream->read_locks(1, 9, locked.data());
  EXPECT_THAT(locked, ElementsAre(0, 1, 1, 0, 1, 1, 1, 1, 0));

  cells.ghosts.assign(8, 0);
  const MeshView without = cells.view();
  const auto other = open_view(without);
  std::fill(locked.begin(), locked.end(), std::uint8_t{0});
  other->stream()->read_locks(1, 9, locked.data());
  EXPECT_THAT(locked, ::testing::Each(0));
}

TEST(MeshViews, CellsAreSplitAndStraightened) {
  auto cells = eight_points<std::int32_t>();
  cells.add(5, {0, 1, 2});
  cells.add(12, {0, 1, 2, 3, 5, 6, 7, 8});
  cells.add(14, {0, 1, 2, 3, 9}, 1);
  const MeshView view = cells.view();
  OpenOptions options;
  options.tetrahedralize = true;
  expect_windows_like_whole(view, options);
  const auto source = open_view(view, options);
  const auto stream = source->stream();
  EXPECT_EQ(stream->cells(), 7u);
  EXPECT_GT(stream->bytes(), 6 * sizeof(Tet));
  CellWindow window;
  stream->read_cells(0, 7, &window);
  EXPECT_EQ(window.tets.size(), 6u);
  EXPECT_THAT(window.lower_rows, ElementsAre(6));
  std::vector<std::int16_t> numbers(7);
  stream->read_rows(Association::kCell, 0, 0, 7, std::as_writable_bytes(std::span(numbers)));
  EXPECT_THAT(numbers, ElementsAre(7, 7, 7, 7, 7, 7, 0));

  auto curved = eight_points<std::int64_t>();
  curved.add(24, {0, 1, 2, 5, 3, 4, 6, 7, 8, 9});
  EXPECT_THROW(open_view(curved.view())->stream(), Error);
  options = {};
  options.linearize = true;
  expect_windows_like_whole(curved.view(), options);
}

// Of any type, those that are not read otherwise, too; ghost cells are counted all the same.
TEST(MeshViews, PatchesAreDropped) {
  auto cells = mixed_cells<std::int32_t>();
  cells.add(4, {0, 1, 9});
  cells.add(7, {0, 1, 2, 3, 4});
  cells.add(22, {0, 1, 2, 3, 5, 4});
  cells.add(5, {0, 1, 2}, 1);
  cells.points[3 * 9] = std::numeric_limits<double>::infinity();  // no tetrahedron's
  const MeshView view = cells.view();
  EXPECT_THROW(open_view(view)->stream(), Error);
  const OpenOptions dropped = {.drop_patches = true};
  expect_windows_like_whole(view, dropped);
  const auto source = open_view(view, dropped);
  const auto stream = source->stream();
  EXPECT_EQ(stream->cells(), 12u);
  EXPECT_EQ(stream->ghost_cells(), 3u);
  CellWindow window;
  stream->read_cells(0, 12, &window);
  EXPECT_THAT(window.tet_rows, ElementsAre(1, 4, 7));
  EXPECT_EQ(window.lower.size(), 0u);
  EXPECT_EQ(window.ghost_cells, 3u);

  cells.add(14, {0, 1, 2, 3, 8});
  expect_windows_like_whole(cells.view(), {.tetrahedralize = true, .drop_patches = true});

  auto surface = eight_points<std::int64_t>();
  surface.add(5, {0, 1, 2});
  EXPECT_THROW(open_view(surface.view(), dropped)->stream(), Error);
}

TEST(MeshViews, PointsThatAreNotFiniteMatterWhereTheyAreUsed) {
  auto cells = mixed_cells<std::int32_t>();
  cells.points[3 * 4] = std::numeric_limits<double>::quiet_NaN();
  expect_windows_like_whole(cells.view());
  cells.points[3 * 6 + 1] = std::numeric_limits<double>::infinity();
  const MeshView view = cells.view();
  const auto source = open_view(view);
  const auto stream = source->stream();
  CellWindow window;
  stream->read_cells(0, 5, &window);
  const auto message = [&](auto read) -> std::string {
    try {
      read();
    } catch (const InvalidMesh& e) {
      return e.what();
    }
    return "none";
  };
  EXPECT_EQ(message([&] { stream->read_cells(0, 8, &window); }),
            "the mesh: point 6 has a coordinate that is not finite");
  EXPECT_THAT(message([&] { source->read_geometry(); }), HasSubstr("point 6"));
}

}  // namespace
}  // namespace tetfusion
