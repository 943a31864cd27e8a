#include "mesh/inspection/inspect.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "base/resources.h"
#include "support/brute_check.h"
#include "support/damaged_meshes.h"
#include "support/meshes.h"

namespace tetfusion {
namespace {

using testing::brute_check;
using testing::BruteReport;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::make_mesh;

Vector<Vec3<double>>& points(Geometry& mesh) { return std::get<Vector<Vec3<double>>>(mesh.points); }

void expect_no_defect(const Inspection& i) {
  EXPECT_EQ(i.degenerate, 0u);
  EXPECT_EQ(i.inverted, 0u);
  EXPECT_EQ(i.duplicate_tets, 0u);
  EXPECT_EQ(i.foldover_faces, 0u);
  EXPECT_EQ(i.overfull_faces, 0u);
  EXPECT_EQ(i.nonmanifold_edges, 0u);
  EXPECT_EQ(i.nonmanifold_vertices, 0u);
  EXPECT_EQ(i.coincident_points, 0u);
  for (const FirstIds& sample : i.samples) EXPECT_THAT(sample.ids(), IsEmpty());
}

std::set<std::array<VertexId, 3>> sorted_boundary(const Inspection& i) {
  std::set<std::array<VertexId, 3>> set;
  for (auto t : i.boundary_triangles) {
    std::sort(t.begin(), t.end());
    set.insert(t);
  }
  return set;
}

TEST(Inspect, SingleTet) {
  Geometry mesh = testing::single_tet();
  const Inspection i = inspect(mesh);
  expect_no_defect(i);
  EXPECT_EQ(i.rewound, 0u);
  EXPECT_THAT(i.vertex_flags, Each(kBoundaryVertex));
  EXPECT_EQ(i.boundary_faces, 4u);
  EXPECT_EQ(i.boundary_edges, 6u);
  EXPECT_EQ(i.boundary_vertices, 4u);
  EXPECT_EQ(i.surface_euler(), 2);
  EXPECT_EQ(i.surface_components, 1u);
  EXPECT_EQ(i.components, 1u);
  EXPECT_DOUBLE_EQ(i.volume, 1.0 / 6);
  EXPECT_THAT(i.lower, ElementsAre(0, 0, 0));
  EXPECT_THAT(i.upper, ElementsAre(1, 1, 1));
  using T = std::array<VertexId, 3>;  // wound outwards
  EXPECT_THAT(i.boundary_triangles, ElementsAre(T{0, 2, 1}, T{0, 1, 3}, T{0, 3, 2}, T{1, 2, 3}));
}

TEST(Inspect, AMeshWithoutCells) {
  Geometry mesh = make_mesh({{0, 0, 0}}, {});
  const Inspection i = inspect(mesh);
  expect_no_defect(i);
  EXPECT_THAT(i.vertex_flags, ElementsAre(kUnusedVertex));
  EXPECT_EQ(i.unused_points, 1u);
  EXPECT_EQ(i.components, 0u);
}

TEST(Inspect, InteriorVertexOfABall) {
  Geometry mesh = testing::icosahedron_ball();
  ASSERT_EQ(mesh.tets.size(), 20u);
  const Inspection i = inspect(mesh);
  expect_no_defect(i);
  EXPECT_EQ(i.vertex_flags[0], 0);
  EXPECT_EQ(i.boundary_vertices, 12u);
  EXPECT_EQ(i.boundary_faces, 20u);
  EXPECT_EQ(i.surface_euler(), 2);
}

TEST(Inspect, GridsAreSound) {
  for (Geometry mesh : {testing::five_split_box(4, 3, 5, 0.2), testing::kuhn_box(3, 4, 2, 0.2),
                        testing::plate(5), testing::to_float(testing::five_split_cube(4, 0.2))}) {
    const Inspection i = inspect(mesh);
    expect_no_defect(i);
    EXPECT_EQ(i.rewound, 0u);
    EXPECT_EQ(i.components, 1u);
    EXPECT_EQ(i.surface_euler(), 2);
    EXPECT_NEAR(i.volume, i.upper[0] * i.upper[1] * i.upper[2], 1e-5);
  }
}

TEST(Inspect, RewindsAndReportsNoInversion) {
  Geometry mesh = testing::five_split_cube(3);
  const Vector<Tet> right = mesh.tets;
  for (std::size_t t = 0; t < mesh.tets.size(); t += 2) testing::flip_winding(&mesh.tets[t]);
  const Inspection i = inspect(mesh);
  expect_no_defect(i);
  EXPECT_EQ(i.rewound, (right.size() + 1) / 2);
  EXPECT_EQ(mesh.tets, right);
  EXPECT_DOUBLE_EQ(i.volume, 27);
}

TEST(Inspect, AWholeMeshWoundTheOtherWayIsNotInverted) {
  Geometry mesh = testing::five_split_cube(2);
  for (Tet& t : mesh.tets) testing::flip_winding(&t);
  const Inspection i = inspect(mesh);
  expect_no_defect(i);
  EXPECT_EQ(i.rewound, mesh.tets.size());
}

TEST(Inspect, FlatCellIsDegenerate) {
  Geometry mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}},
                            {{0, 1, 2, 3}, {0, 1, 2, 4}});
  const Inspection i = inspect(mesh);
  EXPECT_EQ(i.degenerate, 1u);
  EXPECT_EQ(i.foldover_faces, 0u);
  EXPECT_THAT(i.first(Defect::kDegenerate).ids(), ElementsAre(1));
  EXPECT_EQ(i.vertex_flags[4], kBoundaryVertex | kBrokenVertex);
  EXPECT_EQ(i.vertex_flags[3], kBoundaryVertex);
  EXPECT_DOUBLE_EQ(i.volume, 1.0 / 6);
}

