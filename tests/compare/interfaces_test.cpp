// Surfaces between regions, and how surfaces hang together.
#include "compare/interfaces.h"

#include <gtest/gtest.h>

#include <cmath>

#include "compare/compare.h"
#include "compare/topology.h"
#include "io/open_mesh.h"
#include "support/comparison.h"
#include "support/mesh_file.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using testing::compare_files;
using testing::five_split_box;
using testing::MeshFile;
using testing::TempDir;

using P = Vec3<double>;

// The material of each cell, from the largest x of its corners.
MeshFile layered(Geometry geometry, std::int64_t first, std::int64_t second, double border) {
  MeshFile file;
  file.geometry = std::move(geometry);
  file.cell_arrays.push_back(
      testing::make_array<std::int64_t>("layer", file.cells(), 1, [&](std::size_t t, std::size_t) {
        double most = 0;
        for (const VertexId v : file.geometry.tets[t]) {
          most = std::max(most, testing::point(file.geometry, v).x);
        }
        return most <= border ? first : second;
      }));
  return file;
}

InterfaceComparison compare(const MeshFile& a, const MeshFile& b,
                            const std::vector<std::string>& arrays = {"layer"}) {
  const TempDir folder = TempDir::in_memory();
  a.write(folder.file("a.vtu"));
  b.write(folder.file("b.vtu"));
  const auto original = open_mesh(folder.file("a.vtu")), other = open_mesh(folder.file("b.vtu"));
  return compare_interfaces(original.get(), other.get(), arrays, {});
}

TEST(Interfaces, AreTheTrianglesBetweenValues) {
  const Geometry box = five_split_box(4, 3, 2);
  // Values that are one and the same as doubles.
  const std::int64_t large = std::int64_t{1} << 60;
  const InterfaceComparison same =
      compare(layered(box, large, large + 1, 2), layered(box, 5, 4, 2));
  EXPECT_EQ(same.original, 2u * 3 * 2);
  EXPECT_EQ(same.simplified, 2u * 3 * 2);
  EXPECT_TRUE(same.distance.identical);
  const InterfaceComparison moved = compare(layered(box, 1, 2, 2), layered(box, 1, 2, 3));
  EXPECT_FALSE(moved.distance.identical);
  EXPECT_EQ(moved.distance.first_to_second.max, 1);
  EXPECT_EQ(moved.distance.second_to_first.max, 1);
  EXPECT_EQ(moved.distance.second_to_first.max_at.x, 3);
  EXPECT_EQ(moved.distance.differs_at.x, 2);
}

// With as many values as cells every inner triangle is one; zeros of either sign are one value, and
// what is no number is another.
TEST(Interfaces, OfFloats) {
  MeshFile file;
  file.geometry = five_split_box(4, 3, 2);
  const auto with = [&](auto value_of) {
    MeshFile made = file;
    made.cell_arrays = {testing::make_array<double>(
        "layer", file.cells(), 1, [&](std::size_t t, auto) { return value_of(t); })};
    return made;
  };
  const MeshFile halves = layered(file.geometry, 0, 1, 2);
  const auto labels = halves.cell_arrays[0].as<std::int64_t>();
  const MeshFile floats = with([&](std::size_t t) {
    const double sign = t % 2 == 0 ? -1 : 1;
    return sign * (labels[t] == 0 ? 0.0 : std::nan(""));
  });
  const InterfaceComparison same = compare(halves, floats);
  EXPECT_EQ(same.original, 2u * 3 * 2);
  EXPECT_EQ(same.simplified, 2u * 3 * 2);
  EXPECT_TRUE(same.distance.identical);
  const MeshFile field = with([](std::size_t t) { return 1 + 0x1p-52 * static_cast<double>(t); });
  const std::size_t outer = 2 * 2 * (4 * 3 + 3 * 2 + 2 * 4);
  EXPECT_EQ(compare(field, field).original, (4 * field.cells() - outer) / 2);
}

TEST(Interfaces, MayBeNone) {
  const Geometry box = five_split_box(3, 2, 2);
  const InterfaceComparison none = compare(layered(box, 1, 1, 2), layered(box, 7, 7, 2));
  EXPECT_EQ(none.original, 0u);
  EXPECT_TRUE(none.distance.identical);
  const InterfaceComparison gone = compare(layered(box, 1, 2, 2), layered(box, 1, 1, 2));
  EXPECT_EQ(gone.original, 8u);
  EXPECT_EQ(gone.simplified, 0u);
  EXPECT_FALSE(gone.distance.identical);
  EXPECT_TRUE(std::isinf(gone.distance.first_to_second.max));
}

TEST(Interfaces, OfSeveralArraysLieWhereOneOfThemDiffers) {
  MeshFile file = layered(five_split_box(4, 2, 2), 1, 2, 1);
  MeshFile other = layered(five_split_box(4, 2, 2), 1, 2, 3);
  other.cell_arrays[0].info.name = "second";
  file.cell_arrays.push_back(other.cell_arrays[0]);
  EXPECT_EQ(compare(file, file, {"layer"}).original, 8u);
  EXPECT_EQ(compare(file, file, {"layer", "second"}).original, 16u);
}

TEST(Topology, CountsPartsAndHoles) {
  const auto boundary = [](const MeshFile& file) {
    return compare_files(file, file).simplified.boundary;
  };
  MeshFile box;
  box.geometry = five_split_box(5, 5, 3);
  EXPECT_EQ(boundary(box), (SurfaceTopology{1, 2}));
  const auto without = [&](auto gone) {
    MeshFile file = box;
    std::erase_if(file.geometry.tets, [&](const Tet& t) {
      P low{9, 9, 9};
      for (const VertexId v : t) {
        const P p = testing::point(box.geometry, v);
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      }
      return gone(low);
    });
    return file;
  };
  const auto tunnel = without([](const P& p) { return p.x == 2 && p.y == 2; });
  EXPECT_EQ(boundary(tunnel), (SurfaceTopology{1, 0}));
  const auto hole = without([](const P& p) { return p.x == 2 && p.y == 2 && p.z == 1; });
  EXPECT_EQ(boundary(hole), (SurfaceTopology{2, 4}));
  EXPECT_EQ(compare_files(box, hole).original.boundary, (SurfaceTopology{1, 2}));
}

}  // namespace
}  // namespace tetfusion
