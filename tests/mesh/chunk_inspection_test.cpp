#include "mesh/inspection/chunk_inspection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <vector>

#include "mesh/inspection/inspect.h"
#include "mesh/inspection/interface_inspection.h"
#include "support/damaged_meshes.h"
#include "support/meshes.h"

namespace tetfusion {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::make_mesh;

// What inspect() says of the whole, put together from chunks.
struct Joined {
  InterfaceVerdict verdict;
  Vector<std::uint8_t> flags;  // one a point
  Vector<Tet> tets;            // rewound
};

// A chunk with its own numbers. The numbers of its points are shuffled, and so are its cells.
struct Chunk {
  Points points;
  Vector<VertexId> point_ids;
  Vector<std::uint8_t> on_interface;
  Vector<std::uint64_t> cell_ids;
  Vector<Tet> tets;
};

using ChunkOf = std::function<std::uint32_t(std::size_t tet)>;

std::vector<Chunk> cut(const Geometry& mesh, std::uint32_t chunks, const ChunkOf& chunk_of,
                       std::uint64_t seed) {
  const std::size_t points = point_count(mesh.points);
  std::vector<std::uint32_t> low(points, chunks), high(points, 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (const VertexId v : mesh.tets[t]) {
      low[v] = std::min(low[v], chunk_of(t));
      high[v] = std::max(high[v], chunk_of(t));
    }
  }
  const double careless = seed % 4 == 0 ? 1 : seed % 4 == 1 ? 0.3 : 0;
  std::vector<Chunk> result(chunks);
  for (std::uint32_t c = 0; c < chunks; ++c) {
    Chunk& chunk = result[c];
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      if (chunk_of(t) == c) chunk.cell_ids.push_back(t);
    }
    std::uint64_t next = 0;
    const auto shuffled = [&](auto* items) {
      for (std::size_t i = items->size(); i > 1; --i) {
        const double x = testing::uniform(seed + c, ++next) * static_cast<double>(i);
        std::swap((*items)[i - 1], (*items)[static_cast<std::size_t>(x)]);
      }
    };
    shuffled(&chunk.cell_ids);
    for (const std::uint64_t t : chunk.cell_ids) {
      for (const VertexId v : mesh.tets[t]) chunk.point_ids.push_back(v);
    }
    for (VertexId v = 0; v < points && careless == 1; ++v) {
      if (testing::uniform(seed + c, 3 * v) < 0.1) chunk.point_ids.push_back(v);
    }
    std::sort(chunk.point_ids.begin(), chunk.point_ids.end());
    chunk.point_ids.erase(std::unique(chunk.point_ids.begin(), chunk.point_ids.end()),
                          chunk.point_ids.end());
    shuffled(&chunk.point_ids);
    std::vector<VertexId> local(points);
    Vector<Vec3<double>> positions;
    for (std::size_t i = 0; i < chunk.point_ids.size(); ++i) {
      const VertexId v = chunk.point_ids[i];
      local[v] = static_cast<VertexId>(i);
      positions.push_back(testing::point(mesh, v));
      std::uint8_t sharing = low[v] == high[v] ? kOwn : high[v] == c ? kSharedLast : kShared;
      // It may say less than is known.
      if (testing::uniform(seed + c, 7 * i) < careless) sharing = kShared;
      chunk.on_interface.push_back(sharing);
    }
    chunk.points = std::move(positions);
    for (const std::uint64_t t : chunk.cell_ids) {
      const Tet& tet = mesh.tets[t];
      chunk.tets.push_back({local[tet[0]], local[tet[1]], local[tet[2]], local[tet[3]]});
    }
  }
  return result;
}

