#include "driver/simplify.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <mutex>
#include <set>

#include "base/error.h"
#include "base/resources.h"
#include "driver/arrays/regions.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "mesh/inspection/inspect.h"
#include "mesh/predicates.h"
#include "support/damaged_meshes.h"
#include "support/file_request.h"
#include "support/mesh_file.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using testing::bytes_of;
using ::testing::ElementsAre;
using testing::five_split_cube;
using ::testing::HasSubstr;
using testing::make_array;
using testing::MeshFile;
using testing::point_array;
using testing::read_cell_array;
using testing::read_point_array;
using testing::TempDir;

using P = Vec3<double>;

MeshFile box(std::uint32_t n, double jitter = 0.15) {
  MeshFile file;
  file.geometry = five_split_cube(n, jitter, 4);
  return file;
}

class Simplify : public ::testing::Test {
 protected:
  SimplifyReport run(const MeshFile& file) {
    file.write(request.input);
    RunContext context;
    context.notice = [this](std::string_view s) { notices.emplace_back(s); };
    return simplify(request, context);
  }
  TempDir folder = TempDir::in_memory();
  SimplifyRequest request = [this] {
    SimplifyRequest r = testing::request_in(folder);
    r.behaviour.method = Method::kTetFuse;
    r.behaviour.scalar_tolerance = {std::numeric_limits<double>::infinity()};
    return r;
  }();
  std::vector<std::string> notices;
};

TEST_F(Simplify, EveryArrayComesOutUnderItsNameAndType) {
  MeshFile file = box(8);
  const std::size_t points = point_count(file.geometry.points);
  const auto linear = [](const P& p) { return 3 * p.x - p.y + 2 * p.z; };
  file.point_arrays.push_back(point_array<double>(file, "linear", linear));
  file.point_arrays.push_back(
      make_array<float>("vector", points, 3, [&](std::size_t i, std::size_t k) {
        const P p = testing::point(file.geometry, static_cast<VertexId>(i));
        return k == 0 ? p.x : (k == 1 ? p.y : p.z);
      }));
  file.point_arrays.push_back(
      make_array<std::int64_t>("GlobalNodeIds", points, 1, [](auto i, auto) { return 1000 + i; }));
  file.point_arrays.push_back(
      make_array<std::uint8_t>("byte", points, 2, [](auto i, auto k) { return (i + k) % 256; }));
  file.point_arrays[1].info.component_names = {"X", "Y", "Z"};
  file.point_arrays[1].info.units = "m/s";
  file.point_markers = {
      {"Scalars", "linear"}, {"Vectors", "vector"}, {"GlobalIds", "GlobalNodeIds"}};
  const auto first =
      make_array<std::int32_t>("first", file.cells(), 1, [](auto i, auto) { return i; });
  file.cell_arrays.push_back(first);
  file.cell_arrays.push_back(
      make_array<float>("stress", file.cells(), 6, [](auto i, auto k) { return i * 6 + k; }));
  file.field_arrays.push_back(
      make_array<double>("TimeValue", 1, 1, [](auto, auto) { return 2.5; }));

  const SimplifyReport report = run(file);
  EXPECT_LT(report.output.tets, report.input.tets);
  EXPECT_THAT(report.steering, ElementsAre("linear"));

  const auto source = open_mesh(request.output);
  const MeshDescription& out = source->description();
  ASSERT_EQ(out.point_data.arrays.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(out.point_data.arrays[i].name, file.point_arrays[i].info.name);
    EXPECT_EQ(out.point_data.arrays[i].type, file.point_arrays[i].info.type);
    EXPECT_EQ(out.point_data.arrays[i].components, file.point_arrays[i].info.components);
    EXPECT_EQ(out.point_data.arrays[i].component_names, file.point_arrays[i].info.component_names);
    EXPECT_EQ(out.point_data.arrays[i].units, file.point_arrays[i].info.units);
  }
  EXPECT_EQ(out.point_data.active, file.point_markers);
  ASSERT_EQ(out.field_data.arrays.size(), 1u);
  EXPECT_EQ(source->read_array(Association::kField, 0).as<double>()[0], 2.5);

  const Geometry g = source->read_geometry();
  const DataArray values = read_point_array(source.get(), "linear");
  const DataArray vectors = read_point_array(source.get(), "vector");
  const DataArray ids = read_point_array(source.get(), "GlobalNodeIds");
  std::set<std::int64_t> seen;
  for (VertexId v = 0; v < point_count(g.points); ++v) {
    const P p = testing::point(g, v);
    EXPECT_NEAR(values.as<double>()[v], linear(p), 1e-12);
    EXPECT_NEAR(vectors.as<float>()[3 * v], p.x, 1e-6);
    EXPECT_NEAR(vectors.as<float>()[3 * v + 2], p.z, 1e-6);
    EXPECT_TRUE(seen.insert(ids.as<std::int64_t>()[v]).second) << "an id twice";
  }
  // A surviving tetrahedron keeps its values.
  const DataArray survivors = read_cell_array(source.get(), "first");
  const DataArray stress = read_cell_array(source.get(), "stress");
  for (std::size_t t = 0; t < g.tets.size(); ++t) {
    EXPECT_EQ(stress.as<float>()[6 * t + 5],
              static_cast<float>(survivors.as<std::int32_t>()[t] * 6 + 5));
  }
}

