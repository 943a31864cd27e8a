#include "compare/compare.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>

#include "base/error.h"
#include "base/resources.h"
#include "support/comparison.h"

namespace tetfusion {
namespace {

using testing::array_of;
using testing::compare_files;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::make_array;
using testing::MeshFile;
using testing::point_array;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// f(point) as a Float64 array of the points.
template <class F>
MeshFile mesh_with(const Geometry& geometry, F f) {
  MeshFile file;
  file.geometry = geometry;
  file.point_arrays = {point_array<double>(file, "f", f)};
  return file;
}

Vector<Point>& points_of(MeshFile* file) { return std::get<Vector<Point>>(file->geometry.points); }

template <class F>
void move_points(MeshFile* file, F moved) {
  for (Point& p : points_of(file)) p = moved(p);
}

double linear(const Point& p) { return 3 * p.x - 2 * p.y + 0.5 * p.z + 7; }

// A tetrahedron with a point in its middle, where f is 5, and the tetrahedron alone; f is 0 at the
// corners.
struct Split {
  MeshFile original, simplified;
  Split() {
    const Geometry one = testing::single_tet();
    simplified = mesh_with(one, [](const Point&) { return 0; });
    Geometry four =
        testing::make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.25, 0.25, 0.25}},
                           {{4, 1, 2, 3}, {0, 4, 2, 3}, {0, 1, 4, 3}, {0, 1, 2, 4}});
    original = mesh_with(four, [](const Point& p) { return p.x == 0.25 ? 5 : 0; });
  }
};

TEST(Compare, AMeshWithItself) {
  MeshFile mesh = testing::rich_box(5);
  const Comparison c = compare_files(mesh, mesh);
  EXPECT_TRUE(c.identical_surface);
  EXPECT_EQ(c.volume_change, 0);
  EXPECT_EQ(c.outside_points, 0u);
  EXPECT_EQ(c.outside_cells, 0u);
  EXPECT_EQ(c.to_simplified.max, 0);
  EXPECT_EQ(c.original.points, 216u);
  EXPECT_EQ(c.original.tets, 625u);
  EXPECT_EQ(c.original.boundary_triangles, 300u);
  EXPECT_NEAR(c.original.volume, 125, 1e-12);
  EXPECT_THAT(c.missing_arrays, IsEmpty());
  EXPECT_EQ(c.retyped_arrays.size(), 0u);
  ASSERT_EQ(c.arrays.size(), 7u);
  for (const ArrayComparison& a : c.arrays) {
    EXPECT_EQ(a.rms, 0) << a.info.name;
    EXPECT_EQ(a.max, 0) << a.info.name;
    EXPECT_EQ(a.differing, 0) << a.info.name;
    EXPECT_NEAR(a.integral_change, 0, 1e-14) << a.info.name;
    EXPECT_NEAR(a.cell_max, 0, 1e-14) << a.info.name;
    EXPECT_NEAR(a.gradient_rms, 0, 1e-12) << a.info.name;
    EXPECT_EQ(a.l1_error, 0) << a.info.name;
    EXPECT_GT(a.range, 0) << a.info.name;
  }
}

TEST(Compare, ALinearFieldIsTheSameOnAnyMesh) {
  const MeshFile original = mesh_with(testing::five_split_cube(6, 0.2), linear);
  MeshFile simplified = mesh_with(testing::kuhn_box(3, 3, 3, 0.2), linear);
  move_points(&simplified, [](const Point& p) { return Point{2 * p.x, 2 * p.y, 2 * p.z}; });
  simplified.point_arrays = {point_array<double>(simplified, "f", linear)};
  const Comparison c = compare_files(original, simplified);
  EXPECT_EQ(c.outside_points, 0u);
  EXPECT_EQ(c.outside_cells, 0u);
  EXPECT_FALSE(c.identical_surface);
  EXPECT_LT(c.to_simplified.max + c.to_original.max, 1e-15);
  EXPECT_NEAR(c.volume_change, 0, 1e-14);
  const ArrayComparison& f = array_of(c, "f");
  EXPECT_NEAR(f.range, 33, 1e-12);
  EXPECT_LT(f.max, 1e-14);
  EXPECT_LT(f.cell_max, 1e-14);
  EXPECT_LT(f.gradient_rms, 1e-12);
  EXPECT_NEAR(f.integral_change, 0, 1e-13);
}

