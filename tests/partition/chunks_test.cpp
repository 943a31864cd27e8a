#include "partition/chunks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <vector>

#include "base/resources.h"
#include "partition/curve_cut.h"
#include "support/meshes.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

WorkMesh<double> box(std::uint32_t n) {
  WorkMesh<double> mesh = testing::to_work_mesh(testing::five_split_cube(n, 0.2, 3));
  testing::steer_by([](double x, double y, double z) { return x + 10 * y + 100 * z; }, &mesh);
  return mesh;
}

// A mesh as a set of tetrahedra, whatever its order: each one's first id, corners, and what is
// remembered of it.
using Corner = std::array<double, 5>;  // x, y, z, steering, first point id
std::map<TetId, std::array<Corner, 4>> contents(const WorkMesh<double>& mesh) {
  std::map<TetId, std::array<Corner, 4>> out;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (std::size_t c = 0; c < 4; ++c) {
      const VertexId v = mesh.tets[t][c];
      const auto& p = mesh.positions[v];
      out[mesh.tet_ids[t]][c] = {p.x, p.y, p.z, mesh.steering[v],
                                 static_cast<double>(mesh.point_ids[v])};
    }
  }
  return out;
}

TEST(CutCurve, ChunksAreBalancedAndMove) {
  const WorkMesh<double> mesh = box(20);
  std::set<Vector<std::uint32_t>> cuts;
  for (std::uint32_t round = 1; round <= 5; ++round) {
    const CurveCut cut = cut_curve(mesh.positions, mesh.tets, 2500, round);
    EXPECT_EQ(cut.chunks, 16u);
    std::vector<std::uint64_t> sizes(cut.chunks, 0);
    for (const Tet& t : mesh.tets) ++sizes.at(cut.chunk_of(t));
    for (const std::uint64_t s : sizes) {
      EXPECT_GT(s, 2500u * 3 / 4);
      EXPECT_LT(s, 2500u * 5 / 4);
    }
    cuts.insert(cut.chunk_of_vertex);
  }
  EXPECT_EQ(cuts.size(), 5u);
}

TEST(CutCurve, TakesPointsThatAreAllTheSame) {
  const Vector<Vec3<float>> points(8, Vec3<float>{1, 1, 1});
  const Vector<Tet> tets{{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 6, 7}};
  const CurveCut cut = cut_curve(points, tets, 1, 1);
  for (const Tet& t : tets) EXPECT_LT(cut.chunk_of(t), cut.chunks);
}

TEST(CutIntoChunks, DoesNotDependOnThreads) {
  const WorkMesh<double> mesh = box(30);
  set_thread_count(1);
  const Chunking one = cut_into_chunks(mesh, 20000, 1);
  set_thread_count(3);
  const Chunking three = cut_into_chunks(mesh, 20000, 1);
  set_thread_count(0);
  EXPECT_EQ(one.tets, three.tets);
  EXPECT_EQ(one.begins, three.begins);
}

// The complete-ball rule, by a look at all tetrahedra.
TEST(ChunkCutter, AVertexIsFreeWhenItsWholeBallIsInTheChunk) {
  WorkMesh<double> mesh = box(8);
  const Chunking chunking = cut_into_chunks(mesh, 300, 2);
  ASSERT_GT(chunking.chunks(), 5u);
  std::vector<std::set<std::size_t>> chunks_of(mesh.vertex_count());
  for (std::size_t c = 0; c < chunking.chunks(); ++c) {
    for (std::uint64_t i = chunking.begins[c]; i < chunking.begins[c + 1]; ++i) {
      for (const VertexId v : mesh.tets[chunking.tets[i]]) chunks_of[v].insert(c);
    }
  }
  ChunkCutter<double> cutter;
  std::size_t free_vertices = 0;
  for (std::size_t c = 0; c < chunking.chunks(); ++c) {
    const WorkMesh<double> chunk = cutter.take(mesh, chunking, c);
    EXPECT_EQ(chunk.tets.size(), chunking.begins[c + 1] - chunking.begins[c]);
    for (std::size_t v = 0; v < chunk.vertex_count(); ++v) {
      const bool is_free = (chunk.marks[v] & kOnInterface) == 0;
      EXPECT_EQ(is_free, chunks_of[chunk.point_ids[v]].size() == 1);
      free_vertices += is_free ? 1u : 0u;
    }
  }
  EXPECT_GT(free_vertices, 0u);
  EXPECT_LT(free_vertices, mesh.vertex_count());
}

TEST(Chunks, CutAndJoinIsTheIdentity) {
  const WorkMesh<double> before = box(9);
  for (const std::uint64_t chunks : {1, 2, 3, 7, 16, 64}) {
    for (std::uint32_t round = 1; round <= 3; ++round) {
      WorkMesh<double> mesh = before;
      const Chunking chunking =
          cut_into_chunks(mesh, (mesh.tets.size() + chunks - 1) / chunks, round);
      EXPECT_EQ(chunking.chunks(), chunks);
      std::vector<ChunkRemains> remains;
      ChunkCutter<double> cutter;
      for (std::size_t c = 0; c < chunking.chunks(); ++c) {
        remains.push_back(put_back(cutter.take(mesh, chunking, c), &mesh));
      }
      join_chunks(std::move(remains), &mesh);
      EXPECT_EQ(contents(mesh), contents(before));
      EXPECT_EQ(mesh.incidence, before.incidence);
      EXPECT_EQ(mesh.marks, before.marks);
    }
  }
}

}  // namespace
}  // namespace tetfusion
