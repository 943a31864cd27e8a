#include "generate/generate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "base/error.h"
#include "base/resources.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "mesh/predicates.h"
#include "support/mesh_file.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using testing::bytes_of;
using ::testing::HasSubstr;
using testing::TempDir;

Geometry generate(const GenerateOptions& options) {
  const TempDir dir;
  const GeneratedSize size = generate_mesh(options, dir.file("a.vtu"));
  Geometry mesh = open_mesh(dir.file("a.vtu"))->read_geometry();
  EXPECT_EQ(size.points, point_count(mesh.points));
  EXPECT_EQ(size.tets, mesh.tets.size());
  EXPECT_EQ(mesh.unused_points, 0u);
  return mesh;
}

using Point = std::array<double, 3>;

std::vector<Point> positions(const Geometry& mesh) {
  return std::visit(
      [](const auto& points) {
        std::vector<Point> all;
        for (const auto& p : points) all.push_back({p.x, p.y, p.z});
        return all;
      },
      mesh.points);
}

// Whether the triangle lies in one side of the box.
bool on_one_side(const std::vector<Point>& p, const std::array<VertexId, 3>& t) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double side : {0.0, 1.0}) {
      if (p[t[0]][axis] == side && p[t[1]][axis] == side && p[t[2]][axis] == side) return true;
    }
  }
  return false;
}

double area(const Point& a, const Point& b, const Point& c) {
  Point u, v;
  for (std::size_t i = 0; i < 3; ++i) {
    u[i] = b[i] - a[i];
    v[i] = c[i] - a[i];
  }
  return 0.5 * std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                          u[0] * v[1] - u[1] * v[0]);
}

void expect_valid_box(const Geometry& mesh) {
  double volume = 0;
  int not_positive = 0;
  std::map<std::array<VertexId, 3>, int> faces;
  for (const Tet& tet : mesh.tets) {
    const Determinant d =
        std::visit([&](const auto& p) { return determinant(p, tet); }, mesh.points);
    not_positive += d.sign() != 1;
    volume += d.value / 6;
    for (std::size_t skip = 0; skip < 4; ++skip) {
      std::array<VertexId, 3> face;
      for (std::size_t i = 0, n = 0; i < 4; ++i) {
        if (i != skip) face[n++] = tet[i];
      }
      std::sort(face.begin(), face.end());
      ++faces[face];
    }
  }
  EXPECT_EQ(not_positive, 0);
  EXPECT_NEAR(volume, 1, 1e-6);
  const std::vector<Point> p = positions(mesh);
  double surface = 0;
  int astray = 0, crowded = 0;
  for (const auto& [face, count] : faces) {
    crowded += count > 2;
    if (count != 1) continue;
    astray += !on_one_side(p, face);
    surface += area(p[face[0]], p[face[1]], p[face[2]]);
  }
  EXPECT_EQ(crowded, 0);
  EXPECT_EQ(astray, 0);
  EXPECT_NEAR(surface, 6, 1e-5);
}

class Kinds : public ::testing::TestWithParam<LatticeKind> {};

TEST_P(Kinds, SmallestMeshIsOneCube) {
  GenerateOptions options{.kind = GetParam()};
  options.tets = 1;
  const Geometry mesh = generate(options);
  EXPECT_EQ(mesh.tets.size(), tets_per_cube(GetParam()));
  expect_valid_box(mesh);
}

TEST_P(Kinds, FillsTheBoxWithWhateverOptions) {
  for (const std::uint64_t tets : {100u, 3000u}) {
    for (const double jitter : {0.0, 0.5, 0.999}) {
      for (const double grading : {1.0, 3.0, 200.0}) {
        for (const bool shuffle : {false, true}) {
          SCOPED_TRACE(::testing::Message()
                       << tets << " tets, jitter " << jitter << ", grading " << grading);
          GenerateOptions options{.kind = GetParam()};
          options.tets = tets;
          options.jitter = jitter;
          options.grading = grading;
          options.shuffle = shuffle;
          expect_valid_box(generate(options));
        }
      }
    }
  }
}