TEST(Compare, OneValueThatIsAnother) {
  const MeshFile original = mesh_with(testing::five_split_cube(2), linear);
  MeshFile simplified = original;
  simplified.point_arrays[0].as<double>()[5] += 1.1;
  const ArrayComparison f = array_of(compare_files(original, simplified), "f");
  EXPECT_DOUBLE_EQ(f.range, 11);
  EXPECT_NEAR(f.max, 0.1, 1e-15);
  EXPECT_NEAR(f.rms, 0.1 / std::sqrt(27), 1e-15);
  EXPECT_NEAR(f.differing, 1.0 / 27, 1e-15);
  EXPECT_TRUE(f.max_at == testing::point(original.geometry, 5));
}

TEST(Compare, AVertexThatIsGone) {
  const Split split;
  const Comparison c = compare_files(split.original, split.simplified);
  EXPECT_TRUE(c.identical_surface);
  const ArrayComparison& f = array_of(c, "f");
  EXPECT_DOUBLE_EQ(f.max, 1);
  EXPECT_DOUBLE_EQ(f.rms, 1 / std::sqrt(5));
  EXPECT_EQ(f.max_at.y, 0.25);
  EXPECT_NEAR(f.cell_rms, 0.25, 1e-15);
  EXPECT_NEAR(f.cell_max, 0.25, 1e-15);
  EXPECT_NEAR(f.gradient_rms, 1, 1e-14);
  EXPECT_NEAR(f.integral_change, -1, 1e-14);
}

TEST(Compare, VectorsAreMeasuredByTheirLength) {
  MeshFile original = mesh_with(testing::five_split_cube(1), linear);
  original.point_arrays = {
      make_array<float>("v", 8, 3, [](auto i, auto k) { return i == 0 && k < 2 ? 3 + k : 0; })};
  MeshFile simplified = original;
  simplified.point_arrays[0].as<float>()[9] = 3;
  simplified.point_arrays[0].as<float>()[11] = -4;
  const ArrayComparison v = array_of(compare_files(original, simplified), "v");
  EXPECT_DOUBLE_EQ(v.range, 5);
  EXPECT_DOUBLE_EQ(v.max, 1);
  EXPECT_DOUBLE_EQ(v.rms, 1 / std::sqrt(8));
  EXPECT_THAT(v.component_ranges, ElementsAre(3, 4, 0));
}

// The squares of integrals over 1e240 are no numbers any more.
TEST(Compare, VectorsOverAHugeMesh) {
  const auto change = [](double scale) {
    MeshFile original = mesh_with(testing::five_split_cube(1), linear);
    move_points(&original, [&](const Point& p) {
      return Point{scale * p.x, scale * p.y, scale * p.z};
    });
    original.point_arrays = {
        make_array<double>("v", 8, 3, [](auto i, auto k) { return 1.0 + i + k; })};
    MeshFile simplified = original;
    simplified.point_arrays[0].as<double>()[9] = 0;
    return array_of(compare_files(original, simplified), "v").integral_change;
  };
  EXPECT_GT(change(1), 0.01);
  EXPECT_NEAR(change(1e80), change(1), 1e-12);
}