Joined inspect_in_chunks(const Geometry& mesh, std::uint32_t chunks, const ChunkOf& chunk_of,
                         std::uint64_t seed) {
  Joined joined;
  joined.flags.assign(point_count(mesh.points), kUnusedVertex);
  joined.tets.resize(mesh.tets.size());
  InterfaceInspection interface(seed % 3 == 0 ? 1000 : 1);
  for (Chunk& chunk : cut(mesh, chunks, chunk_of, seed)) {
    ChunkFindings findings = inspect_chunk(
        {&chunk.points, chunk.point_ids, chunk.on_interface, chunk.cell_ids}, &chunk.tets);
    for (std::size_t i = 0; i < chunk.point_ids.size(); ++i) {
      joined.flags[chunk.point_ids[i]] = findings.vertex_flags[i];
    }
    for (std::size_t t = 0; t < chunk.tets.size(); ++t) {
      Tet& tet = joined.tets[chunk.cell_ids[t]];
      for (std::size_t k = 0; k < 4; ++k) tet[k] = chunk.point_ids[chunk.tets[t][k]];
    }
    interface.add(&findings);
  }
  joined.verdict = interface.finish();
  const InterfaceVerdict& v = joined.verdict;
  EXPECT_TRUE(std::is_sorted(v.ids.begin(), v.ids.end()));
  EXPECT_EQ(v.ids.size(), v.flags.size());
  for (std::size_t i = 0; i < v.ids.size(); ++i) joined.flags[v.ids[i]] = v.flags[i];
  for (const VertexId id : v.overrides) joined.flags[id] |= kBrokenVertex;
  return joined;
}

// Expects of the chunks what inspect() says; the counts of one are returned.
InterfaceVerdict expect_same(const Geometry& mesh, std::uint32_t chunks, const ChunkOf& chunk_of,
                             std::uint64_t seed) {
  Geometry whole = mesh;
  const Inspection i = inspect(whole);
  const Joined joined = inspect_in_chunks(mesh, chunks, chunk_of, seed);
  const InterfaceVerdict& v = joined.verdict;
  // See InterfaceInspection: cells of an overfull face may count as neighbours.
  const bool sides_are_clear = i.foldover_faces == 0 || i.overfull_faces == 0;
  if (sides_are_clear) {
    EXPECT_EQ(v.rewound, i.rewound);
    EXPECT_EQ(v.inverted, i.inverted);
  }
  EXPECT_EQ(v.rewound + v.inverted >= i.rewound, true);
  EXPECT_EQ(v.degenerate, i.degenerate);
  EXPECT_EQ(v.duplicate_tets, i.duplicate_tets);
  EXPECT_EQ(v.foldover_faces, i.foldover_faces);
  EXPECT_EQ(v.overfull_faces, i.overfull_faces);
  EXPECT_EQ(v.nonmanifold_edges, i.nonmanifold_edges);
  EXPECT_EQ(v.nonmanifold_vertices, i.nonmanifold_vertices);
  EXPECT_EQ(v.boundary_faces, i.boundary_faces);
  EXPECT_EQ(v.boundary_edges, i.boundary_edges);
  EXPECT_EQ(v.boundary_vertices, i.boundary_vertices);
  EXPECT_NEAR(v.volume, i.volume, 1e-12 * (1 + i.volume));
  Vector<std::uint8_t> flags = i.vertex_flags;
  for (std::uint8_t& f : flags) f &= kBoundaryVertex | kBrokenVertex | kUnusedVertex;
  if (sides_are_clear) {
    EXPECT_EQ(joined.flags, flags);
  }
  EXPECT_EQ(joined.tets, whole.tets);
  return joined.verdict;
}

TEST(ChunkInspectionProperty, AnyCutGivesTheVerdictOfTheWhole) {
  InterfaceVerdict all;
  for (std::uint64_t seed = 1; seed <= 600; ++seed) {
    SCOPED_TRACE(seed);
    Geometry mesh = testing::damaged_mesh(seed);
    if (seed % 3 == 0) testing::shuffle(&mesh, seed);
    const auto chunks = 1 + static_cast<std::uint32_t>(20 * testing::uniform(seed, 1));
    const double width = 0.5 + testing::uniform(seed, 2);
    const auto at_random = [&](std::size_t t) {
      return static_cast<std::uint32_t>(testing::uniform(seed, 100 + t) * chunks);
    };
    const auto by_planes = [&](std::size_t t) {
      double x = 0;
      for (const VertexId v : mesh.tets[t]) {
        const auto p = testing::point(mesh, v);
        x += p.x + 0.3 * p.y - 0.2 * p.z;
      }
      return std::min(chunks - 1, static_cast<std::uint32_t>(std::max(0.0, width * x)));
    };
    const auto by_number = [&](std::size_t t) {
      return static_cast<std::uint32_t>(t * chunks / mesh.tets.size());
    };
    for (const ChunkOf& chunk_of : {ChunkOf(at_random), ChunkOf(by_planes), ChunkOf(by_number)}) {
      const InterfaceVerdict v = expect_same(mesh, chunks, chunk_of, seed);
      all.inverted += v.inverted;
      all.duplicate_tets += v.duplicate_tets;
      all.foldover_faces += v.foldover_faces;
      all.overfull_faces += v.overfull_faces;
      all.nonmanifold_edges += v.nonmanifold_edges;
      all.nonmanifold_vertices += v.nonmanifold_vertices;
      all.degenerate += v.degenerate;
      all.overrides.insert(all.overrides.end(), v.overrides.begin(), v.overrides.end());
    }
    if (::testing::Test::HasFailure()) break;
  }
  EXPECT_GT(all.inverted, 1000u);
  EXPECT_GT(all.duplicate_tets, 1000u);
  EXPECT_GT(all.foldover_faces, 1000u);
  EXPECT_GT(all.overfull_faces, 1000u);
  EXPECT_GT(all.nonmanifold_edges, 1000u);
  EXPECT_GT(all.nonmanifold_vertices, 1000u);
  EXPECT_GT(all.degenerate, 1000u);
  EXPECT_GT(all.overrides.size(), 10u);
}

