// Chunks whose pieces lose bytes while they are read.
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <memory>

#include "base/error.h"
#include "driver/import/chunk_loader.h"
#include "driver/rounds/original_rows.h"
#include "io/store/scratch.h"
#include "support/lossy_store.h"
#include "support/meshes.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

std::unique_ptr<PieceStore> store_of(Scratch* scratch, const char* name, std::uint64_t rows,
                                     const std::function<void(RowWriter*)>& write) {
  auto store = scratch->begin(name);
  Vector<std::byte> piece(sizeof rows);
  std::memcpy(piece.data(), &rows, sizeof rows);
  RowWriter writer(&piece);
  write(&writer);
  const PieceRef ref{0, piece};
  store->add(0, {&ref, 1});
  store->seal();
  return store;
}

Vector<std::uint32_t> all_of(std::size_t count) {
  Vector<std::uint32_t> all(count);
  for (std::uint32_t i = 0; i < count; ++i) all[i] = i;
  return all;
}

// One chunk, as it is scattered for an import.
struct Scattered {
  explicit Scattered(const WorkMesh<double>& mesh) {
    const auto vertices = all_of(mesh.vertex_count()), cells = all_of(mesh.tets.size());
    points = store_of(scratch.get(), "points", vertices.size(), [&](RowWriter* to) {
      to->put<VertexId>(vertices, [](std::uint32_t v) { return v; });
      to->put<std::uint8_t>(vertices, [](std::uint32_t) { return std::uint8_t{0}; });
      to->put<Vec3<double>>(vertices, [&](std::uint32_t v) { return mesh.positions[v]; });
    });
    tets = store_of(scratch.get(), "tets", cells.size(), [&](RowWriter* to) {
      to->put<Tet>(cells, [&](std::uint32_t t) { return mesh.tets[t]; });
    });
  }
  std::unique_ptr<Scratch> scratch = memory_scratch();
  std::unique_ptr<PieceStore> points, tets;
};

void expect_lost(const std::function<void()>& use) {
  try {
    use();
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kIo);
  }
}

TEST(LostBytes, OfAChunkThatIsImportedAreReported) {
  const WorkMesh<double> mesh = testing::to_work_mesh(testing::five_split_cube(3));
  const Scattered chunk(mesh);
  Box box;
  for (const auto& p : mesh.positions) box.add(p);
  ChunkLoader<double> loader({}, box);
  WorkMesh<double> out;
  loader.load(0, *chunk.tets, *chunk.points, &out);
  EXPECT_EQ(out.tets.size(), mesh.tets.size());
  for (const std::size_t count : {8, 1 << 20}) {
    for (std::size_t at = 0; at < chunk.points->bytes(0); at += 8) {
      testing::LossyStore lossy(*chunk.points, at, count);
      expect_lost([&] { loader.load(0, *chunk.tets, lossy, &out); });
    }
    for (std::size_t at = 0; at < chunk.tets->bytes(0); at += 8) {
      testing::LossyStore lossy(*chunk.tets, at, count);
      expect_lost([&] { loader.load(0, lossy, *chunk.points, &out); });
    }
  }
}

}  // namespace
}  // namespace tetfusion