// Nor are those of values beyond 1e154 and below 1e-162.
TEST(Compare, FieldsOfAnyMagnitude) {
  const auto compared = [](double scale) {
    MeshFile original = mesh_with(testing::five_split_cube(3), linear);
    const auto value = [&](auto i, auto k) { return scale * static_cast<double>(i % 7 + 2 * k); };
    original.point_arrays = {make_array<double>("s", original.points(), 1, value),
                             make_array<double>("v", original.points(), 3, value)};
    original.cell_arrays = {make_array<double>("c", original.cells(), 1, value)};
    MeshFile simplified = original;
    simplified.point_arrays[0].as<double>()[20] = 0;
    simplified.point_arrays[1].as<double>()[61] = 3 * scale;
    simplified.cell_arrays[0].as<double>()[8] = 0;
    Comparison c = compare_files(original, simplified);
    for (ArrayComparison& a : c.arrays) {
      EXPECT_GT(a.rms, 0) << a.info.name;
      a.range /= scale;
      for (double& range : a.component_ranges) range /= scale;
    }
    return testing::describe(c);
  };
  const std::string usual = compared(1);
  for (const double scale : {0x1p+1018, 0x1p+500, 0x1p-500, 0x1p-1020}) {
    EXPECT_EQ(compared(scale), usual) << scale;
  }
}

// What one of the meshes has there decides, too.
TEST(Compare, AHugeValueInOneOfTheMeshes) {
  Split split;
  split.simplified.point_arrays[0].as<double>()[2] = 1e300;
  const ArrayComparison added = array_of(compare_files(split.original, split.simplified), "f");
  EXPECT_EQ(added.undefined, 0u);
  EXPECT_DOUBLE_EQ(added.range, 5);
  EXPECT_DOUBLE_EQ(added.max, 2e299);
  split.simplified.point_arrays[0].as<double>()[2] = 0;
  split.original.point_arrays[0].as<double>()[4] = 1e300;
  const ArrayComparison gone = array_of(compare_files(split.original, split.simplified), "f");
  EXPECT_EQ(gone.undefined, 0u);
  EXPECT_DOUBLE_EQ(gone.range, 1e300);
  EXPECT_DOUBLE_EQ(gone.max, 1);
}

// The box [0, 2] x [0, 1] x [0, 1], and the part of it where x < 1.5.
TEST(Compare, WhatIsCutOff) {
  const auto x = [](const Point& p) { return p.x; };
  const MeshFile original = mesh_with(testing::five_split_box(2, 1, 1), x);
  MeshFile simplified = original;
  move_points(&simplified, [](const Point& p) { return Point{std::min(p.x, 1.5), p.y, p.z}; });
  simplified.point_arrays = {point_array<double>(simplified, "f", x)};
  const Comparison c = compare_files(original, simplified);
  const double diagonal = std::sqrt(6);
  EXPECT_DOUBLE_EQ(c.diagonal, diagonal);
  EXPECT_EQ(c.outside_points, 4u);
  EXPECT_NEAR(c.outside_max, 0.5 / diagonal, 1e-15);
  EXPECT_NEAR(c.volume_change, -0.25, 1e-15);
  EXPECT_NEAR(c.to_simplified.max, 0.5 / diagonal, 1e-15);
  EXPECT_NEAR(c.to_original.max, 1 / diagonal / 3, 1e-15);
  const ArrayComparison& f = array_of(c, "f");
  EXPECT_NEAR(f.max, 0.25, 1e-15);
  EXPECT_NEAR(f.rms, 0.25 * std::sqrt(4.0 / 12), 1e-15);
  EXPECT_NEAR(f.integral_change, -0.4375, 1e-14);
}

TEST(Compare, ASurfaceThatIsShifted) {
  const double shift = 1.0 / 64;
  const MeshFile original = mesh_with(testing::five_split_cube(1), linear);
  MeshFile simplified = original;
  move_points(&simplified, [&](const Point& p) { return Point{p.x + shift, p.y, p.z}; });
  const Comparison c = compare_files(original, simplified);
  EXPECT_FALSE(c.identical_surface);
  for (const SurfaceShares& s : {c.to_simplified, c.to_original}) {
    EXPECT_NEAR(s.max * c.diagonal, shift, 1e-15);
    EXPECT_NEAR(s.mean * c.diagonal, 0.375 * shift, 1e-15);
  }
  EXPECT_NEAR(c.volume_between, 6 * shift, 1e-14);
  EXPECT_EQ(c.outside_points, 4u);
}