TEST_F(Simplify, FloatCoordinatesKeepVolumeBoundaryAndLinearFields) {
  MeshFile file = box(10);
  file.geometry = testing::to_float(file.geometry);
  file.point_arrays.push_back(
      point_array<float>(file, "linear", [](const P& p) { return p.x + 2 * p.y - p.z; }));
  const SimplifyReport report = run(file);
  EXPECT_LT(report.output.tets, report.input.tets * 8 / 10);
  EXPECT_NEAR(report.output.volume / report.input.volume, 1, 1e-12);
  EXPECT_EQ(report.output.boundary_triangles, report.input.boundary_triangles);
  const auto source = open_mesh(request.output);
  Geometry g = source->read_geometry();
  EXPECT_EQ(point_type(g.points), ValueType::kFloat32);
  const DataArray values = read_point_array(source.get(), "linear");
  for (VertexId v = 0; v < point_count(g.points); ++v) {
    const P p = testing::point(g, v);
    EXPECT_NEAR(values.as<float>()[v], p.x + 2 * p.y - p.z, 2e-5);
  }
  const Inspection inspection = inspect(g);
  EXPECT_EQ(inspection.degenerate + inspection.inverted + inspection.foldover_faces, 0u);
}

TEST_F(Simplify, TheScalarToleranceHoldsFieldsBack) {
  MeshFile file = box(8);
  file.point_arrays.push_back(point_array<double>(file, "x", [](const P& p) { return p.x; }));
  const SimplifyReport off = run(file);
  request.behaviour.scalar_tolerance = {0.05};
  const SimplifyReport tight = run(file);
  EXPECT_GT(tight.output.tets, off.output.tets);
  // An array's own tolerance goes before the common one.
  request.behaviour.arrays = {"x:99%"};
  EXPECT_EQ(run(file).output.tets, off.output.tets);
}

TEST_F(Simplify, CellArraysMaySteer) {
  MeshFile file = box(8);
  file.cell_arrays.push_back(
      make_array<float>("load", file.cells(), 1, [](auto i, auto) { return i % 97; }));
  request.behaviour.arrays = {"cell:load"};
  request.behaviour.scalar_tolerance = {0.01};
  const SimplifyReport tight = run(file);
  EXPECT_THAT(tight.steering, ElementsAre("cell:load"));
  request.behaviour.scalar_tolerance = {10};
  EXPECT_LT(run(file).output.tets, tight.output.tets);
}

TEST_F(Simplify, AConstantArrayDoesNotSteer) {
  MeshFile file = box(5);
  file.point_arrays.push_back(point_array<double>(file, "same", [](const P&) { return 7.0; }));
  request.behaviour.scalar_tolerance = {0.01};
  const SimplifyReport report = run(file);
  EXPECT_TRUE(report.steering.empty());
  EXPECT_LT(report.output.tets, report.input.tets);
  EXPECT_THAT(notices, ::testing::Contains(HasSubstr("same")));
}

TEST_F(Simplify, TheTolerancesScaleHasNoLimits) {
  MeshFile file = box(7);
  std::set<std::uint64_t> sizes;
  request.behaviour.scalar_tolerance = {0.1};
  for (const double scale : {0x1p-1000, 1.0, 0x1p1020}) {
    file.point_arrays = {
        point_array<double>(file, "f", [&](const P& p) { return (p.x - 3.5) * scale; })};
    const SimplifyReport report = run(file);
    EXPECT_THAT(report.steering, ElementsAre("f")) << scale;
    sizes.insert(report.output.tets);
    const DataArray values = read_point_array(open_mesh(request.output).get(), "f");
    for (const double v : values.as<double>()) EXPECT_TRUE(std::isfinite(v));
  }
  EXPECT_EQ(sizes.size(), 1u);
}