// Each cell a chunk of its own: whatever is wrong lies between chunks.
InterfaceVerdict expect_same_cell_by_cell(const Geometry& mesh) {
  const auto cells = static_cast<std::uint32_t>(mesh.tets.size());
  const auto own_chunk = [](std::size_t t) { return static_cast<std::uint32_t>(t); };
  expect_same(mesh, cells, own_chunk, 0);
  return expect_same(mesh, cells, own_chunk, 2);
}

TEST(ChunkInspection, ASoundMeshCutAnywhereIsSound) {
  for (const Geometry& mesh :
       {testing::single_tet(), testing::icosahedron_ball(), testing::kuhn_box(2, 3, 2, 0.1),
        testing::plate(4), testing::to_float(testing::five_split_cube(3, 0.2))}) {
    const InterfaceVerdict v = expect_same_cell_by_cell(mesh);
    EXPECT_EQ(v.nonmanifold_vertices, 0u);
    EXPECT_EQ(v.foldover_faces, 0u);
    EXPECT_THAT(v.overrides, IsEmpty());
  }
}

TEST(ChunkInspection, AChunkOfItsOwnReportsNothing) {
  Geometry mesh = testing::five_split_cube(4, 0.2);
  testing::flip_winding(&mesh.tets[3]);
  const Vector<VertexId> ids = count_up<VertexId>(point_count(mesh.points));
  const Vector<std::uint8_t> own(ids.size(), kOwn);
  ChunkFindings findings = inspect_chunk({&mesh.points, ids, own, {}}, &mesh.tets);
  EXPECT_EQ(findings.rewound, 1u);
  EXPECT_EQ(findings.boundary_faces, 6u * 16 * 2);
  EXPECT_THAT(findings.interface.points, IsEmpty());
  EXPECT_THAT(findings.interface.sides, IsEmpty());
  EXPECT_THAT(findings.interface.clusters, IsEmpty());
  EXPECT_THAT(findings.interface.members, IsEmpty());
  InterfaceInspection interface;
  interface.add(&findings);
  const InterfaceVerdict v = interface.finish();
  EXPECT_THAT(v.ids, IsEmpty());
  EXPECT_EQ(v.rewound, 1u);
  EXPECT_EQ(v.boundary_faces, 6u * 16 * 2);
  EXPECT_EQ(v.boundary_vertices, 5u * 5 * 5 - 3 * 3 * 3);
  EXPECT_NEAR(v.volume, 64, 1e-9);
}

TEST(ChunkInspection, NothingAtAll) {
  Points none = Vector<Vec3<float>>();
  Vector<Tet> tets;
  ChunkFindings findings = inspect_chunk({&none, {}, {}, {}}, &tets);
  InterfaceInspection interface;
  interface.add(&findings);
  EXPECT_EQ(interface.finish().boundary_faces, 0u);
  EXPECT_THAT(InterfaceInspection().finish().ids, IsEmpty());
}