TEST(Inspect, AlmostFlatFarFromTheOriginIsDegenerate) {
  Geometry mesh = testing::single_tet();
  for (auto& p : points(mesh)) p.z = 1e-17 * p.z + 1;
  EXPECT_EQ(inspect(mesh).degenerate, 1u);
}

TEST(Inspect, ARepeatedVertexIsDegenerateAndHasNoFaces) {
  Geometry mesh = testing::two_tets_sharing_face();
  mesh.tets.push_back({0, 1, 2, 2});
  const Inspection i = inspect(mesh);
  EXPECT_EQ(i.degenerate, 1u);
  EXPECT_EQ(i.overfull_faces, 0u);
  EXPECT_EQ(i.boundary_faces, 6u);
  EXPECT_EQ(i.components, 2u);
  EXPECT_EQ(i.vertex_flags[0], kBoundaryVertex | kBrokenVertex);
  EXPECT_EQ(i.vertex_flags[3], kBoundaryVertex);
}

TEST(Inspect, TwoCellsOnOneSideOfAFaceFoldOver) {
  Geometry mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 2}},
                            {{0, 1, 2, 3}, {0, 2, 1, 4}});
  const Inspection i = inspect(mesh);
  EXPECT_EQ(i.foldover_faces, 1u);
  EXPECT_EQ(i.inverted, 1u);
  EXPECT_EQ(i.rewound, 0u);  // inverted cells are counted as that alone
  // The one that was wound against its neighbour.
  EXPECT_THAT(i.first(Defect::kInverted).ids(), ElementsAre(1));
  EXPECT_THAT(i.first(Defect::kFoldoverFace).ids(), ElementsAre(0));
  EXPECT_THAT(i.vertex_flags, Each(kBoundaryVertex | kBrokenVertex));
}

TEST(Inspect, AVertexPushedThroughItsNeighboursInverts) {
  Geometry mesh = testing::icosahedron_ball();
  points(mesh)[0] = {0, 0, 10};
  const std::uint64_t negative = brute_check(mesh).negative;
  ASSERT_GT(negative, 0u);
  ASSERT_NE(negative, 10u);
  Geometry other_way = mesh;
  for (Tet& t : other_way.tets) testing::flip_winding(&t);
  for (Geometry* m : {&mesh, &other_way}) {
    const bool flipped = m == &other_way;
    const Inspection i = inspect(*m);
    EXPECT_EQ(i.inverted, std::min(negative, 20 - negative));
    EXPECT_EQ(i.rewound, flipped == (negative < 10) ? 20 - i.inverted : 0);
    EXPECT_EQ(brute_check(*m).negative, 0u);
    EXPECT_EQ(i.foldover_faces, brute_check(*m).foldover);
  }
}

TEST(Inspect, Duplicates) {
  Geometry mesh = testing::two_tets_sharing_face();
  mesh.tets.push_back({3, 0, 2, 1});  // cell 0 again, wound otherwise
  mesh.tets.push_back({0, 1, 2, 3});
  const Inspection i = inspect(mesh);
  EXPECT_EQ(i.duplicate_tets, 2u);
  EXPECT_THAT(i.first(Defect::kDuplicate).ids(), ElementsAre(2, 3));
  EXPECT_EQ(i.overfull_faces, 4u);
  EXPECT_EQ(i.inverted, 0u);
  EXPECT_EQ(i.vertex_flags[3] & kBrokenVertex, kBrokenVertex);
  EXPECT_EQ(i.vertex_flags[4] & kBrokenVertex, 0);
}