// Float32, turned so that nothing lies on a plane exactly: points of the fine cube's faces are on
// the coarse one's to rounding.
TEST(Compare, RoundingIsNotOutside) {
  const auto turned = [](Geometry mesh, double scale, double offset) {
    for (Point& p : std::get<Vector<Point>>(mesh.points)) {
      const double x = scale * (0.8 * p.x - 0.6 * p.y), y = scale * (0.6 * p.x + 0.8 * p.y);
      const double z = scale * p.z;
      p = {x + offset, 0.28 * y - 0.96 * z, 0.96 * y + 0.28 * z - offset};
    }
    return testing::to_float(mesh);
  };
  for (const double offset : {0.0, 100.0, 4000.0}) {
    MeshFile original, simplified;
    original.geometry = turned(testing::five_split_cube(9, 0.1), 0.1, offset);
    simplified.geometry = turned(testing::kuhn_box(1, 1, 1), 0.9, offset);
    Comparison c = compare_files(original, simplified);
    EXPECT_EQ(c.outside_points, 0u) << offset;
    EXPECT_EQ(c.outside_cells, 0u) << offset;
    EXPECT_LE(std::max(c.to_simplified.max, c.to_original.max), c.rounding) << offset;
    simplified.geometry = turned(testing::kuhn_box(1, 1, 1), 0.8, offset);
    EXPECT_GT(compare_files(original, simplified).outside_points, 200u) << offset;
  }
}

// A ball in Float32, and the same surface with a single point inside it.
TEST(Compare, ACurvedSurfaceThatIsTheSame) {
  Geometry cube = testing::five_split_cube(10, 0.1);
  auto& points = std::get<Vector<Point>>(cube.points);
  for (Point& p : points) {
    const Point d{p.x / 5 - 1, p.y / 5 - 1, p.z / 5 - 1};
    const double square = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
    const double round = std::hypot(d.x, d.y, d.z);
    const double s = round > 0 ? square / round : 0;
    p = {17 + s * d.x, s * d.y, s * d.z - 3};
  }
  MeshFile original, simplified;
  original.geometry = testing::to_float(cube);
  points.push_back({17, 0, -3});
  Geometry star = testing::to_float(cube);
  const auto centre = static_cast<VertexId>(points.size() - 1);
  std::map<std::array<VertexId, 3>, int> faces;
  for (const Tet& t : cube.tets) {
    for (std::size_t i = 0; i < 4; ++i) {
      std::array<VertexId, 3> face{t[(i + 1) % 4], t[(i + 2) % 4], t[(i + 3) % 4]};
      std::sort(face.begin(), face.end());
      ++faces[face];
    }
  }
  star.tets.clear();
  for (const auto& [face, cells] : faces) {
    if (cells == 1) star.tets.push_back({centre, face[0], face[1], face[2]});
  }
  simplified.geometry = star;
  const Comparison c = compare_files(original, simplified);
  EXPECT_TRUE(c.identical_surface);
  EXPECT_EQ(c.original.boundary_triangles, 1200u);
  EXPECT_EQ(c.outside_points, 0u);
  EXPECT_EQ(c.outside_cells, 0u);
  EXPECT_NEAR(c.volume_change, 0, 1e-4);  // cells at the edges of the cube have become flat
}

TEST(Compare, WindingDoesNotMatter) {
  const MeshFile original = mesh_with(testing::five_split_cube(3, 0.2), linear);
  MeshFile simplified = original;
  for (std::size_t t = 0; t < simplified.geometry.tets.size(); t += 2) {
    testing::flip_winding(&simplified.geometry.tets[t]);
  }
  const Comparison c = compare_files(original, simplified);
  EXPECT_TRUE(c.identical_surface);
  EXPECT_NEAR(c.volume_change, 0, 1e-14);
  EXPECT_EQ(c.arrays[0].max, 0);
  EXPECT_LT(c.arrays[0].cell_max, 1e-14);
}

