// Runs whose boundary, and whose surfaces between regions, may move.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "driver/simplify.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "mesh/inspection/inspect.h"
#include "partition/curve_cut.h"
#include "support/file_request.h"
#include "support/mesh_file.h"
#include "support/surfaces.h"
#include "support/temp_dir.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

using testing::distance_between;
using testing::five_split_cube;
using ::testing::HasSubstr;
using testing::MeshFile;
using ::testing::Not;
using testing::point_array;
using testing::surface_of;
using testing::TempDir;

using P = Vec3<double>;

MeshFile wavy_box(std::uint32_t n) {
  MeshFile file;
  file.geometry = five_split_cube(n, 0.15, 4);
  for (P& p : std::get<Vector<P>>(file.geometry.points)) {
    p.z += 0.04 * p.z * std::sin(p.x) * std::cos(0.8 * p.y);
  }
  file.point_arrays.push_back(point_array<float>(
      file, "wave", [&](const P& p) { return std::sin(6 * p.x / n) * p.y + p.z; }));
  return file;
}

class BoundaryRun : public ::testing::Test {
 protected:
  SimplifyReport run(const MeshFile& file) {
    file.write(request.input);
    return simplify(request);
  }
  std::string refusal(const MeshFile& file) {
    try {
      run(file);
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kUsage);
      return e.what();
    }
    return "none";
  }
  WorkMesh<double> result() {
    return testing::to_work_mesh(open_mesh(request.output)->read_geometry());
  }
  double diagonal(const Geometry& g) {
    Box box;
    for (const P& p : std::get<Vector<P>>(g.points)) box.add(p);
    return std::hypot(box.hi.x - box.lo.x, box.hi.y - box.lo.y, box.hi.z - box.lo.z);
  }

  TempDir folder = TempDir::in_memory();
  SimplifyRequest request = testing::request_in(folder);
};

// Long triangles that lie beside each other round an apex are in few cells of the grid that finds
// what is in the way: it took half a minute while each was in all that the box round it touches.
TEST_F(BoundaryRun, AConeOfNeedlesTakesNoTime) {
  constexpr VertexId kSides = 360;
  MeshFile file;
  Vector<P> points{{0, 0, 2}, {0, 0, 0}};
  for (VertexId i = 0; i < kSides; ++i) {
    const double angle = 2 * std::acos(-1) * i / kSides;
    points.push_back({std::cos(angle), std::sin(angle), 0});
    file.geometry.tets.push_back({1, 2 + i, 2 + (i + 1) % kSides, 0});
  }
  file.geometry.points = points;
  file.point_arrays.push_back(
      point_array<double>(file, "f", [](const P& p) { return p.z * p.z + p.x; }));
  request.behaviour.boundary = Boundary::kWithin;
  request.behaviour.boundary_distance = 0.005;
  request.behaviour.reduction = 0.9;
  EXPECT_LT(run(file).output.tets, kSides / 4);
}