TEST(Inspect, TwoCopiesOfOneCellAreNoFoldover) {
  Geometry mesh = testing::single_tet();
  mesh.tets.push_back(mesh.tets[0]);
  const Inspection i = inspect(mesh);
  EXPECT_EQ(i.duplicate_tets, 1u);
  EXPECT_EQ(i.foldover_faces, 0u);
  EXPECT_EQ(i.inverted, 0u);
  EXPECT_EQ(i.boundary_faces, 0u);
}

TEST(Inspect, ThreeCellsAtOneFace) {
  Geometry mesh = testing::two_tets_sharing_face();
  points(mesh).push_back({0.25, 0.25, 3});
  mesh.tets.push_back({0, 1, 2, 5});
  const Inspection i = inspect(mesh);
  EXPECT_EQ(i.overfull_faces, 1u);
  EXPECT_THAT(i.first(Defect::kOverfullFace).ids(), ElementsAre(0));
  EXPECT_EQ(i.duplicate_tets, 0u);
  for (const VertexId v : {0u, 1u, 2u}) EXPECT_NE(i.vertex_flags[v] & kBrokenVertex, 0);
  for (const VertexId v : {3u, 4u, 5u}) EXPECT_EQ(i.vertex_flags[v] & kBrokenVertex, 0);
}

TEST(Inspect, CellsThatShareOnlyAnEdge) {
  Geometry mesh = testing::two_tets_sharing_edge();
  const Inspection i = inspect(mesh);
  EXPECT_EQ(i.nonmanifold_edges, 1u);
  EXPECT_THAT(i.first(Defect::kNonmanifoldEdge).ids(), ElementsAre(0));
  EXPECT_EQ(i.nonmanifold_vertices, 2u);
  EXPECT_THAT(i.first(Defect::kNonmanifoldVertex).ids(), ElementsAre(0, 1));
  EXPECT_EQ(i.components, 2u);
  EXPECT_EQ(i.surface_components, 1u);
  EXPECT_EQ(i.vertex_flags[2], kBoundaryVertex);
}

TEST(Inspect, CellsThatShareOnlyAVertex) {
  Geometry mesh = testing::two_tets_sharing_vertex();
  const Inspection i = inspect(mesh);
  EXPECT_EQ(i.nonmanifold_edges, 0u);
  EXPECT_EQ(i.nonmanifold_vertices, 1u);
  EXPECT_THAT(i.first(Defect::kNonmanifoldVertex).ids(), ElementsAre(0));
  EXPECT_EQ(i.vertex_flags[0], kBoundaryVertex | kBrokenVertex);
}

TEST(Inspect, TwoBallsRoundOneInteriorVertex) {
  Geometry mesh = testing::icosahedron_ball();
  const Geometry one = mesh;
  for (VertexId v = 1; v <= 12; ++v) {
    const auto p = points(mesh)[v];
    points(mesh).push_back({2 * p.x, 2 * p.y, 2 * p.z});
  }
  for (const Tet& t : one.tets) {
    mesh.tets.push_back({t[0], t[1] + 12, t[2] + 12, t[3] + 12});
  }
  const Inspection i = inspect(mesh);
  EXPECT_EQ(i.nonmanifold_vertices, 1u);
  EXPECT_EQ(i.vertex_flags[0], kBrokenVertex);
  EXPECT_EQ(i.components, 2u);
}

TEST(Inspect, AWholeBallAndAWedgeAtOneVertex) {
  // The boundary at vertex 0 is one fan, of the wedge alone; but its ball is two.
  Geometry mesh = testing::icosahedron_ball();
  points(mesh).insert(points(mesh).end(), {{5, 0, 0}, {0, 5, 0}, {0, 0, 5}});
  mesh.tets.push_back({0, 13, 14, 15});
  const Inspection i = inspect(mesh);
  EXPECT_EQ(i.nonmanifold_edges, 0u);
  EXPECT_EQ(i.nonmanifold_vertices, 1u);
  EXPECT_EQ(i.vertex_flags[0], kBoundaryVertex | kBrokenVertex);
}

TEST(Inspect, ACrackIsTwoSurfaces) {
  // Two boxes side by side whose points coincide in one plane but are not shared.
  Geometry mesh = testing::five_split_box(2, 2, 2);
  Geometry right = testing::five_split_box(2, 2, 2);
  const auto shift = static_cast<VertexId>(point_count(mesh.points));
  for (const auto& p : points(right)) points(mesh).push_back({p.x + 2, p.y, p.z});
  for (const Tet& t : right.tets) {
    mesh.tets.push_back({t[0] + shift, t[1] + shift, t[2] + shift, t[3] + shift});
  }
  const Inspection i = inspect(mesh);
  EXPECT_EQ(i.coincident_points, 9u);
  EXPECT_EQ(i.first(Defect::kCoincidentPoint).ids().front(), 27u);
  EXPECT_EQ(i.components, 2u);
  EXPECT_EQ(i.surface_components, 2u);
  EXPECT_EQ(i.nonmanifold_vertices, 0u);
}