// Two tetrahedra whose common face has two points in each corner, with values of their own.
TEST(Compare, TheSidesOfACrackKeepTheirValues) {
  MeshFile mesh;
  mesh.geometry = testing::make_mesh(
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1}},
      {{0, 1, 2, 3}, {4, 6, 5, 7}});
  mesh.point_arrays = {
      make_array<float>("slip", 8, 1, [](auto i, auto) { return i < 4 ? 1 : -1; })};
  const Comparison c = compare_files(mesh, mesh);
  EXPECT_TRUE(c.identical_surface);
  EXPECT_EQ(c.arrays[0].max, 0);
  EXPECT_EQ(c.arrays[0].cell_max, 0);
}

TEST(Compare, IntegersAreThoseOfTheNearestCorner) {
  Split split;
  split.original.point_arrays = {
      make_array<std::int32_t>("id", 5, 1, [](auto i, auto) { return i == 4 ? 3 : 10 * i; })};
  split.simplified.point_arrays = {
      make_array<std::int32_t>("id", 4, 1, [](auto i, auto) { return 10 * i; })};
  points_of(&split.original)[4] = {0.2, 0.3, 0.25};
  const ArrayComparison id = array_of(compare_files(split.original, split.simplified), "id");
  EXPECT_TRUE(id.integer);
  EXPECT_DOUBLE_EQ(id.max, 17.0 / 30);  // from corner 2
  EXPECT_DOUBLE_EQ(id.differing, 0.2);
}

// Where nobody uses the first point, and where the other mesh has them in another type.
TEST(Compare, LongIntegersAreCountedFromOneInUse) {
  constexpr std::int64_t kFar = std::int64_t{1} << 60;
  Split split;
  points_of(&split.original).insert(points_of(&split.original).begin(), Point{9, 9, 9});
  for (Tet& tet : split.original.geometry.tets) {
    for (VertexId& v : tet) ++v;
  }
  split.original.point_arrays = {make_array<std::int64_t>(
      "id", 6, 1, [](auto i, auto) { return i == 0 ? -1 : kFar + static_cast<std::int64_t>(i); })};
  split.simplified.point_arrays = {make_array<std::uint64_t>(
      "id", 4, 1, [](auto i, auto) { return std::uint64_t{kFar} + i + 1 + (i == 2 ? 8 : 0); })};
  const ArrayComparison id = array_of(compare_files(split.original, split.simplified), "id");
  EXPECT_EQ(id.range, 4);
  EXPECT_EQ(id.max, 2.0);  // at the third corner
  EXPECT_DOUBLE_EQ(id.differing, 0.4);
}

TEST(Compare, ValuesThatAreNotFinite) {
  MeshFile original = mesh_with(testing::five_split_cube(2), linear);
  original.point_arrays[0].as<double>()[7] = kNan;
  MeshFile simplified = original;
  simplified.point_arrays[0].as<double>()[11] = -std::numeric_limits<double>::infinity();
  Comparison c = compare_files(original, simplified);
  EXPECT_EQ(c.arrays[0].non_finite, 1u);
  EXPECT_EQ(c.arrays[0].undefined, 1u);
  EXPECT_EQ(c.arrays[0].undefined_at.x, points_of(&original)[11].x);
  EXPECT_EQ(c.arrays[0].undefined_at.y, points_of(&original)[11].y);
  EXPECT_EQ(c.arrays[0].max, 0);
  EXPECT_TRUE(std::isfinite(c.arrays[0].integral_change));
  EXPECT_TRUE(std::isfinite(c.arrays[0].gradient_rms));
  Bounds bounds;
  bounds.max_error = 0;
  EXPECT_TRUE(judge_bounds(c, bounds)[0].broken);  // there was a value
  simplified.point_arrays[0].as<double>()[11] = original.point_arrays[0].as<double>()[11];
  EXPECT_FALSE(judge_bounds(compare_files(original, simplified), bounds)[0].broken);
}

