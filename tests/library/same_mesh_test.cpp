// The library against the driver's way from file to file, which the command goes.
#include <cstring>
#include <filesystem>
#include <limits>

#include "driver/simplify.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "mesh/split_cells.h"
#include "support/library_test.h"

namespace tetfusion {
namespace {

using testing::LibraryMesh;
using testing::MeshFile;
using testing::rich_box;
using testing::wavy_box;

MeshFile with_float_points(MeshFile file) {
  file.geometry = testing::to_float(file.geometry);
  return file;
}

void expect_bytes(const Values& values, std::span<const std::byte> expected,
                  const std::string& what) {
  const std::size_t bytes = values.size() * bytes_of(values.type());
  ASSERT_EQ(bytes, expected.size()) << what;
  EXPECT_TRUE(bytes == 0 || std::memcmp(values.data(), expected.data(), bytes) == 0) << what;
}

template <class Id>
void expect_cells(const OwnedMesh& mesh, const Geometry& expected) {
  std::vector<Id> ids, offsets{0};
  std::vector<std::uint8_t> types;
  for (const Tet& t : expected.tets) {
    ids.insert(ids.end(), t.begin(), t.end());
    offsets.push_back(static_cast<Id>(ids.size()));
    types.push_back(kVtkTetra);
  }
  const LowerCells& lower = expected.lower;
  ids.insert(ids.end(), lower.connectivity.begin(), lower.connectivity.end());
  for (std::size_t c = 0; c < lower.size(); ++c) {
    offsets.push_back(static_cast<Id>(4 * expected.tets.size() + lower.offsets[c + 1]));
    types.push_back(lower.types[c]);
  }
  EXPECT_EQ(mesh.tets, expected.tets.size());
  EXPECT_EQ(mesh.connectivity.type(), type_of<Id>());
  expect_bytes(mesh.connectivity, std::as_bytes(std::span(ids)), "connectivity");
  if (mesh.types.empty()) {
    EXPECT_EQ(lower.size(), 0u);
    EXPECT_TRUE(mesh.offsets.empty());
    return;
  }
  expect_bytes(mesh.offsets, std::as_bytes(std::span(offsets)), "offsets");
  expect_bytes(mesh.types, std::as_bytes(std::span(types)), "types");
}

void expect_arrays(const std::vector<OwnedArray>& arrays, const AttributeSet& set,
                   Association association, MeshSource* source) {
  ASSERT_EQ(arrays.size(), set.arrays.size());
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    EXPECT_EQ(arrays[i].name, set.arrays[i].name);
    EXPECT_EQ(arrays[i].components, set.arrays[i].components);
    EXPECT_EQ(static_cast<int>(arrays[i].values.type()), static_cast<int>(set.arrays[i].type));
    expect_bytes(arrays[i].values, source->read_array(association, i).bytes, arrays[i].name);
  }
}

class SameMesh : public testing::LibraryTest {
 protected:
  // What the driver makes of the same mesh, from file to file.
  std::unique_ptr<MeshSource> from_file(const MeshFile& file, BehaviourOptions behaviour) {
    SimplifyRequest request;
    request.input = folder.file("in.vtu");
    request.output = folder.file("out.vtu");
    request.behaviour = std::move(behaviour);
    file.write(request.input);
    simplify(request);
    return open_mesh(request.output);
  }

