// The interface for C, and the options as a text.
#include "tetfusion_c.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "support/library_test.h"

namespace tetfusion {
namespace {

using ::testing::HasSubstr;
using testing::LibraryMesh;
using testing::MeshFile;
using testing::wavy_box;

struct Free {
  void operator()(tetfusion_result* result) const { tetfusion_free(result); }
};
using CResult = std::unique_ptr<tetfusion_result, Free>;

tetfusion_values c_values(const Values& values) {
  return {static_cast<std::int32_t>(values.type()), values.data(), values.size()};
}

class CInterface : public ::testing::Test {
 protected:
  CInterface() {
    const Mesh& mesh = input.mesh();
    for (const Array& array : mesh.point_arrays) {
      arrays.push_back({array.name.c_str(), array.components, c_values(array.values)});
    }
    c_mesh.points = c_values(mesh.points);
    c_mesh.connectivity = c_values(mesh.connectivity);
    c_mesh.point_arrays = arrays.data();
    c_mesh.point_array_count = arrays.size();
  }
  CResult run(const char* options, const tetfusion_observer* observer = nullptr) {
    return CResult(tetfusion_simplify(&c_mesh, options, observer));
  }
  void expect_refused(const char* options, const char* said) {
    const CResult result = run(options);
    EXPECT_EQ(tetfusion_code(result.get()), 2) << options;
    EXPECT_THAT(tetfusion_message(result.get()), HasSubstr(said));
    EXPECT_EQ(tetfusion_mesh_of(result.get())->points.size, 0u);
    EXPECT_STREQ(tetfusion_report(result.get()), "");
  }