// A corner without a value tells nothing about points on the face opposite to it, nor about those
// that rounding takes off that face.
TEST(Compare, ACornerWithoutAValueHasNoSayWhereItHasNoWeight) {
  for (const double height : {0.0, 1e-9, 0.1}) {
    Split split;
    points_of(&split.original)[4] = {0.4, 0.3, height};
    split.original.point_arrays[0].as<double>()[3] = kNan;
    split.simplified.point_arrays[0].as<double>()[3] = kNan;
    const Comparison c = compare_files(split.original, split.simplified);
    EXPECT_EQ(c.arrays[0].undefined, height < 1e-6 ? 0u : 1u) << height;
    EXPECT_EQ(c.arrays[0].non_finite, 1u);
  }
}

TEST(Compare, AnotherNumberOfComponentsBreaksABound) {
  const MeshFile original = mesh_with(testing::five_split_cube(2), linear);
  MeshFile simplified = original;
  simplified.point_arrays[0] = make_array<double>("f", 27, 2, [](auto, auto) { return 1.0; });
  Bounds bounds;
  bounds.max_error = 1;
  for (const bool named : {false, true}) {
    if (named) bounds.arrays = {"f"};
    const auto results = judge_bounds(compare_files(original, simplified), bounds);
    ASSERT_EQ(results.size(), 1u) << named;
    EXPECT_TRUE(results[0].broken) << named;
  }
}

TEST(Compare, ConstantFields) {
  const MeshFile original = mesh_with(testing::five_split_cube(1), [](const Point&) { return -8; });
  MeshFile simplified = original;
  EXPECT_EQ(compare_files(original, simplified).arrays[0].max, 0);
  simplified.point_arrays[0].as<double>()[2] = -6;
  const ArrayComparison f = compare_files(original, simplified).arrays[0];
  EXPECT_EQ(f.range, 0);
  EXPECT_DOUBLE_EQ(f.max, 0.25);
  EXPECT_TRUE(std::isinf(f.gradient_rms));
}

// Two pyramids whose common square is cut along one diagonal from above, along the other from
// below, with a flat cell between.
TEST(Compare, FlatCellsHaveNoCentre) {
  MeshFile mesh;
  mesh.geometry = testing::make_mesh(
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 1}, {0.5, 0.5, -1}},
      {{0, 1, 2, 4}, {0, 2, 3, 4}, {0, 1, 2, 3}, {1, 0, 3, 5}, {2, 1, 3, 5}});
  mesh.point_arrays = {
      make_array<double>("f", 6, 1, [](auto i, auto) { return i == 0 || i == 2 ? 1 : 0; })};
  mesh.cell_arrays = {make_array<double>("q", 5, 1, [](auto i, auto) { return i; })};
  const Comparison c = compare_files(mesh, mesh);
  EXPECT_NEAR(array_of(c, "f").cell_max, 0, 1e-15);
  EXPECT_EQ(array_of(c, "q").max, 0);
}

TEST(Compare, CellArrays) {
  MeshFile original;
  original.geometry = testing::five_split_cube(1);  // volumes 1/3, and four of 1/6
  original.cell_arrays = {
      make_array<float>("q", 5, 1, [](auto i, auto) { return i; }),
      make_array<std::int8_t>("part", 5, 1, [](auto i, auto) { return i / 3; })};
  MeshFile simplified = original;
  simplified.cell_arrays[0].as<float>()[2] = -6;
  simplified.cell_arrays[1].as<std::int8_t>()[4] = 7;
  const Comparison c = compare_files(original, simplified);
  const ArrayComparison& q = array_of(c, "q");
  EXPECT_EQ(q.association, Association::kCell);
  EXPECT_DOUBLE_EQ(q.max, 2);
  EXPECT_NEAR(q.rms, 2 / std::sqrt(6), 1e-14);
  EXPECT_NEAR(q.integral_change, -0.8, 1e-14);
  EXPECT_NEAR(q.l1_change, 0.4, 1e-14);
  EXPECT_NEAR(q.l1_error, 0.8, 1e-14);
  const ArrayComparison& part = array_of(c, "part");
  EXPECT_NEAR(part.differing, 1.0 / 6, 1e-14);
  ASSERT_EQ(part.regions.size(), 3u);
  EXPECT_NEAR(part.regions[0].original, 2.0 / 3, 1e-14);
  EXPECT_NEAR(part.regions[0].simplified, 2.0 / 3, 1e-14);
  EXPECT_NEAR(part.regions[1].simplified, 1.0 / 6, 1e-14);
  EXPECT_EQ(part.regions[2].value, 7);
  EXPECT_EQ(part.regions[2].original, 0);
}