  template <class Id>
  void expect_same(const MeshFile& file, const BehaviourOptions& behaviour,
                   bool with_types = false) {
    LibraryMesh<Id> input(file, with_types);
    const Result result = simplify(input.mesh(), options);
    ASSERT_TRUE(result.status.ok()) << result.status.message;
    const auto expected = from_file(file, behaviour);
    const MeshDescription& description = expected->description();
    const Geometry geometry = expected->read_geometry();
    ASSERT_LT(geometry.tets.size(), file.geometry.tets.size());
    expect_cells<Id>(result.mesh, geometry);
    std::visit(
        [&](const auto& p) {
          expect_bytes(result.mesh.points, std::as_bytes(std::span(p)), "points");
        },
        geometry.points);
    expect_arrays(result.mesh.point_arrays, description.point_data, Association::kPoint,
                  expected.get());
    expect_arrays(result.mesh.cell_arrays, description.cell_data, Association::kCell,
                  expected.get());
    EXPECT_EQ(result.report.output.tets, geometry.tets.size());
    EXPECT_EQ(result.report.output.points, point_count(geometry.points));
  }
};

TEST_F(SameMesh, MakesTheMeshThatTheDriverMakesFromFiles) {
  options.reduction = 0.6;
  BehaviourOptions same;
  same.reduction = 0.6;
  expect_same<std::int64_t>(wavy_box(8), same);
  expect_same<std::int32_t>(with_float_points(wavy_box(8)), same);
  expect_same<std::int32_t>(wavy_box(8), same, true);
}

TEST_F(SameMesh, ChunksAndThreadsAndArraysAndCellsOfLowerDimension) {
  options.reduction = 0.5;
  options.chunk_tets = 400;
  BehaviourOptions same;
  same.reduction = 0.5;
  same.chunk_tets = 400;
  for (const int threads : {1, 3}) {
    options.threads = threads;
    options.original_ids = same.original_ids = threads == 3;
    expect_same<std::int64_t>(rich_box(8), same);
    expect_same<std::int32_t>(with_float_points(rich_box(8)), same);
  }
}

// Where a cell is split, files are read whole, without points that no cell uses: these would move
// the borders between chunks.
TEST_F(SameMesh, PointsThatNoCellUsesBesideCellsThatAreSplit) {
  options.reduction = 0.5;
  options.chunk_tets = 400;
  options.tetrahedralize = options.original_ids = true;
  BehaviourOptions same;
  same.reduction = 0.5;
  same.chunk_tets = 400;
  same.tetrahedralize = same.original_ids = true;
  MeshFile file = wavy_box(8);
  auto& points = std::get<Vector<Vec3<double>>>(file.geometry.points);
  file.geometry.lower = {{kVtkQuad}, {0, 4}, {0, 1, 10, 9}};
  for (int i = 0; i < 300; ++i) points.insert(points.begin() + 7, {40, 0.1 * i, 50});
  for (VertexId& v : file.geometry.lower.connectivity) v += v < 7 ? 0 : 300;
  for (Tet& tet : file.geometry.tets) {
    for (VertexId& v : tet) v += v < 7 ? 0 : 300;
  }
  file.point_arrays = {testing::point_array<float>(
      file, "wave", [](const Vec3<double>& p) { return std::sin(p.x) * p.y + p.z; })};
  expect_same<std::int64_t>(file, same, true);
  options.threads = 3;
  expect_same<std::int32_t>(file, same, true);
}

TEST_F(SameMesh, BluntFin) {
  const std::string path = std::string(TETFUSION_TEST_DATA) + "/bluntfin.vtu";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  const auto source = open_mesh(path);
  const MeshDescription& description = source->description();
  MeshFile file;
  file.geometry = source->read_geometry();
  for (std::size_t i = 0; i < description.point_data.arrays.size(); ++i) {
    file.point_arrays.push_back(source->read_array(Association::kPoint, i));
  }
  for (std::size_t i = 0; i < description.cell_data.arrays.size(); ++i) {
    file.cell_arrays.push_back(source->read_array(Association::kCell, i));
  }
  file.point_markers = description.point_data.active;
  options.reduction = 0.5;
  BehaviourOptions same;
  same.reduction = 0.5;
  expect_same<std::int32_t>(file, same);
}

TEST_F(SameMesh, EveryOptionReachesTheDriver) {
  const MeshFile file = rich_box(7);
  options.max_error = 0.02;
  options.arrays = {{"f", false, {}}, {"stress", true, 0.03}};
  options.regions.emplace();
  options.boundary = BoundaryMode::kPlanar;
  options.feature_angle = 100;
  options.min_quality = 0.1;
  options.aspect_ratio = 20;
  options.max_volume = 1.5;
  options.weight = "ids";
  options.original_ids = true;
  BehaviourOptions same;
  same.max_error = 0.02;
  same.arrays = {"f", "cell:stress:0.03"};
  same.regions.emplace();
  same.boundary = Boundary::kPlanar;
  same.feature_angle = 100;
  same.min_quality = 0.1;
  same.aspect_ratio = 20;
  same.max_volume = 1.5;
  same.weight = "ids";
  same.original_ids = true;
  expect_same<std::int64_t>(file, same);

  options = {};
  same = {};
  options.method = Operation::kTetFuse;
  options.boundary_tets_stay = true;
  options.scalar_tolerance = {0.1, 0.2};
  options.stretch_factor = {std::numeric_limits<double>::infinity()};
  options.tets = 1200;
  same.method = Method::kTetFuse;
  same.boundary_rule = BoundaryRule::kTets;
  same.scalar_tolerance = {0.1, 0.2};
  same.stretch_factor = {std::numeric_limits<double>::infinity()};
  same.tets = 1200;
  expect_same<std::int64_t>(file, same);

  options = {};
  same = {};
  options.tets = 700;
  options.max_rms = 0.05;
  options.conserve = true;
  options.regions = std::vector<std::string>{"material"};
  same.tets = 700;
  same.max_rms = 0.05;
  same.conserve = true;
  same.regions = std::vector<std::string>{"material"};
  expect_same<std::int64_t>(file, same);

  options = {};
  same = {};
  options.reduction = 0.8;
  options.boundary = BoundaryMode::kWithin;
  options.boundary_distance = 0.02;
  same.reduction = 0.8;
  same.boundary = Boundary::kWithin;
  same.boundary_distance = 0.02;
  expect_same<std::int64_t>(wavy_box(8), same);
}

}  // namespace
}  // namespace tetfusion