TEST_F(BoundaryRun, PlanarReachesWhatExactDoesNot) {
  MeshFile file;
  file.geometry = five_split_cube(12, 0.15, 4);
  file.point_arrays.push_back(
      point_array<float>(file, "f", [](const P& p) { return p.x * p.y + p.z; }));
  for (const std::uint64_t chunk_tets : {200'000, 2000}) {
    request.behaviour.chunk_tets = chunk_tets;
    request.behaviour.reduction = 0.9;
    request.behaviour.boundary = Boundary::kExact;
    SimplifyReport report = run(file);
    EXPECT_EQ(report.stop_reason, StopReason::kSaturated);
    EXPECT_EQ(report.output.boundary_triangles, report.input.boundary_triangles);
    request.behaviour.boundary = Boundary::kPlanar;
    report = run(file);
    EXPECT_EQ(report.stop_reason, StopReason::kGoal);
    EXPECT_LT(report.output.boundary_triangles, report.input.boundary_triangles / 4);
    EXPECT_NEAR(report.output.volume / report.input.volume, 1, 1e-12);
    EXPECT_LT(report.rounds.back().deviation, 1e-12);
    EXPECT_THAT(to_json(report), HasSubstr("\"mode\": \"planar\""));
    Geometry out = open_mesh(request.output)->read_geometry();
    const Inspection inspection = inspect(out);
    EXPECT_EQ(inspection.degenerate + inspection.inverted + inspection.foldover_faces, 0u);
    EXPECT_EQ(inspection.nonmanifold_edges, 0u);
  }
}

// Slanted planes: what their points in double precision are off by is nothing to an integral, what
// seven digits are off by is something.
TEST_F(BoundaryRun, WhereIntegralsStayPlanesAreFlatter) {
  MeshFile slanted;
  slanted.geometry = five_split_cube(12, 0.15, 4);
  for (P& p : std::get<Vector<P>>(slanted.geometry.points)) {
    p = {0.8 * p.x - 0.6 * p.y, 0.36 * p.x + 0.48 * p.y - 0.8 * p.z,
         0.48 * p.x + 0.64 * p.y + 0.6 * p.z};
  }
  slanted.point_arrays.push_back(
      point_array<double>(slanted, "f", [](const P& p) { return 40 + p.x * p.y + p.z; }));
  MeshFile rounded = slanted;
  for (P& p : std::get<Vector<P>>(rounded.geometry.points)) {
    p = {double{static_cast<float>(p.x)}, double{static_cast<float>(p.y)},
         double{static_cast<float>(p.z)}};
  }
  request.verify = true;
  request.behaviour.boundary = Boundary::kPlanar;
  request.behaviour.reduction = 0.9;
  for (const std::uint64_t chunk_tets : {200'000, 2000}) {
    request.behaviour.chunk_tets = chunk_tets;
    request.behaviour.conserve = false;
    EXPECT_EQ(run(rounded).stop_reason, StopReason::kGoal);
    request.behaviour.conserve = true;
    EXPECT_EQ(run(slanted).stop_reason, StopReason::kGoal);
    const SimplifyReport report = run(rounded);
    EXPECT_LT(report.output.tets, report.input.tets / 2);
    EXPECT_NEAR(report.output.volume / report.input.volume, 1, 1e-12);
  }
}

TEST_F(BoundaryRun, TheDeviationIsABoundOverManyChunks) {
  const MeshFile file = wavy_box(10);
  const auto before = surface_of(testing::to_work_mesh(file.geometry));
  request.behaviour.boundary = Boundary::kWithin;
  request.behaviour.boundary_distance = 0.005;
  request.behaviour.reduction = 0.9;
  for (const std::uint64_t chunk_tets : {200'000, 1500}) {
    request.behaviour.chunk_tets = chunk_tets;
    const SimplifyReport report = run(file);
    const double bound = report.rounds.back().deviation;
    EXPECT_LE(bound, 0.005 * (1 + 1e-6));
    EXPECT_GT(bound, 0);
    const auto after = surface_of(result());
    EXPECT_LT(after.size(), before.size() * 2 / 3);
    EXPECT_LE(distance_between(before, after) / diagonal(file.geometry), bound);
  }
}

// With several chunks, too, the regions' volumes stay, and where exact locks the interface, planar
// does not.
TEST_F(BoundaryRun, RegionsStayWhereTheyAre) {
  MeshFile file;
  file.geometry = five_split_cube(12);
  file.point_arrays.push_back(
      point_array<float>(file, "f", [](const P& p) { return p.x * p.y + p.z; }));
  file.cell_arrays.push_back(
      testing::make_array<std::int32_t>("material", file.cells(), 1, [&](std::size_t t, auto) {
        double x = 0;
        for (const VertexId v : file.geometry.tets[t]) x += testing::point(file.geometry, v).x / 4;
        return x < 6 ? 1 : 2;
      }));
  request.behaviour.reduction = 0.85;
  request.behaviour.chunk_tets = 2000;
  const std::uint64_t exact = run(file).output.tets;
  request.behaviour.boundary = Boundary::kPlanar;
  const SimplifyReport report = run(file);
  EXPECT_LT(report.output.tets, exact);
  EXPECT_EQ(report.facts.locked_vertices, 0u);
  const auto source = open_mesh(request.output);
  const Geometry g = source->read_geometry();
  const DataArray materials = testing::read_cell_array(source.get(), "material");
  double volume = 0;
  for (std::size_t t = 0; t < g.tets.size(); ++t) {
    if (materials.as<std::int32_t>()[t] != 1) continue;
    volume += determinant(std::get<Vector<P>>(g.points), g.tets[t]).value / 6;
  }
  EXPECT_NEAR(volume, 12 * 12 * 6, 1e-9);
}

// Regions of floating-point numbers are kept as those of integers are, in the same mesh, and
// conservation does not mix them.
TEST_F(BoundaryRun, RegionsOfFloatsStayWhereTheyAre) {
  MeshFile file;
  file.geometry = five_split_cube(12);
  file.point_arrays.push_back(
      point_array<float>(file, "f", [](const P& p) { return p.x * p.y + p.z; }));
  const auto low = [&](std::size_t t) {
    double x = 0;
    for (const VertexId v : file.geometry.tets[t]) x += testing::point(file.geometry, v).x / 4;
    return x < 6;
  };
  file.cell_arrays.push_back(testing::make_array<double>(
      "material", file.cells(), 1, [&](std::size_t t, auto) { return low(t) ? 0.1 : 0.7; }));
  MeshFile integers = file;
  integers.cell_arrays[0] = testing::make_array<std::int64_t>(
      "material", file.cells(), 1, [&](std::size_t t, auto) { return low(t) ? 1 : 7; });
  request.verify = true;
  request.behaviour.regions = {{"material"}};
  request.behaviour.reduction = 0.85;
  for (const Boundary boundary : {Boundary::kExact, Boundary::kPlanar}) {
    for (const bool conserve : {false, true}) {
      request.behaviour.boundary = boundary;
      request.behaviour.conserve = conserve;
      request.behaviour.chunk_tets = conserve ? 200'000 : 2000;
      run(integers);
      const Geometry expected = open_mesh(request.output)->read_geometry();
      EXPECT_THAT(run(file).regions, ::testing::ElementsAre("material"));
      const auto source = open_mesh(request.output);
      const Geometry g = source->read_geometry();
      EXPECT_EQ(g.tets, expected.tets);
      const DataArray materials = testing::read_cell_array(source.get(), "material");
      double volume = 0;
      for (std::size_t t = 0; t < g.tets.size(); ++t) {
        const double value = materials.as<double>()[t];
        EXPECT_TRUE(value == 0.1 || value == 0.7) << value;
        if (value != 0.1) continue;
        volume += determinant(std::get<Vector<P>>(g.points), g.tets[t]).value / 6;
      }
      EXPECT_NEAR(volume, 12 * 12 * 6, 1e-9);
    }
  }
}

// A field that is given as one leaves nothing to fuse, but what stays is a mesh.
TEST_F(BoundaryRun, WithRegionsEverywhereNothingFuses) {
  MeshFile file = wavy_box(8);
  file.cell_arrays.push_back(testing::make_array<float>("temperature", file.cells(), 1,
                                                        [](auto t, auto) { return 0.1 * t; }));
  request.verify = true;
  request.behaviour.regions = {{"temperature"}};
  request.behaviour.reduction = 0.5;
  for (const Boundary boundary : {Boundary::kExact, Boundary::kPlanar}) {
    request.behaviour.boundary = boundary;
    request.behaviour.chunk_tets = boundary == Boundary::kExact ? 200'000 : 500;
    const SimplifyReport report = run(file);
    EXPECT_EQ(report.stop_reason, StopReason::kSaturated);
    EXPECT_EQ(report.output.tets, report.input.tets);
  }
}

// A ball cut from a lattice: its surface is bent everywhere, and nothing but that holds it.
TEST_F(BoundaryRun, ARoughSurfaceGoesWhereNothingIsSharp) {
  MeshFile file;
  file.geometry = five_split_cube(12, 0.2, 3);
  std::erase_if(file.geometry.tets, [&](const Tet& t) {
    P centre{-6, -6, -6};
    for (const VertexId v : t) {
      const P p = testing::point(file.geometry, v);
      centre = {centre.x + p.x / 4, centre.y + p.y / 4, centre.z + p.z / 4};
    }
    return std::hypot(centre.x, centre.y, centre.z) > 5.6;
  });
  file.point_arrays.push_back(
      point_array<float>(file, "f", [](const P& p) { return p.x + std::sin(p.y); }));
  const auto before = surface_of(testing::to_work_mesh(file.geometry));
  request.behaviour.boundary = Boundary::kWithin;
  request.behaviour.boundary_distance = 0.2;
  request.behaviour.reduction = 0.99;
  request.behaviour.chunk_tets = 2500;
  SimplifyReport report = run(file);
  const std::uint64_t with_edges = report.output.boundary_triangles;
  EXPECT_GT(with_edges, before.size() / 2);
  EXPECT_THAT(report.stop_sentence(), HasSubstr("lies at a corner of the surface"));
  EXPECT_THAT(report.stop_sentence(), HasSubstr("More may go with a larger feature angle"));
  request.behaviour.feature_angle = 180;
  report = run(file);
  EXPECT_THAT(report.stop_sentence(), Not(HasSubstr("feature angle")));
  EXPECT_LT(report.output.boundary_triangles, with_edges * 4 / 5);
  EXPECT_LE(distance_between(before, surface_of(result())) / diagonal(file.geometry),
            report.rounds.back().deviation);
}

// Vertices go along straight edges, as nothing else could be done there.
TEST_F(BoundaryRun, ALargeAngleLosesNothingOfABox) {
  MeshFile file;
  file.geometry = five_split_cube(10, 0.15, 4);
  file.point_arrays.push_back(point_array<float>(file, "f", [](const P& p) { return p.x; }));
  request.behaviour.boundary = Boundary::kPlanar;
  request.behaviour.reduction = 0.99;
  const std::uint64_t usual = run(file).output.boundary_triangles;
  request.behaviour.feature_angle = 180;
  EXPECT_LT(run(file).output.boundary_triangles, usual * 11 / 10);
}

TEST_F(BoundaryRun, RefusesAnglesThatAreNone) {
  const MeshFile file = wavy_box(3);
  request.behaviour.boundary = Boundary::kPlanar;
  for (const double angle : {0.0, -1.0, 181.0, std::nan("")}) {
    request.behaviour.feature_angle = angle;
    EXPECT_THAT(refusal(file), HasSubstr("--feature-angle must")) << angle;
  }
  request.behaviour.feature_angle = 60;
  EXPECT_EQ(refusal(file), "none");
  request.behaviour.boundary = Boundary::kExact;
  EXPECT_THAT(refusal(file), HasSubstr("--feature-angle is for a surface that may move"));
}

TEST_F(BoundaryRun, RefusesDistancesThatAreNone) {
  const MeshFile file = wavy_box(3);
  request.behaviour.boundary = Boundary::kWithin;
  for (const double distance : {0.0, -0.1, 1.0, std::nan("")}) {
    request.behaviour.boundary_distance = distance;
    EXPECT_THAT(refusal(file), HasSubstr("--boundary")) << distance;
  }
  request.behaviour.boundary = Boundary::kPlanar;
  request.behaviour.method = Method::kTetFuse;
  EXPECT_THAT(refusal(file), HasSubstr("--method fuse"));
}

}  // namespace
}  // namespace tetfusion