// Labels that a program has written as floating-point numbers have volumes, too; a field has not,
// if only its name is one of a material. Numbers too large to be squared come out as they are.
TEST(Compare, RegionsOfFloats) {
  MeshFile original;
  original.geometry = testing::five_split_cube(1);
  const double nan = std::nan("");
  original.cell_arrays = {
      make_array<float>("part", 5, 1, [](auto i, auto) { return i / 3 + 0.5; }),
      make_array<double>("material", 5, 1, [&](auto i, auto) { return i < 4 ? 1e200 : nan; })};
  MeshFile simplified = original;
  simplified.cell_arrays[0].as<float>()[4] = 7;
  const Comparison c = compare_files(original, simplified);
  const ArrayComparison& part = array_of(c, "part");
  ASSERT_EQ(part.regions.size(), 3u);
  EXPECT_EQ(part.regions[0].value, 0.5);
  EXPECT_NEAR(part.regions[0].original, 2.0 / 3, 1e-14);
  EXPECT_NEAR(part.regions[0].simplified, 2.0 / 3, 1e-14);
  EXPECT_NEAR(part.regions[1].simplified, 1.0 / 6, 1e-14);
  EXPECT_EQ(part.regions[2].value, 7);
  EXPECT_EQ(part.regions[2].original, 0);
  EXPECT_FALSE(part.integer);
  const ArrayComparison& material = array_of(c, "material");
  ASSERT_EQ(material.regions.size(), 1u);
  EXPECT_NEAR(material.regions[0].value / 1e200, 1, 1e-15);
  EXPECT_EQ(material.non_finite, 1u);
  MeshFile field;
  field.geometry = testing::five_split_cube(12);
  field.cell_arrays = {
      make_array<float>("part", field.cells(), 1, [](auto i, auto) { return 0.5 * i; })};
  EXPECT_TRUE(array_of(compare_files(field, field), "part").regions.empty());
}

TEST(Compare, ArraysThatAreMissingOrOfAnotherType) {
  MeshFile original = testing::rich_box(3);
  MeshFile simplified = original;
  simplified.point_arrays.pop_back();  // tensor
  simplified.point_arrays[2] =
      make_array<std::uint8_t>("rgb", original.points(), 2, [](auto, auto) { return 0; });
  simplified.point_arrays[0] = point_array<double>(
      original, "f", [](const Point& p) { return static_cast<float>(std::sin(p.x / 2) * p.y); });
  simplified.cell_arrays.erase(simplified.cell_arrays.begin() + 1);
  simplified.field_arrays.clear();
  const Comparison c = compare_files(original, simplified);
  EXPECT_THAT(c.missing_arrays, ElementsAre("tensor", "cell:stress", "field:TimeValue"));
  ASSERT_EQ(c.retyped_arrays.size(), 2u);
  EXPECT_EQ(c.retyped_arrays[0].name, "f");
  EXPECT_EQ(c.retyped_arrays[0].original, "Float32");
  EXPECT_EQ(c.retyped_arrays[0].simplified, "Float64");
  EXPECT_EQ(c.retyped_arrays[1].simplified, "UInt8 x 2");
  EXPECT_EQ(array_of(c, "f").max, 0);
  EXPECT_THROW(array_of(c, "rgb"), std::runtime_error);
}

