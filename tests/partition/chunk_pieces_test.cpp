#include "partition/chunk_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "support/cut_meshes.h"
#include "support/interface_tables.h"
#include "support/lossy_store.h"
#include "support/meshes.h"
#include "support/temp_dir.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

using testing::contents;
using testing::CutMesh;
using testing::gather_all;
using testing::layout_of;
using testing::make_column;

// A mesh with two steering values a vertex and columns of odd sizes.
template <class Real>
WorkMesh<Real> rich(WorkMesh<Real> mesh) {
  mesh.steering_width = 2;
  mesh.resize_vertices(mesh.vertex_count());
  Vector<std::uint8_t> bytes;
  Vector<double> numbers;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const double x = testing::uniform(2, v);
    mesh.steering[2 * v] = x;
    mesh.steering[2 * v + 1] = -3 * x;
    numbers.push_back(5 * x);
    const auto byte = static_cast<std::uint8_t>(v * 31);
    bytes.insert(bytes.end(), {byte, static_cast<std::uint8_t>(byte + 1), 7});
    if (v % 41 == 5) mesh.marks[v] |= kLocked;
  }
  mesh.point_columns = {make_column(3, bytes), make_column(1, numbers)};
  Vector<std::int16_t> pairs;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    pairs.push_back(static_cast<std::int16_t>(t));
    pairs.push_back(static_cast<std::int16_t>(-3 * static_cast<int>(t)));
  }
  mesh.cell_columns = {make_column(2, pairs)};
  testing::number_tets(&mesh);
  return mesh;
}

// With removed points in some tetrahedra, many in a few.
template <class Real>
WorkMesh<Real> with_removed_points(WorkMesh<Real> mesh) {
  mesh.removed.reset(mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (std::size_t i = 0; i < (t % 29 == 3 ? 7 : t % 3); ++i) {
      const std::uint32_t point = mesh.removed.add(1, mesh.steering_width);
      mesh.removed.positions[point] = {static_cast<Real>(t), static_cast<Real>(i), Real{-1}};
      for (std::uint32_t k = 0; k < mesh.steering_width; ++k) {
        mesh.removed.values[point * mesh.steering_width + k] = 0.1 * static_cast<double>(t * i + k);
      }
      mesh.removed.push(static_cast<std::uint32_t>(t), point);
    }
  }
  for (std::size_t v = 0; v < mesh.vertex_count(); v += 3) mesh.marks[v] |= kMoved;
  return mesh;
}

std::unique_ptr<Scratch> disk_scratch_in(const testing::TempDir& folder) {
  return disk_scratch({folder.file("scratch"), "a test", false, 0});
}

// Cuts the mesh again and again, each time elsewhere and into another number of chunks; nothing is
// lost and nothing is made up.
template <class Real>
void expect_identity(const WorkMesh<Real>& mesh, Scratch* scratch) {
  const std::vector<std::string> expected = contents(mesh);
  std::vector<WorkMesh<Real>> chunks{mesh};
  std::uint32_t round = 0;
  for (const std::uint32_t count : {1, 2, 64, 3, 16, 16, 7, 1}) {
    const CurveCut cut = testing::cut_evenly(mesh, count, round);
    const CutMesh next = testing::cut_anew(chunks, cut, scratch, "round-" + std::to_string(round));
    ASSERT_EQ(next.chunks, count);
    std::vector<WorkMesh<Real>> gathered = gather_all(next, layout_of(mesh));
    EXPECT_EQ(contents(testing::join(gathered)), expected);
    testing::expect_chunks_know_their_vertices(gathered);
    for (std::uint32_t c = 0; c < count; ++c) {
      for (const Tet& t : gathered[c].tets) {
        std::uint32_t lowest = count;
        for (const VertexId v : t) {
          lowest = std::min(lowest, cut.chunk_of(gathered[c].positions[v]));
        }
        EXPECT_EQ(lowest, c);
      }
    }
    chunks = std::move(gathered);
    ++round;
  }
}