TEST_F(Simplify, VerticesWithoutAValueStay) {
  MeshFile file = box(7);
  file.point_arrays.push_back(point_array<double>(
      file, "holes", [](const P& p) { return p.x > 3 && p.x < 5 ? std::nan("") : p.x; }));
  const SimplifyReport report = run(file);
  EXPECT_GT(report.facts.locked_vertices, 0u);
  const auto source = open_mesh(request.output);
  const auto count_nan = [](const DataArray& a) {
    const auto v = a.as<double>();
    return std::count_if(v.begin(), v.end(), [](double x) { return std::isnan(x); });
  };
  EXPECT_EQ(count_nan(read_point_array(source.get(), "holes")), count_nan(file.point_arrays[0]));
}

TEST_F(Simplify, CarriedCellsKeepTheirPointsAndValues) {
  MeshFile file = box(6, 0.1);
  // A fault of two triangles and a sensor in the middle of the box; vertex ids run fastest in x.
  const auto at = [](VertexId x, VertexId y, VertexId z) { return (z * 7 + y) * 7 + x; };
  LowerCells& lower = file.geometry.lower;
  lower.types = {5, 5, 1, 3};
  lower.offsets = {0, 3, 6, 7, 9};
  lower.connectivity = {at(2, 2, 3), at(3, 2, 3), at(3, 3, 3), at(2, 2, 3), at(3, 3, 3),
                        at(2, 3, 3), at(4, 4, 4), at(2, 2, 2), at(3, 2, 2)};
  file.cell_arrays.push_back(
      make_array<std::int32_t>("tag", file.cells(), 1, [](auto i, auto) { return i; }));
  const auto positions = [](const Geometry& g) {
    std::vector<std::array<double, 3>> out;
    for (const VertexId v : g.lower.connectivity) {
      const P p = testing::point(g, v);
      out.push_back({p.x, p.y, p.z});
    }
    return out;
  };
  const SimplifyReport report = run(file);
  EXPECT_LT(report.output.tets, report.input.tets);
  const auto source = open_mesh(request.output);
  const Geometry g = source->read_geometry();
  EXPECT_EQ(g.lower.types, lower.types);
  EXPECT_EQ(g.lower.offsets, lower.offsets);
  EXPECT_EQ(positions(g), positions(file.geometry));
  const DataArray tags = read_cell_array(source.get(), "tag");
  for (std::size_t c = 0; c < 4; ++c) {
    EXPECT_EQ(tags.as<std::int32_t>()[g.tets.size() + c],
              static_cast<std::int32_t>(file.geometry.tets.size() + c));
  }
}

TEST_F(Simplify, MaterialInterfacesStay) {
  MeshFile file = box(8, 0.1);
  const auto material = [&](std::size_t t) {
    double x = 0;
    for (const VertexId v : file.geometry.tets[t]) x += testing::point(file.geometry, v).x / 4;
    return x < 4.1 ? 1 : 2;
  };
  file.cell_arrays.push_back(make_array<std::int32_t>("Material_Id", file.cells(), 1,
                                                      [&](auto i, auto) { return material(i); }));
  const SimplifyReport kept = run(file);
  EXPECT_THAT(kept.regions, ElementsAre("Material_Id"));
  const auto source = open_mesh(request.output);
  const Geometry g = source->read_geometry();
  const DataArray ids = read_cell_array(source.get(), "Material_Id");
  double volume = 0;
  double expected = 0;
  for (std::size_t t = 0; t < g.tets.size(); ++t) {
    if (ids.as<std::int32_t>()[t] == 1)
      volume += determinant(std::get<Vector<P>>(g.points), g.tets[t]).value / 6;
  }
  for (std::size_t t = 0; t < file.geometry.tets.size(); ++t) {
    if (material(t) != 1) continue;
    expected +=
        determinant(std::get<Vector<P>>(file.geometry.points), file.geometry.tets[t]).value / 6;
  }
  EXPECT_NEAR(volume, expected, 1e-10);
  request.behaviour.regions.emplace();
  EXPECT_LT(run(file).output.tets, kept.output.tets);
}