TEST(Compare, TheSameForAnyNumberOfThreads) {
  const auto wave = [](const Point& p) { return std::sin(p.x) * std::cos(p.y + p.z); };
  const MeshFile original = mesh_with(testing::five_split_cube(22, 0.2, 5), wave);
  MeshFile simplified = mesh_with(testing::kuhn_box(11, 11, 11, 0.2, 6), wave);
  move_points(&simplified, [](const Point& p) { return Point{2 * p.x, 2 * p.y, 1.9 * p.z}; });
  simplified.point_arrays = {point_array<double>(simplified, "f", wave)};
  set_thread_count(1);
  const std::string one = testing::describe(compare_files(original, simplified));
  for (int threads = 2; threads <= 4; ++threads) {
    set_thread_count(threads);
    EXPECT_EQ(testing::describe(compare_files(original, simplified)), one) << threads;
  }
  set_thread_count(0);
}

TEST(Compare, AMeshWithoutBoundaryIsRefused) {
  MeshFile mesh;
  mesh.geometry = testing::single_tet();
  MeshFile doubled = mesh;
  doubled.geometry.tets.push_back(doubled.geometry.tets[0]);
  EXPECT_THROW(compare_files(mesh, doubled), Error);
  EXPECT_THROW(compare_files(doubled, mesh), Error);
}

TEST(Bounds, SayWhichIsBroken) {
  const Split split;
  Comparison c = compare_files(split.original, split.simplified);
  Bounds bounds;
  EXPECT_THAT(judge_bounds(c, bounds), IsEmpty());
  bounds.max_error = 1;
  bounds.max_rms = 0.4;
  bounds.surface = 0;
  const auto results = judge_bounds(c, bounds);
  ASSERT_EQ(results.size(), 3u);
  EXPECT_EQ(results[0].bound, "max_rms");
  EXPECT_TRUE(results[0].broken);
  EXPECT_EQ(results[0].sentence, "--max-rms is broken: the rms error of f is 44.72 %, above 40 %");
  EXPECT_FALSE(results[1].broken);
  EXPECT_FALSE(results[2].broken);
  c.to_original.max = 0.01;
  bounds.surface = 0.009;
  EXPECT_TRUE(judge_bounds(c, bounds)[2].broken);
  bounds.surface = 0.01;
  EXPECT_FALSE(judge_bounds(c, bounds)[2].broken);
}

TEST(Bounds, RoundingOfTheTypeIsNotHeldAgainstIt) {
  MeshFile original = mesh_with(testing::five_split_cube(1), linear);
  original.point_arrays = {
      make_array<float>("f", 8, 1, [](auto i, auto) { return 1000 + 0.1 * i; })};
  MeshFile simplified = original;
  float& value = simplified.point_arrays[0].as<float>()[3];
  value = std::nextafter(value, 2000.0f);
  Bounds bounds;
  bounds.max_error = 0;
  EXPECT_FALSE(judge_bounds(compare_files(original, simplified), bounds)[0].broken);
  value += 0.01f;
  EXPECT_TRUE(judge_bounds(compare_files(original, simplified), bounds)[0].broken);
}

TEST(Bounds, HoldForTheArraysThatAreNamed) {
  MeshFile original = mesh_with(testing::five_split_cube(1), linear);
  original.point_arrays.push_back(make_array<float>("g", 8, 1, [](auto i, auto) { return i; }));
  original.point_arrays.push_back(make_array<int>("i", 8, 1, [](auto i, auto) { return i; }));
  MeshFile simplified = original;
  simplified.point_arrays[1].as<float>()[0] = 7;
  simplified.point_arrays[2].as<int>()[0] = 7;
  const Comparison c = compare_files(original, simplified);
  Bounds bounds;
  bounds.max_error = 0.5;
  EXPECT_EQ(judge_bounds(c, bounds).size(), 2u);
  bounds.arrays = {"f"};
  ASSERT_EQ(judge_bounds(c, bounds).size(), 1u);
  EXPECT_FALSE(judge_bounds(c, bounds)[0].broken);
  bounds.arrays = {"i"};
  ASSERT_EQ(judge_bounds(c, bounds).size(), 1u);
  EXPECT_TRUE(judge_bounds(c, bounds)[0].broken);
}

}  // namespace
}  // namespace tetfusion
