// Finding places, triangles and faces, against looking at all of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <vector>

#include "compare/face_match.h"
#include "compare/locator.h"
#include "compare/simplified_mesh.h"
#include "compare/sorted_by_key.h"
#include "compare/triangles.h"
#include "io/open_mesh.h"
#include "mesh/box_tree.h"
#include "support/mesh_file.h"
#include "support/meshes.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using testing::MeshFile;
using testing::TempDir;
using testing::uniform;

Point random_point(std::uint64_t seed, std::uint64_t i, double size) {
  return {size * uniform(seed, 3 * i), size * uniform(seed, 3 * i + 1),
          size * uniform(seed, 3 * i + 2)};
}

SimplifiedMesh load(const Geometry& geometry) {
  const TempDir dir = TempDir::in_memory();
  MeshFile file;
  file.geometry = geometry;
  file.write(dir.file("mesh.vtu"));
  return load_simplified(open_mesh(dir.file("mesh.vtu")).get(), {}, {});
}

Point at(const SimplifiedMesh& mesh, const Place& place) {
  Point p{0, 0, 0};
  const Corners corners = mesh.corners(place.tet);
  for (std::size_t i = 0; i < 4; ++i) p = p + place.weights[i] * corners[i];
  return p;
}

TEST(BoxTree, FindsWhatHoldsAPoint) {
  for (const std::size_t items : {1u, 7u, 8u, 9u, 64u, 65u, 1000u}) {
    std::vector<PointBox> boxes(items);
    for (std::size_t i = 0; i < items; ++i) {
      const Point p = random_point(1, i, 10);
      boxes[i].add(p);
      boxes[i].add(p + random_point(2, i, 1));
    }
    BoxTree tree;
    tree.build(items, {3, 3, 3}, [&](std::size_t i) { return boxes[i]; });
    for (std::uint64_t i = 0; i < 200; ++i) {
      const Point p = random_point(3, i, 11);
      std::vector<std::uint32_t> found, all;
      tree.find(p, 0, [&](std::uint32_t item) {
        const PointBox& b = boxes[item];
        const bool inside = p.x >= b.low.x && p.x <= b.high.x && p.y >= b.low.y &&
                            p.y <= b.high.y && p.z >= b.low.z && p.z <= b.high.z;
        if (inside) found.push_back(item);
        return false;
      });
      for (std::uint32_t item = 0; item < items; ++item) {
        const PointBox& b = boxes[item];
        if (p.x >= b.low.x && p.x <= b.high.x && p.y >= b.low.y && p.y <= b.high.y &&
            p.z >= b.low.z && p.z <= b.high.z) {
          all.push_back(item);
        }
      }
      EXPECT_EQ(found, all);
    }
  }
}

TEST(Triangles, TheNearestOfOne) {
  const std::array<Point, 3> t{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};
  const auto squared = [&](const Point& p) { return nearest_on_triangle(p, t).squared; };
  EXPECT_EQ(squared({1, 1, 3}), 9);       // above it
  EXPECT_EQ(squared({1, -2, 0}), 4);      // beside an edge
  EXPECT_EQ(squared({-3, -4, 12}), 169);  // beyond a corner
  EXPECT_NEAR(squared({4, 4, 0}), 8, 1e-14);
  const std::array<Point, 3> line{{{0, 0, 0}, {1, 0, 0}, {3, 0, 0}}};
  EXPECT_EQ(nearest_on_triangle({2, 2, 0}, line).squared, 4);
  const std::array<Point, 3> dot{{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}};
  EXPECT_EQ(nearest_on_triangle({1, 1, 3}, dot).squared, 4);
  // Corners on a slanted line, but for rounding: the normal is nothing but that.
  for (int i = 1; i < 100; ++i) {
    const auto at = [&](double s) {
      return Point{0.1 + s * 0.3, 0.7 + s * std::sin(i), 0.2 - s / (3 + i)};
    };
    const std::array<Point, 3> needle{at(0), at(0.37), at(1)};
    for (const double s : {0.11, 0.5, 0.93}) {
      EXPECT_LT(nearest_on_triangle(at(s), needle).squared, 1e-28) << i;
    }
  }
}

TEST(Triangles, TheNearestOfMany) {
  TriangleSet set;
  for (std::uint32_t i = 0; i < 300; ++i) {
    const Point p = random_point(4, i, 10);
    for (std::uint64_t k = 0; k < 3; ++k) set.points.push_back(p + random_point(5, 3 * i + k, 1));
    set.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  order_triangles(&set);
  const TriangleFinder finder(&set);
  for (std::uint64_t i = 0; i < 300; ++i) {
    const Point p = random_point(6, i, 14);
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t < set.triangles.size(); ++t) {
      least = std::min(least, nearest_on_triangle(p, set.corners(t)).squared);
    }
    EXPECT_EQ(finder.nearest(p, static_cast<std::uint32_t>(i)).nearest.squared, least);
  }
}