TEST(ChunkInspection, AFoldBetweenChunksBreaksFreeVerticesToo) {
  Geometry mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 2}},
                            {{0, 1, 2, 3}, {0, 2, 1, 4}});
  const InterfaceVerdict v = expect_same_cell_by_cell(mesh);
  EXPECT_EQ(v.foldover_faces, 1u);
  EXPECT_EQ(v.inverted, 1u);
  EXPECT_EQ(v.rewound, 0u);
  EXPECT_THAT(v.ids, ElementsAre(0, 1, 2));
  EXPECT_THAT(v.overrides, ElementsAre(3, 4));
}

TEST(ChunkInspection, ThePartOfFewerCellsIsInvertedAcrossChunks) {
  // A vertex pushed out of its ball: the cells that it pulls through the others are inverted.
  Geometry mesh = testing::icosahedron_ball();
  std::get<Vector<Vec3<double>>>(mesh.points)[0] = {0, 0, 10};
  for (const std::uint32_t chunks : {1u, 2u, 3u, 7u}) {
    const InterfaceVerdict v = expect_same(
        mesh, chunks, [&](std::size_t t) { return static_cast<std::uint32_t>(t % chunks); },
        chunks);
    EXPECT_GT(v.inverted, 0u);
    EXPECT_LT(v.inverted, 10u);
  }
}

TEST(ChunkInspection, DuplicatesInTwoChunks) {
  Geometry mesh = testing::two_tets_sharing_face();
  mesh.tets.push_back({3, 0, 2, 1});  // cell 0 again, wound otherwise
  mesh.tets.push_back({0, 1, 2, 3});
  const InterfaceVerdict v = expect_same_cell_by_cell(mesh);
  EXPECT_EQ(v.duplicate_tets, 2u);
  EXPECT_EQ(v.overfull_faces, 4u);
  EXPECT_EQ(v.foldover_faces, 0u);
}

TEST(ChunkInspection, AFlatCellAndItsCopyFitTogetherAndAreDuplicates) {
  Geometry mesh =
      make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 2, 3}, {0, 2, 1, 3}});
  const InterfaceVerdict v = expect_same_cell_by_cell(mesh);
  EXPECT_EQ(v.degenerate, 2u);
  EXPECT_EQ(v.duplicate_tets, 1u);
  EXPECT_EQ(v.boundary_faces, 0u);
  EXPECT_EQ(expect_same(
                mesh, 1, [](std::size_t) { return 0u; }, 3)
                .duplicate_tets,
            1u);
}

// Vertex 0, with 20 cells each; the second ball is twice as large.
Geometry two_balls_round_one_vertex() {
  Geometry mesh = testing::icosahedron_ball();
  auto& points = std::get<Vector<Vec3<double>>>(mesh.points);
  for (VertexId v = 1; v <= 12; ++v) {
    points.push_back({2 * points[v].x, 2 * points[v].y, 2 * points[v].z});
  }
  const Vector<Tet> first = mesh.tets;
  for (const Tet& t : first) mesh.tets.push_back({t[0], t[1] + 12, t[2] + 12, t[3] + 12});
  return mesh;
}

TEST(ChunkInspection, AnUnsoundBallDoesNotCountWhereAFoldBreaksTheVertexAnyway) {
  // Both balls are in one chunk; vertex 0 is also the apex of a cell that another
  // chunk's cell is folded over.
  Geometry mesh = two_balls_round_one_vertex();
  auto& points = std::get<Vector<Vec3<double>>>(mesh.points);
  Tet folded = mesh.tets[0];
  points.push_back({0.1, 0.1, 0.1});
  folded[0] = static_cast<VertexId>(points.size() - 1);
  mesh.tets.push_back(folded);
  const InterfaceVerdict v = expect_same(
      mesh, 2, [](std::size_t t) { return t < 40 ? 0u : 1u; }, 3);
  EXPECT_EQ(v.foldover_faces, 1u);
  EXPECT_EQ(v.nonmanifold_vertices, 0u);
  EXPECT_THAT(v.overrides, ElementsAre(0, 25));
}