TEST_P(Kinds, JitterMovesInnerPointsAlone) {
  GenerateOptions options{.kind = GetParam()};
  options.tets = 5000;
  const std::vector<Point> before = positions(generate(options));
  options.jitter = 0.9;
  const std::vector<Point> after = positions(generate(options));
  ASSERT_EQ(before.size(), after.size());
  int moved = 0, inner = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const bool is_inner =
        std::all_of(before[i].begin(), before[i].end(), [](double x) { return x > 0 && x < 1; });
    inner += is_inner;
    moved += before[i] != after[i];
    if (!is_inner) {
      EXPECT_EQ(before[i], after[i]);
    }
  }
  EXPECT_EQ(moved, inner);
  EXPECT_GT(inner, 500);
}

TEST_P(Kinds, SeedsGiveDifferentPoints) {
  GenerateOptions options{.kind = GetParam()};
  options.tets = 1000;
  options.jitter = 0.5;
  const std::vector<Point> a = positions(generate(options));
  options.seed = 1;
  EXPECT_NE(a, positions(generate(options)));
}

TEST_P(Kinds, ShufflingChangesTheOrderAlone) {
  using Cell = std::array<Point, 4>;
  const auto cells = [](const Geometry& mesh) {
    const std::vector<Point> p = positions(mesh);
    std::vector<Cell> all;
    for (const Tet& t : mesh.tets) all.push_back({p[t[0]], p[t[1]], p[t[2]], p[t[3]]});
    return all;
  };
  GenerateOptions options{.kind = GetParam()};
  options.tets = 2000;
  options.jitter = 0.5;
  std::vector<Cell> ordered = cells(generate(options));
  options.shuffle = true;
  std::vector<Cell> shuffled = cells(generate(options));
  EXPECT_NE(ordered, shuffled);
  std::sort(ordered.begin(), ordered.end());
  std::sort(shuffled.begin(), shuffled.end());
  EXPECT_EQ(ordered, shuffled);
}

TEST_P(Kinds, GivesTheSameBytesForAnyNumberOfThreads) {
  const TempDir dir;
  GenerateOptions options{.kind = GetParam()};
  options.tets = 200000;
  options.jitter = 0.5;
  options.grading = 2;
  options.shuffle = true;
  std::vector<std::string> files;
  for (const int threads : {1, 2, 1}) {
    set_thread_count(threads);
    generate_mesh(options, dir.file("a.vtu"));
    files.push_back(bytes_of(dir.file("a.vtu")));
  }
  set_thread_count(0);
  EXPECT_TRUE(files[0] == files[1]);
  EXPECT_TRUE(files[0] == files[2]);
}