TEST(ChunkPieces, CutAndStitchIsTheIdentityInMemory) {
  expect_identity(rich(testing::to_work_mesh(testing::five_split_cube(9, 0.2, 3))),
                  memory_scratch().get());
  expect_identity(rich(testing::to_float_work_mesh(testing::kuhn_box(13, 5, 4, 0.1, 2))),
                  memory_scratch().get());
}

TEST(ChunkPieces, CutAndStitchIsTheIdentityOnDisk) {
  const testing::TempDir folder = testing::TempDir::in_memory();
  expect_identity(rich(testing::to_work_mesh(testing::five_split_cube(7, 0.2, 4))),
                  disk_scratch_in(folder).get());
}

TEST(ChunkPieces, RemovedPointsGoWithTheirTetrahedra) {
  expect_identity(
      with_removed_points(rich(testing::to_work_mesh(testing::five_split_cube(7, 0.2, 3)))),
      memory_scratch().get());
  const testing::TempDir folder = testing::TempDir::in_memory();
  expect_identity(
      with_removed_points(rich(testing::to_float_work_mesh(testing::five_split_cube(6, 0.2, 4)))),
      disk_scratch_in(folder).get());
}

// Whatever else is in the chunk, those of a tetrahedron keep their order.
TEST(ChunkPieces, RemovedPointsKeepTheirOrder) {
  const auto mesh =
      with_removed_points(rich(testing::to_work_mesh(testing::five_split_cube(5, 0.2, 3))));
  const auto scratch = memory_scratch();
  const auto chunks = gather_all(testing::cut_up(mesh, 5, 1, scratch.get()), layout_of(mesh));
  std::size_t seen = 0;
  for (const auto& chunk : chunks) {
    for (std::size_t t = 0; t < chunk.tets.size(); ++t) {
      double last = 99;
      for (std::uint32_t i = chunk.removed.first[t]; i != kNoPoint; i = chunk.removed.next[i]) {
        EXPECT_LT(chunk.removed.positions[i].y, last);
        last = chunk.removed.positions[i].y;
        ++seen;
      }
    }
  }
  EXPECT_EQ(seen, mesh.removed.size());
}

TEST(ChunkPieces, TakesMeshesWithoutColumns) {
  expect_identity(testing::to_work_mesh(testing::five_split_cube(4, 0.1)), memory_scratch().get());
  expect_identity(testing::to_work_mesh(testing::plate(6)), memory_scratch().get());
}

// More chunks than tetrahedra: some get nothing.
TEST(ChunkPieces, ChunksMayBeEmpty) {
  const auto mesh = testing::to_work_mesh(testing::two_tets_sharing_face());
  const auto scratch = memory_scratch();
  const CutMesh cut = testing::cut_up(mesh, 9, 1, scratch.get());
  const auto chunks = gather_all(cut, layout_of(mesh));
  EXPECT_EQ(contents(testing::join(chunks)), contents(mesh));
  EXPECT_GE(std::ranges::count_if(chunks, [](const auto& c) { return c.tets.empty(); }), 7);
  const CutMesh again = testing::cut_anew(chunks, CurveCut(), scratch.get(), "again");
  EXPECT_EQ(contents(gather_all(again, layout_of(mesh))[0]), contents(mesh));
}

// A chunk may hold a vertex that lost its tetrahedra (a locked one stays): it goes nowhere.
TEST(ChunkPieces, VerticesWithoutTetrahedraAreLeftOut) {
  auto mesh = testing::to_work_mesh(testing::five_split_cube(3));
  const std::size_t before = mesh.vertex_count();
  mesh.resize_vertices(before + 2);
  for (std::size_t v = before; v < before + 2; ++v) {
    mesh.positions[v] = {1, 1, 1};
    mesh.point_ids[v] = static_cast<VertexId>(v);
    mesh.marks[v] = v == before ? kLocked : kLocked | kOnInterface;
    mesh.incidence[v] = mesh.changed[v] = 0;
  }
  const auto scratch = memory_scratch();
  const CutMesh cut = testing::cut_up(mesh, 4, 1, scratch.get());
  EXPECT_EQ(cut.interface.find(static_cast<VertexId>(before + 1)), nullptr);
  EXPECT_EQ(testing::join(gather_all(cut, layout_of(mesh))).vertex_count(), before);
}