TEST(FaceMatch, FindsAllFacesInAnyNumberOfPasses) {
  const Geometry mesh = testing::five_split_cube(6);
  const std::size_t points = point_count(mesh.points);
  std::map<std::array<VertexId, 3>, std::vector<std::uint32_t>> all;
  for (std::uint32_t t = 0; t < mesh.tets.size(); ++t) {
    for (std::uint32_t i = 0; i < 4; ++i) {
      const Tet& c = mesh.tets[t];
      std::array<VertexId, 3> face{c[(i + 1) % 4], c[(i + 2) % 4], c[(i + 3) % 4]};
      std::sort(face.begin(), face.end());
      all[face].push_back(4 * t + i);
    }
  }
  const ReadCells read = [&](const auto& take) {
    const std::span<const Tet> tets(mesh.tets);
    take({0, tets.first(100)});
    take({100, tets.subspan(100)});
  };
  for (const std::size_t most : {1u, 1000u, 1000000u}) {
    const Vector<CellSide> kept = match_faces(points, most, read, [&](std::span<const CellSide> f) {
      const auto& sides = all.at({f[0].low, f[0].middle, f[0].high});
      bool same = sides.size() == f.size();
      for (std::size_t i = 0; same && i < f.size(); ++i) same = sides[i] == f[i].side;
      return same;
    });
    ASSERT_EQ(kept.size(), all.size());
    auto expected = all.begin();
    for (const CellSide& s : kept) {
      EXPECT_EQ((std::array{s.low, s.middle, s.high}), (expected++)->first);
    }
  }
}

TEST(FaceMatch, FindsTheSameSingleSidesWithoutHoldingTheOthers) {
  Geometry mesh = testing::five_split_cube(12);
  // Triangles with two sides of one cell, with three, with four, and cells without any neighbour.
  for (const std::size_t t : {0u, 7u, 7u, 200u, 200u, 200u}) mesh.tets.push_back(mesh.tets[t]);
  mesh.tets.push_back({0, 0, 1, 2});
  mesh.tets.push_back({3, 500, 900, 1200});
  const std::size_t points = point_count(mesh.points);
  int reads = 0;
  const ReadCells read = [&](const auto& take) {
    ++reads;
    const std::span<const Tet> tets(mesh.tets);
    take({0, tets.first(1000)});
    take({1000, tets.subspan(1000)});
  };
  const Vector<CellSide> expected = match_faces(
      points, 1000000, read, [](std::span<const CellSide> face) { return face.size() == 1; });
  ASSERT_GT(expected.size(), 12u * 12 * 12);
  for (const std::size_t most : {1u, 1000u, 1000000u}) {
    reads = 0;
    const Vector<CellSide> found = find_single_sides(points, most, read);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(
          (std::array{found[i].low, found[i].middle, found[i].high, found[i].side}),
          (std::array{expected[i].low, expected[i].middle, expected[i].high, expected[i].side}));
    }
    if (most == 1000000u) {
      EXPECT_EQ(reads, 3);
    }
  }
}

class LocatorOnMeshes : public ::testing::TestWithParam<bool> {};

TEST_P(LocatorOnMeshes, FindsEveryPoint) {
  const Geometry cube = testing::five_split_cube(5, 0.2);
  const SimplifiedMesh mesh = load(GetParam() ? testing::to_float(cube) : cube);
  const Locator locator(&mesh, GetParam() ? ValueType::kFloat32 : ValueType::kFloat64);
  LocatorHint hint;
  for (std::uint64_t i = 0; i < 3000; ++i) {
    const Point p = random_point(7, i, 6);
    LocatorHint fresh;
    for (LocatorHint* h : {&hint, &fresh}) {
      const Place place = locator.locate(p, h);
      const Point inside{std::min(p.x, 5.0), std::min(p.y, 5.0), std::min(p.z, 5.0)};
      EXPECT_EQ(place.outside, !(p == inside));
      EXPECT_NEAR(length(at(mesh, place) - inside), 0, 1e-13);
      EXPECT_NEAR(place.distance, length(p - inside), 1e-13);
    }
  }
}