TEST(ChooseRegions, GoesByNameAndType) {
  MeshDescription mesh;
  const auto add = [&](const std::string& name, ValueType type, std::uint32_t components = 1) {
    mesh.cell_data.arrays.push_back({name, type, components, {}, 0});
  };
  add("MaterialIds", ValueType::kInt32);
  add("partition", ValueType::kInt32);
  add("gmsh:physical", ValueType::kInt64);
  add("zone", ValueType::kFloat32);
  add("ProcessId", ValueType::kInt32);
  add("part", ValueType::kUInt8);
  add("labels", ValueType::kInt32, 3);
  EXPECT_THAT(choose_regions(mesh, std::nullopt), ElementsAre(0u, 2u, 5u));
  EXPECT_THAT(choose_regions(mesh, {{"zone", "partition"}}), ElementsAre(3u, 1u));
  try {
    choose_regions(mesh, {{"labels"}});
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kUsage);
    EXPECT_THAT(e.what(), HasSubstr("there are: MaterialIds, partition, gmsh:physical, zone, "
                                    "ProcessId, part"));
  }
}

TEST_F(Simplify, TheBytesDoNotDependOnThreads) {
  MeshFile file = box(12);
  file.geometry = testing::to_float(file.geometry);
  file.point_arrays.push_back(
      point_array<float>(file, "f", [](const P& p) { return std::sin(p.x) * p.y; }));
  request.behaviour.scalar_tolerance = {0.05};
  request.encoding = Encoding::kZlib;
  std::set<std::string> outputs;
  for (const int threads : {1, 2, 5}) {
    request.performance.threads = threads;
    run(file);
    outputs.insert(bytes_of(request.output));
  }
  set_thread_count(0);
  EXPECT_EQ(outputs.size(), 1u);
}