  MeshFile file = wavy_box(8);
  LibraryMesh<std::int64_t> input{file, false};
  std::vector<tetfusion_array> arrays;
  tetfusion_mesh c_mesh{};
};

template <class T>
bool holds(const tetfusion_values& values, std::span<const T> expected) {
  const auto* data = static_cast<const T*>(values.data);
  return values.type == static_cast<std::int32_t>(type_of<T>()) && values.size == expected.size() &&
         std::equal(expected.begin(), expected.end(), data);
}

TEST_F(CInterface, MakesTheMeshOfTheLibrary) {
  Options options;
  options.reduction = 0.6;
  options.boundary = BoundaryMode::kWithin;
  options.boundary_distance = 0.01;
  options.arrays = {{"wave", false, 0.05}};
  options.original_ids = true;
  const Result expected = simplify(input.mesh(), options);
  ASSERT_TRUE(expected.status.ok());
  const CResult result = run(R"({"reduction": 0.6, "boundary": "within", "boundary_distance": 0.01,
      "arrays": [{"name": "wave", "of_cells": false, "tolerance": 0.05}], "original_ids": true,
      "tets": null, "max_volume": "inf", "stretch_factor": ["inf"], "roi": [], "threads": 1})");
  EXPECT_EQ(tetfusion_code(result.get()), 0);
  EXPECT_STREQ(tetfusion_message(result.get()), "");
  EXPECT_THAT(tetfusion_report(result.get()), HasSubstr("\"steering\""));
  const tetfusion_mesh& mesh = *tetfusion_mesh_of(result.get());
  EXPECT_TRUE(holds(mesh.points, expected.mesh.points.as<double>()));
  EXPECT_TRUE(holds(mesh.connectivity, expected.mesh.connectivity.as<std::int64_t>()));
  EXPECT_EQ(mesh.offsets.size + mesh.types.size, 0u);
  ASSERT_EQ(mesh.point_array_count, expected.mesh.point_arrays.size());
  EXPECT_STREQ(mesh.point_arrays[mesh.point_array_count - 1].name, "OriginalPointIds");
  EXPECT_TRUE(holds(mesh.point_arrays[0].values, expected.mesh.point_arrays[0].values.as<float>()));
  EXPECT_EQ(mesh.cell_array_count, 0u);
}

TEST_F(CInterface, TakesNoOptionsForDefaults) {
  const CResult result = run(nullptr);
  EXPECT_EQ(tetfusion_code(result.get()), 0) << tetfusion_message(result.get());
  EXPECT_LT(tetfusion_mesh_of(result.get())->connectivity.size, c_mesh.connectivity.size);
  tetfusion_free(nullptr);
  EXPECT_STREQ(tetfusion_version(), library_version());
}

TEST_F(CInterface, SaysWhatIsWrongWithOptions) {
  expect_refused("", "no JSON object");
  expect_refused("[1]", "no JSON object");
  expect_refused("{\"weight\": \"\xff\"}", "no JSON object");
  expect_refused(R"({"reduction": "much"})", "reduction must be a number, not \"much\"");
  expect_refused(R"({"Reduction": 0.5})", "no option \"Reduction\"");
  expect_refused(R"({"tets": 0.5})", "tets must be a whole number, at least 0, not 0.5");
  expect_refused(R"({"tets": -1})", "tets must be a whole number");
  expect_refused(R"({"threads": 99999999999})", "threads must be a number of threads");
  expect_refused(R"({"strict": 1})", "strict must be true or false");
  expect_refused(R"({"method": "both"})", "method must be \"fuse\" or \"tetfuse\"");
  expect_refused(R"({"boundary": 0.1})", "boundary must be \"exact\", \"planar\" or \"within\"");
  expect_refused(R"({"arrays": [{"of_cells": true}]})", "arrays must be a name, or an object");
  expect_refused(R"({"arrays": [{"name": "wave", "bound": 1}]})", "arrays must be a name");
  expect_refused(R"({"regions": [3]})", "regions must be a text, not such a list");
  expect_refused(R"({"reduction": 2})", "reduction");
  const std::string deep(200'000, '[');
  expect_refused(("{\"weight\": " + deep + std::string(deep.size(), ']') + "}").c_str(),
                 "weight must be a text, not such a list");
  expect_refused(R"({"arrays": ["a--max-error"]})", "\"a--max-error\"");
}

TEST_F(CInterface, SaysWhatIsWrongWithTheMesh) {
  const tetfusion_mesh whole = c_mesh;
  c_mesh.points.type = 10;
  expect_refused("{}", "points: there is no type 10");
  c_mesh = whole;
  c_mesh.types = {TETFUSION_INT32, c_mesh.connectivity.data, 4};
  expect_refused("{}", "types must be of UInt8");
  c_mesh = whole;
  arrays[0].values.data = nullptr;
  const CResult result = run("{}");
  EXPECT_EQ(tetfusion_code(result.get()), 3);
  EXPECT_THAT(tetfusion_message(result.get()), HasSubstr("its address is null"));
  c_mesh.point_arrays = nullptr;
  const CResult without = run("{}");
  EXPECT_EQ(tetfusion_code(without.get()), 3);
  EXPECT_THAT(tetfusion_message(without.get()), HasSubstr("1 point arrays, but their address"));
  c_mesh = whole;
  c_mesh.connectivity.size += std::uint64_t{1} << 61;
  const CResult wrapped = run("{}");
  EXPECT_EQ(tetfusion_code(wrapped.get()), 3);
  EXPECT_THAT(tetfusion_message(wrapped.get()), HasSubstr("connectivity cannot have"));
  const CResult none(tetfusion_simplify(nullptr, nullptr, nullptr));
  EXPECT_EQ(tetfusion_code(none.get()), 2);
}

TEST_F(CInterface, TellsAndAsks) {
  struct Seen {
    double share = 0;
    int asked = 0, notices = 0;
    bool ends = false;
  } seen;
  tetfusion_observer observer{&seen,
                              [](void* data, double share, const char* phase) {
                                EXPECT_GE(share, static_cast<Seen*>(data)->share);
                                EXPECT_NE(*phase, 0);
                                static_cast<Seen*>(data)->share = share;
                              },
                              [](void* data) {
                                ++static_cast<Seen*>(data)->asked;
                                return std::int32_t{static_cast<Seen*>(data)->ends};
                              },
                              [](void* data, const char* sentence) {
                                EXPECT_NE(*sentence, 0);
                                ++static_cast<Seen*>(data)->notices;
                              }};
  EXPECT_EQ(tetfusion_code(run(R"({"reduction": 0.5})", &observer).get()), 0);
  EXPECT_EQ(seen.share, 1);
  seen = {};
  seen.ends = true;
  file = wavy_box(30);
  LibraryMesh<std::int64_t> large(file, false);
  c_mesh.points = c_values(large.mesh().points);
  c_mesh.connectivity = c_values(large.mesh().connectivity);
  arrays[0].values = c_values(large.mesh().point_arrays[0].values);
  EXPECT_EQ(tetfusion_code(run(R"({"reduction": 0.5})", &observer).get()), 130);
  EXPECT_GT(seen.asked, 0);
  observer = {};
  EXPECT_EQ(tetfusion_code(run(R"({"reduction": 0.5})", &observer).get()), 0);
}

TEST_F(CInterface, AGoalThatIsNotReachedHasAMesh) {
  const CResult result = run(R"({"reduction": 0.999, "strict": true})");
  EXPECT_EQ(tetfusion_code(result.get()), 6);
  EXPECT_THAT(tetfusion_message(result.get()), HasSubstr("goal was not reached"));
  EXPECT_GT(tetfusion_mesh_of(result.get())->connectivity.size, 0u);
}

}  // namespace
}  // namespace tetfusion
