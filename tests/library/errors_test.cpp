// What the library refuses, and how it says so.
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

#include "support/library_test.h"

namespace tetfusion {
namespace {

using ::testing::HasSubstr;
using testing::LibraryMesh;
using ::testing::MatchesRegex;
using testing::MeshFile;
using testing::wavy_box;

class LibraryErrors : public testing::LibraryTest {};

TEST_F(LibraryErrors, HexahedraAreSplitWhereThatIsAskedFor) {
  const std::vector<float> points = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0,
                                     0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
  const std::vector<std::int64_t> ids = {0, 1, 2, 3, 4, 5, 6, 7};
  const std::vector<std::int64_t> offsets = {0, 8};
  const std::vector<std::uint8_t> types = {12};
  const std::vector<std::int16_t> number = {7};
  Mesh mesh;
  mesh.points = points;
  mesh.connectivity = ids;
  mesh.offsets = offsets;
  mesh.types = types;
  mesh.cell_arrays = {{"number", 1, number}};
  options.reduction = 0.5;
  const Status refused = failure(mesh);
  EXPECT_EQ(refused.code, Code::kBadInput);
  EXPECT_EQ(refused.message,
            "the mesh: cell 0 is a hexahedron (VTK cell type 12): use tetrahedralize to split such "
            "cells");
  options.tetrahedralize = true;
  const Result result = simplify(mesh, options);
  ASSERT_TRUE(result.status.ok()) << result.status.message;
  EXPECT_EQ(result.mesh.tets, 6u);
  EXPECT_EQ(result.mesh.points.size(), 24u);
  EXPECT_NEAR(result.report.output.volume, 1, 1e-6);
  for (const std::int16_t n : result.mesh.cell_arrays[0].values.as<std::int16_t>()) EXPECT_EQ(n, 7);
}

TEST_F(LibraryErrors, BadMeshesAreNamed) {
  const std::vector<double> points = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::vector<std::int32_t> ids = {0, 1, 2, 3};
  const std::vector<float> values = {1, 2, 3, 4};
  options.reduction = 0.5;
  Mesh mesh;
  mesh.points = points;
  mesh.connectivity = ids;
  const auto message = [&] {
    const Status status = failure(mesh);
    EXPECT_EQ(status.code, Code::kBadInput);
    return status.message;
  };
  EXPECT_TRUE(simplify(mesh, options).status.ok());

  EXPECT_EQ(failure({}).message, "the mesh: the connectivity must be Int32 or Int64");
  mesh.connectivity = {};
  mesh.connectivity = std::span(ids).first(0);
  EXPECT_EQ(message(), "the mesh: the mesh has no tetrahedra");
  mesh.connectivity = std::span(ids).first(3);
  EXPECT_THAT(message(), HasSubstr("no multiple of four"));
  mesh.connectivity = values;
  EXPECT_THAT(message(), HasSubstr("the connectivity must be Int32 or Int64"));
  mesh.connectivity = ids;
  ids[2] = -1;
  EXPECT_THAT(message(), HasSubstr("cell 0 uses point -1, but there are 4 points"));
  ids[2] = 4;
  EXPECT_THAT(message(), HasSubstr("cell 0 uses point 4, but there are 4 points"));
  ids[2] = 2;
  mesh.points = ids;
  EXPECT_THAT(message(), HasSubstr("the coordinates must be Float32 or Float64"));
  mesh.points = std::span(points).first(10);
  EXPECT_THAT(message(), HasSubstr("no multiple of three"));
  std::vector<double> infinite = points;
  infinite[4] = std::numeric_limits<double>::infinity();
  mesh.points = infinite;
  EXPECT_THAT(message(), HasSubstr("point 1 has a coordinate that is not finite"));
  mesh.points = points;

  mesh.point_arrays = {{"a", 3, values}};
  EXPECT_THAT(message(), HasSubstr("point array \"a\" has 4 values, expected 12"));
  mesh.point_arrays = {{"a", 1, values}, {"a", 1, values}};
  EXPECT_THAT(message(), HasSubstr("two point arrays are called \"a\""));
  mesh.point_arrays = {{"", 1, values}};
  EXPECT_THAT(message(), HasSubstr("a point array has no name"));
  mesh.point_arrays = {{"a", 0, values}};
  EXPECT_THAT(message(), HasSubstr("has no components"));
  mesh.point_arrays = {{"a", 1, values}};
  mesh.active_scalars = "b";
  EXPECT_THAT(message(), HasSubstr("active_scalars: there is no point array b"));
  mesh.active_scalars = "";
  mesh.point_arrays.clear();

  std::vector<std::uint8_t> types = {10};
  std::vector<std::int32_t> offsets = {0, 4};
  mesh.types = types;
  EXPECT_THAT(message(), HasSubstr("the offsets must have the type of the connectivity"));
  mesh.offsets = std::span(offsets).first(1);
  EXPECT_THAT(message(), HasSubstr("1 offset for 1 cell"));
  mesh.offsets = offsets;
  EXPECT_TRUE(simplify(mesh, options).status.ok());
  types = {7};
  for (const bool split : {false, true}) {
    options.tetrahedralize = split;
    EXPECT_THAT(message(), HasSubstr("is a polygon (VTK cell type 7), which cannot be read"));
  }
  types = {10};
  offsets = {0, 3};
  EXPECT_THAT(message(), HasSubstr("cell 0 has 3 vertices, expected 4"));
  offsets = {0, 5};
  EXPECT_THAT(message(), HasSubstr("cell 0 goes from 0 to 5, but there are 4 vertex ids"));
  offsets = {1, 4};
  EXPECT_THAT(message(), HasSubstr("the first offset is not 0"));
  offsets = {0, 4};
  const std::vector<std::uint8_t> ghosts = {0, 0};
  mesh.ghosts = ghosts;
  EXPECT_THAT(message(), HasSubstr("2 ghost flags for 1 cell"));
}

TEST_F(LibraryErrors, ValuesAtNoAddressAreRefused) {
  const MeshFile file = wavy_box(3);
  const Values nowhere(Type::kFloat64, nullptr, 12);
  const auto message = [&](auto change) {
    LibraryMesh<std::int64_t> input(file, true);
    change(&input.mesh());
    const Status status = failure(input.mesh());
    EXPECT_EQ(status.code, Code::kBadInput);
    return status.message;
  };
  const std::uint8_t* const no_bytes = nullptr;
  EXPECT_EQ(message([&](Mesh* m) { m->points = nowhere; }),
            "the mesh: points has 12 values, but its address is null");
  EXPECT_THAT(message([&](Mesh* m) {
                m->connectivity = {Type::kInt64, nullptr, 4};
              }),
              HasSubstr("connectivity has 4 values, but"));
  EXPECT_THAT(message([&](Mesh* m) {
                m->offsets = {Type::kInt64, nullptr, 2};
              }),
              HasSubstr("offsets has 2 values, but"));
  EXPECT_THAT(message([&](Mesh* m) {
                m->types = {no_bytes, m->types.size()};
              }),
              HasSubstr("types has"));
  EXPECT_THAT(message([&](Mesh* m) {
                m->ghosts = {no_bytes, 1};
              }),
              HasSubstr("ghosts has 1 value, but"));
  EXPECT_THAT(message([&](Mesh* m) { m->point_arrays[0].values = nowhere; }),
              HasSubstr("point array \"wave\" has 12 values, but"));
}

// They refer to somebody else's numbers, which must outlast them.
static_assert(std::is_constructible_v<Values, std::vector<double>&>);
static_assert(!std::is_constructible_v<Values, std::vector<double>>);
static_assert(std::is_constructible_v<Values, std::span<const double>>);
static_assert(std::is_convertible_v<const OwnedValues&, Values>);
static_assert(!std::is_convertible_v<OwnedValues, Values>);

TEST_F(LibraryErrors, BadOptionsAreNamedInItsOwnWords) {
  const MeshFile file = wavy_box(3);
  LibraryMesh<std::int64_t> input(file, false);
  const auto message = [&] {
    const Status status = failure(input.mesh());
    EXPECT_EQ(status.code, Code::kUsage);
    EXPECT_EQ(status.message.find("--"), std::string::npos) << status.message;
    options = {};
    return status.message;
  };
  options.reduction = 1;
  EXPECT_EQ(message(), "reduction must be at least 0% and less than 100%");
  options.method = Operation::kTetFuse;
  options.scalar_tolerance = {0.1, 5};
  EXPECT_THAT(message(), HasSubstr("scalar_tolerance: 5 is more than 1"));
  options.reduction = 0.5;
  options.tets = 5;
  EXPECT_EQ(message(), "reduction and tets are two goals: give one of them");
  options.max_error = -1;
  EXPECT_THAT(message(), HasSubstr("max_error must be greater than 0"));
  options.max_error = 5;
  EXPECT_EQ(message(), "max_error must be greater than 0% and at most 100% of the range");
  for (const double wrong : {0.0, -0.5, 1.5, std::numeric_limits<double>::quiet_NaN()}) {
    options.arrays = {{"wave", false, wrong}};
    EXPECT_THAT(message(),
                MatchesRegex("arrays: the tolerance of \"wave\" is (0|-0.5|1.5|nan): it "
                             "must be greater than 0 and at most 1, a share of its range"));
  }
  options.boundary = BoundaryMode::kWithin;
  EXPECT_THAT(message(), HasSubstr("boundary must be a share of the diagonal"));
  options.method = Operation::kTetFuse;
  options.min_quality = 0.1;
  EXPECT_THAT(message(), HasSubstr("min_quality belongs to method fuse"));
  options.boundary_tets_stay = true;
  EXPECT_THAT(message(), HasSubstr("boundary_tets_stay belongs to method tetfuse"));
  options.arrays = {{"nothing", false, {}}};
  EXPECT_THAT(message(), HasSubstr("no array \"nothing\" to steer by; point arrays: wave"));
  options.arrays = {{"wave:1%", false, {}}};
  EXPECT_THAT(message(), HasSubstr("no array \"wave:1%\" to steer by"));
  options.arrays = {{"cell:heat", false, {}}};
  EXPECT_THAT(message(), HasSubstr("no array \"cell:heat\" to steer by"));
  input.mesh().point_arrays.push_back(input.mesh().point_arrays.front());
  input.mesh().point_arrays.front().name = "wave";
  input.mesh().point_arrays.back().name = "wave:0.5";
  options.arrays = {{"wave", false, 0.5}};
  EXPECT_THAT(message(), HasSubstr("cannot be told from the array \"wave:0.5\""));
  input.mesh().point_arrays.pop_back();
  options.arrays = {{"wave", false, -0.5}};
  EXPECT_THAT(message(), HasSubstr("must be greater than 0"));
  input.mesh().point_arrays.back().name = "OriginalPointIds";
  options.original_ids = true;
  EXPECT_THAT(message(), HasSubstr("leave original_ids out"));
  options.regions = std::vector<std::string>{"nothing"};
  EXPECT_THAT(message(), HasSubstr("there is no cell array of numbers"));
  options.chunk_tets = 0;
  EXPECT_EQ(message(), "chunk_tets must be at least 1");
  options.threads = -1;
  EXPECT_EQ(message(), "threads must be at least 0");
}

TEST_F(LibraryErrors, GoalOutOfReachIsAStatusOnlyIfStrict) {
  const MeshFile file = wavy_box(4);
  options.reduction = 0.999;
  const Result loose = run(file);
  EXPECT_TRUE(loose.status.ok());
  EXPECT_FALSE(loose.report.goal_reached);
  options.strict = true;
  const Result strict = run(file);
  EXPECT_EQ(strict.status.code, Code::kGoalNotReached);
  EXPECT_THAT(strict.status.message, HasSubstr("The goal was not reached"));
  EXPECT_EQ(strict.mesh.tets, loose.mesh.tets);
}

}  // namespace
}  // namespace tetfusion