// What other chunks have found out about a vertex on the interface.
TEST(ChunkPieces, MarksOfTheTableReachEveryChunk) {
  const auto mesh = testing::to_work_mesh(testing::five_split_cube(6));
  const auto scratch = memory_scratch();
  const auto chunks = gather_all(testing::cut_up(mesh, 5, 0, scratch.get()), layout_of(mesh));
  CutMesh kept{5, scratch->begin("kept"), {}};
  Vector<InterfaceReport> reports;
  ChunkScatter<double> scatter;
  const auto homes = testing::chunks_by_id(chunks);
  for (std::uint32_t c = 0; c < 5; ++c) {
    scatter.keep(chunks[c], c, kept.pieces.get());
    for (std::size_t v = 0; v < chunks[c].vertex_count(); ++v) {
      const VertexId id = chunks[c].point_ids[v];
      if (homes.at(id).size() == 1) continue;
      const bool locks = *homes.at(id).begin() == c && id % 2 == 0;
      reports.push_back({id, c, c, locks ? std::uint8_t{kLocked} : std::uint8_t{0}, false});
    }
  }
  kept.pieces->seal();
  kept.interface = testing::table_of(reports);
  const auto again = gather_all(kept, layout_of(mesh));
  testing::expect_chunks_know_their_vertices(again);
  for (std::size_t c = 0; c < 5; ++c) {
    EXPECT_EQ(again[c].tets.size(), chunks[c].tets.size());
    for (std::size_t v = 0; v < again[c].vertex_count(); ++v) {
      const VertexId id = again[c].point_ids[v];
      const bool locked = homes.at(id).size() > 1 && id % 2 == 0;
      EXPECT_EQ((again[c].marks[v] & kLocked) != 0, locked);
      EXPECT_EQ(again[c].marks[v] & kOnBoundary, mesh.marks[id] & kOnBoundary);
    }
  }
}

// A tetrahedron stays settled if it was refused as a flip and no chunk has changed a ball of its
// vertices since.
TEST(ChunkPieces, SettledTetrahedraAreThoseThatNobodyTouched) {
  auto mesh = testing::to_work_mesh(testing::five_split_cube(8, 0.2));
  testing::number_tets(&mesh);
  const auto scratch = memory_scratch();
  auto chunks = gather_all(testing::cut_up(mesh, 6, 0, scratch.get()), layout_of(mesh));
  std::set<VertexId> touched_between;
  std::set<TetId> settled;
  const auto pick = [](std::uint64_t seed, std::uint64_t i, double below) {
    return static_cast<std::uint16_t>(below * testing::uniform(seed, i));
  };
  for (auto& chunk : chunks) {
    for (std::size_t v = 0; v < chunk.vertex_count(); ++v) {
      const std::uint64_t place = std::uint64_t{chunk.point_ids[v]} * 64 + (&chunk - &chunks[0]);
      // 1 says that an earlier round has touched it.
      chunk.changed[v] = pick(1, place, 1.5) == 0 ? 0 : pick(2, place, 6);
      if (chunk.changed[v] >= kFirstPassNumber && (chunk.marks[v] & kOnInterface) != 0) {
        touched_between.insert(chunk.point_ids[v]);
      }
    }
    for (std::size_t t = 0; t < chunk.tets.size(); ++t) chunk.remembered[t] = pick(3, t, 7);
  }
  for (const auto& chunk : chunks) {
    const auto numbers = testing::tet_numbers(chunk);
    for (std::size_t t = 0; t < chunk.tets.size(); ++t) {
      const bool same = std::ranges::all_of(chunk.tets[t], [&](VertexId v) {
        return chunk.changed[v] < chunk.remembered[t] &&
               !touched_between.contains(chunk.point_ids[v]);
      });
      if (same) settled.insert(numbers[t]);
    }
  }
  const auto next =
      gather_all(testing::cut_anew(chunks, testing::cut_evenly(mesh, 5, 3), scratch.get(), "next"),
                 layout_of(mesh));
  std::set<TetId> remembered;
  for (const auto& chunk : next) {
    const auto numbers = testing::tet_numbers(chunk);
    for (std::size_t t = 0; t < chunk.tets.size(); ++t) {
      EXPECT_LT(chunk.remembered[t], kFirstPassNumber);
      const bool same = std::ranges::all_of(
          chunk.tets[t], [&](VertexId v) { return chunk.changed[v] < chunk.remembered[t]; });
      if (same) remembered.insert(numbers[t]);
    }
  }
  EXPECT_EQ(remembered, settled);
  EXPECT_GT(settled.size(), 20u);
  EXPECT_LT(settled.size(), mesh.tets.size() / 2);
}