TEST(ChunkInspection, WithoutIdsCellsCountThroughTheChunks) {
  // Two cells in each chunk, folded over each other at the face 0, 1, 2: nothing but the first cell
  // says which two are inverted, and vertex 6 is broken only if its cell is.
  const Geometry mesh = make_mesh(
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, 1}, {0.2, 0.2, 2}, {-1, 0.2, 1}, {-1, 0.2, 2}},
      {{0, 1, 2, 3}, {0, 2, 5, 3}, {0, 1, 2, 4}, {0, 2, 6, 4}});
  InterfaceInspection interface;
  for (Chunk& chunk : cut(
           mesh, 2, [](std::size_t t) { return t < 2 ? 0u : 1u; }, 3)) {
    ChunkFindings findings = inspect_chunk(
        {&chunk.points, chunk.point_ids, chunk.on_interface, {}}, &chunk.tets);
    interface.add(&findings);
  }
  const InterfaceVerdict v = interface.finish();
  EXPECT_EQ(v.foldover_faces, 1u);
  EXPECT_EQ(v.inverted, 2u);
  EXPECT_THAT(v.overrides, ElementsAre(3, 4, 6));
}

TEST(ChunkInspection, ThreeCellsAtOneFaceInThreeChunks) {
  Geometry mesh = testing::two_tets_sharing_face();
  std::get<Vector<Vec3<double>>>(mesh.points).push_back({0.25, 0.25, 3});
  mesh.tets.push_back({0, 1, 2, 5});
  const InterfaceVerdict v = expect_same_cell_by_cell(mesh);
  EXPECT_EQ(v.overfull_faces, 1u);
  EXPECT_EQ(v.foldover_faces, 0u);
  // Two of them in one chunk fit together.
  expect_same(
      mesh, 2, [](std::size_t t) { return t == 2 ? 1u : 0u; }, 1);
}

TEST(ChunkInspection, CellsThatShareOnlyAnEdgeOrAVertexAcrossChunks) {
  InterfaceVerdict v = expect_same_cell_by_cell(testing::two_tets_sharing_edge());
  EXPECT_EQ(v.nonmanifold_edges, 1u);
  EXPECT_EQ(v.nonmanifold_vertices, 2u);
  v = expect_same_cell_by_cell(testing::two_tets_sharing_vertex());
  EXPECT_EQ(v.nonmanifold_edges, 0u);
  EXPECT_EQ(v.nonmanifold_vertices, 1u);
}

TEST(ChunkInspection, TwoBallsRoundOneVertexInTwoChunks) {
  const InterfaceVerdict v = expect_same(
      two_balls_round_one_vertex(), 2, [](std::size_t t) { return t < 20 ? 0u : 1u; }, 3);
  EXPECT_EQ(v.nonmanifold_vertices, 1u);
  EXPECT_THAT(v.ids, ElementsAre(0));
  EXPECT_THAT(v.flags, ElementsAre(kBrokenVertex));
}

TEST(ChunkInspection, TwoRingsRoundOneEdgeInTwoChunks) {
  // Each chunk has a whole ring of cells round the edge from 0 to 1: no face lies between them.
  Geometry mesh = make_mesh({{0, 0, -1}, {0, 0, 1}}, {});
  auto& points = std::get<Vector<Vec3<double>>>(mesh.points);
  for (const VertexId first : {2u, 5u}) {
    points.insert(points.end(), {{1, 0, 0}, {-1, 1, 0}, {-1, -1, 0}});
    for (VertexId k = 0; k < 3; ++k) {
      mesh.tets.push_back({0, first + k, first + (k + 1) % 3, 1});
    }
  }
  const InterfaceVerdict v = expect_same(
      mesh, 2, [](std::size_t t) { return t < 3 ? 0u : 1u; }, 3);
  EXPECT_EQ(v.nonmanifold_edges, 0u);
  EXPECT_EQ(v.nonmanifold_vertices, 2u);
}