TEST_P(Kinds, ComesCloseToTheNumberAskedFor) {
  for (const std::uint64_t tets :
       {std::uint64_t{10'000}, std::uint64_t{1'000'000}, std::uint64_t{69'448'288},
        std::uint64_t{1'000'000'000}, kMaxGeneratedTets}) {
    const Index3 cubes = choose_cubes(GetParam(), tets);
    const double got =
        static_cast<double>(cubes[0] * cubes[1] * cubes[2] * tets_per_cube(GetParam()));
    EXPECT_NEAR(got / static_cast<double>(tets), 1, tets > 100'000 ? 1e-3 : 4e-2);
    const auto [low, high] = std::minmax_element(cubes.begin(), cubes.end());
    EXPECT_LE(static_cast<double>(*high), 1.6 * static_cast<double>(*low));
  }
}

TEST_P(Kinds, BillionsFitFloat32) {
  const Lattice lattice({GetParam(), choose_cubes(GetParam(), 1'000'000'000), 0.9, 1, 0});
  EXPECT_TRUE(lattice.survives_rounding(0x1p-24));
}

std::string kind_name(const ::testing::TestParamInfo<LatticeKind>& test) {
  constexpr std::array kNames{"Five", "Kuhn", "Bcc"};
  return kNames[static_cast<std::size_t>(test.param)];
}
INSTANTIATE_TEST_SUITE_P(All, Kinds,
                         ::testing::Values(LatticeKind::kFive, LatticeKind::kKuhn,
                                           LatticeKind::kBcc),
                         kind_name);

TEST(Generate, GradingIsTheRatioOfCubes) {
  const Lattice lattice({LatticeKind::kFive, {200, 1, 1}, 0, 8, 0});
  double low = 1, high = 0;
  for (std::uint64_t i = 0; i < 200; ++i) {
    const double size = lattice.position(i + 1).x - lattice.position(i).x;
    low = std::min(low, size);
    high = std::max(high, size);
  }
  EXPECT_NEAR(high / low, 8, 0.2);
}

TEST(Generate, WritesFields) {
  const TempDir dir;
  GenerateOptions options;
  options.tets = 20000;
  options.time = 2.5;
  generate_mesh(options, dir.file("a.vtu"));
  const auto source = open_mesh(dir.file("a.vtu"));
  const MeshDescription& d = source->description();
  ASSERT_EQ(d.point_data.arrays.size(), 3u);
  ASSERT_EQ(d.cell_data.arrays.size(), 1u);
  EXPECT_EQ(d.point_data.active.at("Scalars"), "temperature");
  EXPECT_EQ(source->read_array(Association::kField, d.field_data.find("TimeValue")).as<double>()[0],
            2.5);
  const DataArray front = source->read_array(Association::kPoint, d.point_data.find("front"));
  const std::vector<Point> p = positions(source->read_geometry());
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double ahead = std::hypot(p[i][0], p[i][1], p[i][2]) - 0.45;
    EXPECT_EQ(front.as<float>()[i] > 0.5f, ahead > 0) << i;
    if (std::abs(ahead) > 0.3) {
      EXPECT_NEAR(front.as<float>()[i], ahead > 0 ? 1 : 0, 0.01);
    }
  }
  const DataArray region = source->read_array(Association::kCell, 0);
  const auto values = region.as<std::int32_t>();
  EXPECT_EQ(std::set<std::int32_t>(values.begin(), values.end()),
            (std::set<std::int32_t>{1, 2, 3, 4}));
}

TEST(Generate, WritesFloat64WhenAsked) {
  GenerateOptions options;
  options.tets = 1000;
  options.double_precision = true;
  options.jitter = 0.9;
  const Geometry mesh = generate(options);
  EXPECT_EQ(point_type(mesh.points), ValueType::kFloat64);
  expect_valid_box(mesh);
}

TEST(Generate, RefusesOptionsOutOfRange) {
  const TempDir dir;
  const auto refused = [&](const auto& change) {
    GenerateOptions options;
    options.tets = 1000;
    change(options);
    try {
      generate_mesh(options, dir.file("a.vtu"));
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kUsage);
      EXPECT_TRUE(std::filesystem::is_empty(dir.path()));
      return std::string(e.what());
    }
    ADD_FAILURE() << "no error";
    return std::string();
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refused([](auto& o) { o.tets = 0; }), HasSubstr("number of tetrahedra"));
  EXPECT_THAT(refused([](auto& o) { o.tets = kMaxGeneratedTets + 1; }),
              HasSubstr("number of tetrahedra"));
  for (const double jitter : {-0.1, 1.0, kNan}) {
    EXPECT_THAT(refused([&](auto& o) { o.jitter = jitter; }), HasSubstr("jitter"));
  }
  for (const double grading : {0.5, 0.0, 1e5, kNan}) {
    EXPECT_THAT(refused([&](auto& o) { o.grading = grading; }), HasSubstr("grading"));
  }
  EXPECT_THAT(refused([&](auto& o) { o.time = kNan; }), HasSubstr("time"));
  EXPECT_THAT(refused([&](auto& o) {
                o.tets = 1'000'000'000;
                o.jitter = 0.99;
                o.grading = 1000;
              }),
              HasSubstr("Float64"));
}

}  // namespace
}  // namespace tetfusion