// Of fuse, which wants quadrics, what is remembered are grades.
TEST(ChunkPieces, GradesStayWithTheirTetrahedra) {
  auto mesh = testing::to_work_mesh(testing::five_split_cube(8, 0.2));
  testing::number_tets(&mesh);
  mesh.quadric_width = 1;
  mesh.quadrics.assign(mesh.vertex_count(), 0);
  const auto grade_of = [](TetId number) { return static_cast<std::uint16_t>(number % 256); };
  const auto scratch = memory_scratch();
  auto chunks = gather_all(testing::cut_up(mesh, 6, 0, scratch.get()), layout_of(mesh));
  for (auto& chunk : chunks) {
    const auto numbers = testing::tet_numbers(chunk);
    for (std::size_t t = 0; t < chunk.tets.size(); ++t) chunk.remembered[t] = grade_of(numbers[t]);
  }
  std::size_t count = 0;
  for (const auto& chunk :
       gather_all(testing::cut_anew(chunks, testing::cut_evenly(mesh, 5, 3), scratch.get(), "next"),
                  layout_of(mesh))) {
    const auto numbers = testing::tet_numbers(chunk);
    count += numbers.size();
    for (std::size_t t = 0; t < chunk.tets.size(); ++t) {
      ASSERT_EQ(chunk.remembered[t], grade_of(numbers[t]));
    }
  }
  EXPECT_EQ(count, mesh.tets.size());
}

TEST(ChunkPieces, RefuseAnotherLayoutAndAnotherTable) {
  const auto mesh = rich(testing::to_work_mesh(testing::five_split_cube(4)));
  const auto scratch = memory_scratch();
  CutMesh cut = testing::cut_up(mesh, 3, 0, scratch.get());
  auto layout = layout_of(mesh);
  layout.point_columns.pop_back();
  EXPECT_THROW(gather_all(cut, layout), std::logic_error);
  layout = layout_of(mesh);
  layout.steering_width = 3;
  EXPECT_THROW(gather_all(cut, layout), std::logic_error);

  const auto chunks = gather_all(cut, layout_of(mesh));
  cut = testing::cut_anew(chunks, testing::cut_evenly(mesh, 3, 1), scratch.get(), "next");
  cut.interface = {};
  EXPECT_THROW(gather_all(cut, layout_of(mesh)), std::logic_error);
}

// Whatever the zeros are taken for, what is reported is that they are none.
TEST(ChunkPieces, BytesThatAreLostMeanwhileAreReported) {
  const auto mesh = with_removed_points(rich(testing::to_work_mesh(testing::five_split_cube(4))));
  const auto scratch = memory_scratch();
  const CutMesh first = testing::cut_up(mesh, 3, 0, scratch.get());
  const CutMesh cut = testing::cut_anew(gather_all(first, layout_of(mesh)),
                                        testing::cut_evenly(mesh, 3, 1), scratch.get(), "next");
  std::size_t longest = 0;
  for (std::uint32_t c = 0; c < 3; ++c) longest = std::max(longest, cut.pieces->bytes(c));
  ChunkGather<double> gather;
  for (const std::size_t count : {std::size_t{64}, longest}) {
    for (std::size_t at = 0; at < longest; at += 64) {
      const testing::LossyStore store(*cut.pieces, at, count);
      for (std::uint32_t c = 0; c < 3; ++c) {
        WorkMesh<double> chunk = layout_of(mesh);
        try {
          gather.gather(c, store, cut.interface, &chunk);
          FAIL() << at;
        } catch (const Error& error) {
          EXPECT_EQ(error.code(), ErrorCode::kIo);
        }
      }
    }
  }
}

}  // namespace
}  // namespace tetfusion