TEST_F(Simplify, TheGoalIsMetFromAbove) {
  const MeshFile file = box(16);
  const auto tets = static_cast<double>(file.geometry.tets.size());
  for (const std::uint64_t chunk_tets : {200'000, 3000, 500}) {
    request.behaviour.chunk_tets = chunk_tets;
    for (const double reduction : {0.0, 0.001, 0.01, 0.1, 0.25, 0.4}) {
      request.behaviour.reduction = reduction;
      const SimplifyReport report = run(file);
      EXPECT_EQ(report.stop_reason, StopReason::kGoal) << reduction;
      EXPECT_GE(static_cast<double>(report.output.tets), tets * (1 - reduction) - 1e-6);
      EXPECT_LT(static_cast<double>(report.output.tets), tets * (1 - reduction) + 60);
    }
    request.behaviour.reduction = 0.99;
    const SimplifyReport report = run(file);
    EXPECT_EQ(report.stop_reason, StopReason::kSaturated);
    EXPECT_THAT(report.stop_sentence(), HasSubstr("The goal was not reached"));
  }
}

TEST_F(Simplify, SaysWhyVerticesStay) {
  MeshFile file = box(8);
  request.behaviour.method = Method::kFuse;
  request.behaviour.reduction = 0.9;
  request.behaviour.interest = {"box=-1e9,1e9,-1e9,1e9,-1e9,1e9"};
  EXPECT_THAT(run(file).stop_sentence(),
              HasSubstr("because a vertex of theirs lies in the region of interest, and stays."));
  file.cell_arrays.push_back(
      make_array<std::int32_t>("material", file.cells(), 1, [](auto i, auto) { return i; }));
  EXPECT_THAT(run(file).stop_sentence(),
              HasSubstr("lies between regions of material or in the region of interest, and"));
  request.behaviour.interest = {};
  EXPECT_THAT(run(file).stop_sentence(), HasSubstr("lies between regions of material, and stays."));
  request.behaviour.boundary = Boundary::kPlanar;
  EXPECT_THAT(run(file).stop_sentence(),
              HasSubstr("lies at an edge, a corner, a rim or a step between regions of "
                        "material, and stays"));
  // One region has nothing between it and another one.
  file.cell_arrays = {
      make_array<std::int32_t>("material", file.cells(), 1, [](auto, auto) { return 7; })};
  request.behaviour.interest = {"box=-1e9,1e9,-1e9,1e9,-1e9,1e9"};
  EXPECT_THAT(run(file).stop_sentence(),
              HasSubstr("because a vertex of theirs lies in the region of interest, and stays."));
}

// The second level takes from all over the mesh, too, though the first one ended with single
// fusions here and there.
TEST_F(Simplify, EveryLevelIsSpread) {
  MeshFile file = box(14);
  const std::size_t tets = file.cells();
  file.cell_arrays.push_back(
      make_array<std::int32_t>("number", tets, 1, [](auto i, auto) { return i; }));
  request.output = folder.file("level_{lod}.vtu");
  request.behaviour.lods = {0.1, 0.2};
  for (const std::uint64_t chunk_tets : {200'000, 2000}) {
    request.behaviour.chunk_tets = chunk_tets;
    EXPECT_EQ(run(file).stop_reason, StopReason::kGoal);
    for (const int level : {1, 2}) {
      const auto source = open_mesh(folder.file("level_" + std::to_string(level) + ".vtu"));
      const DataArray numbers = read_cell_array(source.get(), "number");
      std::array<double, 4> left{};
      for (const std::int32_t n : numbers.as<std::int32_t>()) {
        ++left.at(4 * static_cast<std::size_t>(n) / tets);
      }
      const double mean = static_cast<double>(numbers.info.tuples) / 4;
      for (const double l : left) EXPECT_NEAR(l, mean, 0.06 * mean) << level << " " << chunk_tets;
    }
  }
}

// Whatever is broken in a mesh comes out as it went in, and nothing new is broken.
TEST_F(Simplify, DefectsStayAsTheyAre) {
  std::uint64_t fused = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    MeshFile file;
    file.geometry = testing::damaged_mesh(seed);
    request.behaviour.chunk_tets = 20 + seed % 50;
    request.performance.on_disk = seed % 2 == 0;
    const SimplifyReport report = run(file);
    for (const RoundSummary& lod : report.rounds) fused += lod.pass.fused;
    Geometry before = file.geometry, after = open_mesh(request.output)->read_geometry();
    const Inspection a = inspect(before), b = inspect(after);
    EXPECT_EQ(b.degenerate, a.degenerate);
    EXPECT_EQ(b.duplicate_tets, a.duplicate_tets);
    EXPECT_EQ(b.overfull_faces, a.overfull_faces);
    EXPECT_EQ(b.foldover_faces, a.foldover_faces);
    EXPECT_EQ(b.nonmanifold_edges, a.nonmanifold_edges);
    EXPECT_EQ(b.nonmanifold_vertices, a.nonmanifold_vertices);
    EXPECT_EQ(b.boundary_faces, a.boundary_faces);
    EXPECT_EQ(b.components, a.components);
    EXPECT_NEAR(b.volume, a.volume, 1e-11 * std::abs(a.volume));
    EXPECT_EQ(b.rewound, 0u);
    EXPECT_EQ(report.output.boundary_triangles, a.boundary_faces);
    if (HasFailure()) break;
  }
  EXPECT_GT(fused, 10u);
}

TEST_F(Simplify, AnInterruptedRunLeavesTheOldFile) {
  MeshFile file = box(6);
  file.write(request.input);
  std::ofstream(request.output) << "old";
  std::atomic<bool> cancelled{false};
  RunContext context;
  context.cancelled = &cancelled;
  context.progress = [&](std::string_view phase, double) {
    if (phase == "writing") cancelled = true;
  };
  try {
    simplify(request, context);
    FAIL() << "was not interrupted";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kInterrupted);
  }
  EXPECT_EQ(bytes_of(request.output), "old");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 2);
}

TEST_F(Simplify, ProgressOnlyGrows) {
  box(10).write(request.input);
  request.behaviour.chunk_tets = 500;
  // From several threads shares may come a little out of order; phases do not.
  for (const auto& [threads, encoding] :
       {std::pair(1, Encoding::kRaw), std::pair(1, Encoding::kZlib),
        std::pair(3, Encoding::kRaw)}) {
    request.performance.threads = threads;
    request.encoding = encoding;
    std::mutex mutex;
    double last = 0;
    std::vector<std::string> phases;
    RunContext context;
    context.progress = [&](std::string_view phase, double share) {
      const std::lock_guard lock(mutex);
      EXPECT_GE(share, request.performance.threads == 1 ? last : last - 0.1);
      EXPECT_LE(share, 1);
      last = share;
      if (phases.empty() || phases.back() != phase) phases.emplace_back(phase);
    };
    simplify(request, context);
    EXPECT_EQ(last, 1);
    EXPECT_THAT(phases, ElementsAre("reading", "assembling", "fusing", "writing", "done"));
  }
  set_thread_count(0);
}

}  // namespace
}  // namespace tetfusion
