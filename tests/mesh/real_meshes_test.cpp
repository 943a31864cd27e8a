// Facts that are known of real meshes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>

#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "mesh/inspection/inspect.h"
#include "support/brute_check.h"

namespace tetfusion {
namespace {

struct Fact {
  const char* name;
  std::uint64_t points, tets, degenerate, inverted, foldover, coincident, boundary_triangles;
  double boundary_percent;  // of the points; to the digits in which it is known
  std::int64_t euler;
};

// gtest's default prints the bytes of the pointer, and so makes a name that changes.
void PrintTo(const Fact& fact, std::ostream* out) { *out << fact.name; }

class RealMesh : public ::testing::TestWithParam<Fact> {};

TEST_P(RealMesh, IsAsKnown) {
  const Fact& fact = GetParam();
  const std::string path = fmt::format("{}/{}.vtu", TETFUSION_TEST_DATA, fact.name);
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  Geometry mesh = open_mesh(path)->read_geometry();
  const Inspection i = inspect(mesh);
  EXPECT_EQ(i.vertex_flags.size(), fact.points);
  EXPECT_EQ(mesh.tets.size(), fact.tets);
  EXPECT_EQ(i.degenerate, fact.degenerate);
  EXPECT_EQ(i.inverted, fact.inverted);
  EXPECT_EQ(i.foldover_faces, fact.foldover);
  EXPECT_EQ(i.coincident_points, fact.coincident);
  EXPECT_EQ(i.boundary_faces, fact.boundary_triangles);
  EXPECT_EQ(i.overfull_faces, 0u);
  EXPECT_EQ(i.duplicate_tets, 0u);
  EXPECT_EQ(i.components, 1u);
  EXPECT_EQ(i.surface_euler(), fact.euler);
  EXPECT_NEAR(100.0 * static_cast<double>(i.boundary_vertices) / static_cast<double>(fact.points),
              fact.boundary_percent, 0.06);

  const testing::BruteReport brute = testing::brute_check(mesh);
  EXPECT_EQ(brute.foldover, fact.foldover);
  EXPECT_EQ(brute.negative, 0u);
  EXPECT_EQ(brute.boundary.size(), i.boundary_faces);
  EXPECT_EQ(brute.nonmanifold_edges, i.nonmanifold_edges);
  EXPECT_NEAR(i.volume, static_cast<double>(brute.volume), 1e-13 * i.volume);
}

INSTANTIATE_TEST_SUITE_P(
    All, RealMesh,
    ::testing::Values(Fact{"spx", 2896, 12936, 0, 0, 0, 0, 2760, 47.6, 0},
                      Fact{"bluntfin", 40960, 187395, 77, 0, 0, 39, 13516, 16.5, 2},
                      Fact{"quake_sf10", 7294, 35025, 0, 0, 0, 0, 5208, 35.7, 2},
                      Fact{"disk_out_ref", 8499, 44832, 0, 0, 0, 0, 3976, 23.4, 2},
                      Fact{"can", 6724, 28800, 0, 77, 161, 0, 7360, 54.8, 2},
                      Fact{"polyfem_cubes", 7714, 32981, 0, 0, 0, 0, 7610, 49.4, 2},
                      Fact{"pylith_crustal", 3713, 17684, 0, 0, 0, 0, 2902, 39.1, 2}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace tetfusion