TEST_P(LocatorOnMeshes, FindsPointsOfFacesEdgesAndCorners) {
  const Geometry cube = testing::five_split_cube(4, 0.2);
  const SimplifiedMesh mesh = load(GetParam() ? testing::to_float(cube) : cube);
  const Locator locator(&mesh, GetParam() ? ValueType::kFloat32 : ValueType::kFloat64);
  LocatorHint hint;
  const std::vector<std::array<double, 4>> weights{
      {1, 0, 0, 0}, {0.5, 0.5, 0, 0}, {0.3, 0, 0.7, 0}, {0.2, 0.3, 0.5, 0}, {0, 0.1, 0.6, 0.3}};
  for (TetId t = 0; t < mesh.tets.size(); ++t) {
    for (const auto& w : weights) {
      const Point p = at(mesh, {t, w, false, 0});
      const Place place = locator.locate(p, &hint);
      EXPECT_FALSE(place.outside);
      EXPECT_NEAR(length(at(mesh, place) - p), 0, 1e-14);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Types, LocatorOnMeshes, ::testing::Values(false, true));

TEST(Locator, SeesACornerBehindANotch) {
  Geometry mesh = testing::five_split_box(6, 1, 1);
  std::erase_if(mesh.tets, [&](const Tet& t) {  // two parts that do not touch
    return std::all_of(t.begin(), t.end(), [&](VertexId v) {
      const double x = testing::point(mesh, v).x;
      return x >= 2 && x <= 4;
    });
  });
  const SimplifiedMesh loaded = load(mesh);
  const Locator locator(&loaded, ValueType::kFloat64);
  LocatorHint hint;
  for (int i = 0; i < 20; ++i) {
    for (const double x : {0.3, 5.6, 2.75, 1.2}) {
      const Place place = locator.locate({x, 0.4, 0.3}, &hint);
      EXPECT_EQ(place.outside, x == 2.75);
      EXPECT_NEAR(at(loaded, place).x, x == 2.75 ? 2 : x, 1e-14);
    }
  }
}

// Seen from far away volumes tell nothing certain.
TEST(Locator, FindsWhatIsFarFromWhereItBegins) {
  Geometry mesh = testing::five_split_cube(4, 0.2);
  const Geometry other = testing::five_split_cube(4, 0.2, 9);
  auto& points = std::get<Vector<Point>>(mesh.points);
  const auto first = static_cast<VertexId>(points.size());
  constexpr double kApart = 1e9;
  for (const Point& p : std::get<Vector<Point>>(other.points)) {
    points.push_back({p.x + kApart, p.y, p.z});
  }
  for (const Tet& t : other.tets) {
    mesh.tets.push_back({t[0] + first, t[1] + first, t[2] + first, t[3] + first});
  }
  const SimplifiedMesh loaded = load(mesh);
  const Locator locator(&loaded, ValueType::kFloat64);
  LocatorHint hint;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    Point p = random_point(3, i, 4);
    if (i % 2 == 1) p.x += kApart;
    const Place place = locator.locate(p, &hint);
    EXPECT_FALSE(place.outside);
    EXPECT_NEAR(length(at(loaded, place) - p), 0, 1e-6);
  }
}

TEST(Locator, AFlatCellHoldsNothing) {
  Geometry mesh = testing::make_mesh({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}, {4, 4, 0}},
                                     {{0, 1, 2, 3}, {0, 1, 4, 2}});
  const SimplifiedMesh loaded = load(mesh);
  const Locator locator(&loaded, ValueType::kFloat64);
  LocatorHint hint;
  EXPECT_TRUE(locator.locate({3, 3, 1}, &hint).outside);
  EXPECT_FALSE(locator.locate({1, 1, 0}, &hint).outside);
  EXPECT_FALSE(locator.locate({3, 3, 0}, &hint).outside);  // on its surface
}

// Of a sliver as high as rounding is large: what is nearest, not where weights would be without
// those below 0.
TEST(Locator, BesideASliver) {
  Geometry mesh;
  const double height = 0x1p-22;
  mesh.points = Vector<Vec3<double>>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, height}};
  mesh.tets = {{0, 1, 2, 3}};
  const SimplifiedMesh loaded = load(mesh);
  const Locator locator(&loaded, ValueType::kFloat32);
  for (std::uint64_t i = 0; i < 100; ++i) {
    const Point on_base{0.05 + 0.4 * uniform(5, 2 * i), 0.05 + 0.4 * uniform(5, 2 * i + 1), 0};
    LocatorHint hint;
    const Point below = on_base - Point{0, 0, height * uniform(6, i)};
    const Place place = locator.locate(below, &hint);
    EXPECT_FALSE(place.outside);
    EXPECT_LT(length(at(loaded, place) - on_base), 1e-12);
  }
}

TEST(Locator, AllPointsInOnePlace) {
  const SimplifiedMesh mesh = load(testing::make_mesh(
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-0.0, 0, 0}, {0, 1, -1}, {1, 0, -1}},
      {{0, 1, 2, 3}, {4, 1, 5, 6}}));
  const Locator locator(&mesh, ValueType::kFloat64);
  std::vector<VertexId> found;
  locator.for_each_vertex_at({0, 0, 0}, kAnyPart, [&](VertexId v) { found.push_back(v); });
  EXPECT_EQ(found.size(), 2u);
  found.clear();
  locator.for_each_vertex_at({0, 0, 1e-300}, kAnyPart, [&](VertexId v) { found.push_back(v); });
  EXPECT_TRUE(found.empty());
}

// More than one block of them.
TEST(SortedByKey, IsStable) {
  Vector<std::uint32_t> keys(100'001);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    keys[i] = static_cast<std::uint32_t>(uniform(7, i) * (i % 2 == 0 ? 1 << 30 : 1 << 10));
  }
  Vector<std::uint32_t> expected = count_up<std::uint32_t>(keys.size());
  std::stable_sort(expected.begin(), expected.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; });
  EXPECT_EQ(sorted_by_key(keys, 30), expected);
  EXPECT_TRUE(sorted_by_key({}, 30).empty());
}

}  // namespace
}  // namespace tetfusion