TEST(ChunkInspection, OnlyTheBorderOfALargeInvertedClusterIsBroken) {
  // Two boxes folded over each other at one face of a cell, the smaller one too large to be broken
  // as a whole.
  Geometry mesh = testing::five_split_box(12, 10, 10);
  const Geometry small = testing::five_split_box(12, 9, 9);
  ASSERT_GT(small.tets.size(), kMaxBrokenCluster);
  auto& points = std::get<Vector<Vec3<double>>>(mesh.points);
  const auto shift = static_cast<VertexId>(points.size());
  // The face at the corner x = y = z = 0, in the plane x = 0.
  const auto find = [](const Geometry& in, double y, double z) {
    const auto& p = std::get<Vector<Vec3<double>>>(in.points);
    const auto at = std::find_if(p.begin(), p.end(),
                                 [&](const auto& q) { return q.x == 0 && q.y == y && q.z == z; });
    return static_cast<VertexId>(at - p.begin());
  };
  for (VertexId v = 0; v < point_count(small.points); ++v) {
    points.push_back(testing::point(small, v));
  }
  const auto joined = [&](VertexId v) {
    for (const auto& [y, z] : {std::pair(0.0, 0.0), std::pair(1.0, 1.0), std::pair(1.0, 0.0)}) {
      if (v == find(small, y, z)) return find(mesh, y, z);
    }
    return v + shift;
  };
  Vector<VertexId> new_id;
  for (VertexId v = 0; v < point_count(small.points); ++v) new_id.push_back(joined(v));
  for (const Tet& t : small.tets) {
    mesh.tets.push_back({new_id[t[0]], new_id[t[1]], new_id[t[2]], new_id[t[3]]});
  }
  for (const std::uint32_t chunks : {1u, 2u, 5u}) {
    const InterfaceVerdict v = expect_same(
        mesh, chunks,
        [&](std::size_t t) { return static_cast<std::uint32_t>(t * chunks / mesh.tets.size()); },
        3);
    EXPECT_EQ(v.foldover_faces, 1u);
    EXPECT_EQ(v.inverted, small.tets.size());
    Geometry whole = mesh;
    const Inspection i = inspect(whole);
    EXPECT_LT(std::count_if(i.vertex_flags.begin(), i.vertex_flags.end(),
                            [](std::uint8_t f) { return (f & kBrokenVertex) != 0; }),
              10);
  }
}

// Where the two may differ: see InterfaceInspection.
TEST(ChunkInspection, CellsOfAnOverfullFaceMayCountAsNeighbours) {
  // Cells 0 and 1 fit together at the face 0, 1, 2; cell 2 makes it overfull. Cell 3 is folded over
  // cell 1, which is wound the other way. For inspect() that is one cell against one, and the one
  // that had to be rewound is inverted. A chunk that has 0 and 1 counts two cells against one.
  const Geometry mesh = make_mesh(
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}, {0.2, 0.2, 3}, {0.1, 0.1, 5}},
      {{0, 2, 1, 3}, {0, 1, 4, 2}, {0, 1, 2, 5}, {0, 4, 1, 6}});
  Geometry whole = mesh;
  const Inspection i = inspect(whole);
  ASSERT_EQ(i.foldover_faces, 1u);
  ASSERT_EQ(i.overfull_faces, 1u);
  EXPECT_EQ(i.inverted, 1u);
  EXPECT_EQ(i.rewound, 0u);
  const auto halves = [](std::size_t t) { return t < 2 ? 0u : 1u; };
  const InterfaceVerdict v = inspect_in_chunks(mesh, 2, halves, 3).verdict;
  EXPECT_EQ(v.foldover_faces, 1u);
  EXPECT_EQ(v.overfull_faces, 1u);
  EXPECT_EQ(v.inverted, 1u);
  EXPECT_EQ(v.rewound, 1u);
}

TEST(ChunkInspection, WhatIsSettledIsNotHeld) {
  // A long box cut across: no more is held than lies at one cut.
  const std::uint32_t chunks = 40;
  const Geometry mesh = testing::five_split_box(chunks, 4, 4);
  const auto slab = [&](std::size_t t) { return static_cast<std::uint32_t>(t / 5 % chunks); };
  InterfaceInspection interface(1);
  std::size_t most = 0;
  for (Chunk& chunk : cut(mesh, chunks, slab, 3)) {
    ChunkFindings findings = inspect_chunk(
        {&chunk.points, chunk.point_ids, chunk.on_interface, {}}, &chunk.tets);
    interface.add(&findings);
    most = std::max(most, interface.pending());
  }
  EXPECT_LT(most, 250u);
  EXPECT_EQ(interface.finish().boundary_faces, 2u * 2 * (16 + 2 * 4 * chunks));
}

TEST(ChunkInspection, APointMustNotComeBack) {
  Geometry mesh = testing::single_tet();
  const Vector<VertexId> ids = count_up<VertexId>(4);
  const Vector<std::uint8_t> last(4, kSharedLast);
  InterfaceInspection interface;
  ChunkFindings once = inspect_chunk({&mesh.points, ids, last, {}}, &mesh.tets);
  ChunkFindings twice = once;
  interface.add(&once);
  EXPECT_THROW(interface.add(&twice), std::logic_error);
}

}  // namespace
}  // namespace tetfusion