TEST(Inspect, NegativeZeroCoincidesWithZero) {
  Geometry mesh =
      make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-0.0, -1, 0}, {0, -1, -0.0}},
                {{0, 1, 2, 3}, {0, 1, 3, 4}, {0, 1, 3, 5}});
  EXPECT_EQ(inspect(mesh).coincident_points, 1u);
}

TEST(Inspect, ARingHasATunnel) {
  // Eight of the nine columns of a 3 x 3 x 1 box.
  const Geometry box = testing::five_split_box(3, 3, 1);
  Geometry ring = box;
  ring.tets.clear();
  for (std::size_t t = 0; t < box.tets.size(); ++t) {
    if (t / 5 != 4) ring.tets.push_back(box.tets[t]);
  }
  const Inspection i = inspect(ring);
  expect_no_defect(i);
  EXPECT_EQ(i.surface_euler(), 0);
}

TEST(Inspect, CarriedAndUnusedVertices) {
  Geometry mesh = testing::single_tet();
  points(mesh).push_back({9, 9, 9});
  mesh.lower.types = {5};
  mesh.lower.offsets = {0, 3};
  mesh.lower.connectivity = {0, 1, 3};
  const Inspection i = inspect(mesh);
  EXPECT_THAT(i.vertex_flags,
              ElementsAre(kBoundaryVertex | kCarriedVertex, kBoundaryVertex | kCarriedVertex,
                          kBoundaryVertex, kBoundaryVertex | kCarriedVertex, kUnusedVertex));
  EXPECT_EQ(i.unused_points, 1u);
}

TEST(InspectProperty, AgreesWithTheBruteCheck) {
  std::uint64_t foldovers = 0, overfull = 0, edges = 0, uncertain = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    Geometry mesh = testing::damaged_mesh(seed);
    if (seed % 2 == 0) testing::shuffle(&mesh, seed);
    const BruteReport before = brute_check(mesh);
    const Inspection i = inspect(mesh);
    if (i.degenerate != before.zero) {  // a cell as good as flat
      ++uncertain;
      continue;
    }
    const BruteReport after = brute_check(mesh);
    ASSERT_EQ(after.negative, 0u);
    ASSERT_LE(i.rewound, before.negative);
    ASSERT_GE(i.rewound + i.inverted, before.negative);
    ASSERT_EQ(i.duplicate_tets, before.duplicates);
    ASSERT_EQ(i.foldover_faces, before.foldover);
    ASSERT_EQ(i.overfull_faces, before.overfull);
    ASSERT_EQ(i.nonmanifold_edges, before.nonmanifold_edges);
    ASSERT_GE(i.nonmanifold_vertices, before.nonmanifold_vertices);
    ASSERT_EQ(i.components, before.components);
    ASSERT_EQ(sorted_boundary(i), before.boundary);
    ASSERT_EQ(i.boundary_faces, before.boundary.size());
    ASSERT_NEAR(i.volume, static_cast<double>(before.volume), 1e-12);
    ASSERT_EQ(i.inverted > 0, before.foldover > 0);
    foldovers += i.foldover_faces;
    overfull += i.overfull_faces;
    edges += i.nonmanifold_edges;
  }
  EXPECT_LT(uncertain, 5u);
  EXPECT_GT(foldovers, 100u);
  EXPECT_GT(overfull, 100u);
  EXPECT_GT(edges, 100u);
}

TEST(InspectProperty, ThreadsChangeNothing) {
  Geometry mesh = testing::five_split_cube(30, 0.2);
  points(mesh)[40 * 31] = {3, 2, 1};
  for (std::size_t t = 0; t < mesh.tets.size(); t += 1000) mesh.tets.push_back(mesh.tets[t]);
  Geometry again = mesh;
  set_thread_count(1);
  const Inspection one = inspect(mesh);
  set_thread_count(4);
  const Inspection four = inspect(again);
  set_thread_count(0);
  EXPECT_EQ(mesh.tets, again.tets);
  EXPECT_EQ(one.vertex_flags, four.vertex_flags);
  EXPECT_EQ(one.boundary_triangles, four.boundary_triangles);
  EXPECT_EQ(one.volume, four.volume);
  EXPECT_EQ(one.inverted, four.inverted);
  for (std::size_t k = 0; k < kDefectKinds; ++k) {
    EXPECT_EQ(one.samples[k].ids(), four.samples[k].ids());
  }
}

}  // namespace
}  // namespace tetfusion
