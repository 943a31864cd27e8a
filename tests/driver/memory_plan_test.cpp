#include "driver/rounds/memory_plan.h"

#include <gtest/gtest.h>

#include "driver/arrays/carried_arrays.h"
#include "driver/export/progressive.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "support/mesh_file.h"
#include "support/temp_dir.h"
#include "support/units.h"

namespace tetfusion {
namespace {

// What a run needs of memory, estimated before it begins. Chunks have 700 tetrahedra.
class MemoryPlan : public ::testing::Test {
 protected:
  MemoryPlan() {
    testing::rich_box(11).write(folder.file("in.vtu"));
    mesh = open_mesh(folder.file("in.vtu"))->description();
  }
  MemoryNeeds needs_with(int threads) const {
    return estimate_needs(mesh, {.vertex = sizeof(double)}, 700, threads, {});
  }

  testing::TempDir folder = testing::TempDir::in_memory();
  MeshDescription mesh;
};

// More threads than chunks have none in hand.
TEST_F(MemoryPlan, ThreadsWithoutAChunkTakeLessMemory) {
  const auto more = [&](int threads) {
    return needs_with(threads + 1).out_of_core - needs_with(threads).out_of_core;
  };
  const std::uint64_t chunks = mesh.cells / 700 + 1;
  EXPECT_GT(more(1), more(static_cast<int>(chunks)));
  EXPECT_GE(more(static_cast<int>(chunks)), 30u * testing::kMiB);
}

// Arrays may be many and wide.
TEST_F(MemoryPlan, WindowsOfWideRowsHaveFewer) {
  constexpr std::uint64_t kMost = 1 << 19, kTotal = 150 * testing::kMiB;
  EXPECT_EQ(plan_window(kMost, 16, kTotal, 2).rows, 30 * testing::kMiB / (40 + 24));
  for (const std::uint64_t row : {100u, 1000u, 5000u}) {
    const InputWindow window = plan_window(kMost, row, kTotal, 2);
    EXPECT_LE(window.bytes, 30 * testing::kMiB);
    EXPECT_GE(window.bytes, window.rows * 2 * row);
    EXPECT_GE(window.rows, 2048u);
  }
  EXPECT_EQ(plan_window(kMost, 100'000, kTotal, 2).rows, 2048u);
  EXPECT_EQ(plan_window(kMost, 1000, std::uint64_t{1} << 40, 2).rows, kMost);
  EXPECT_EQ(plan_window(700, 16, kTotal, 2).rows, 700u);
}

// They are in memory all the time, and once more when they are read, put away and written; but
// they are in no chunk.
TEST_F(MemoryPlan, CellsOfLowerDimensionTakeMemory) {
  const auto needs = [&](std::uint64_t triangles) {
    return estimate_needs(mesh, {.vertex = 8}, 700, 2, {0, {triangles, 3 * triangles}});
  };
  const std::uint64_t row = CarriedArrays(mesh).cell_data.row_bytes();
  const std::uint64_t each = 2 * (1 + 8 + 2 * 3 * 4 + row);
  EXPECT_EQ(needs(0).pieces - needs(100).pieces, 100 * (17 + row));
  EXPECT_NEAR(static_cast<double>(needs(100).out_of_core - needs(0).out_of_core), 100.0 * each,
              20.0 * 100 * (17 + row) / 8);
  mesh.cells += 1'000'000;
  EXPECT_GT(needs(1'000'000).out_of_core, 1'000'000 * each);
}

// In the end a chunk may be full of them.
TEST_F(MemoryPlan, RemovedPointsTakeMemory) {
  const auto needs = [&](std::uint64_t removed) {
    return estimate_needs(mesh, {.vertex = 8, .removed_point = removed}, 700, 2, {});
  };
  EXPECT_EQ(needs(0).out_of_core, needs(1).out_of_core);  // less than its tetrahedra
  EXPECT_EQ(needs(2000).out_of_core - needs(1000).out_of_core, 2u * 6 * 2 * 700 * 1000);
  EXPECT_EQ(needs(2000).pieces, needs(0).pieces);
}

// All of them in memory; in the end at most four for each tetrahedron of a chunk.
TEST_F(MemoryPlan, PointsThatArePutAsideTakeMemory) {
  const auto needs = [&](std::uint64_t aside, std::uint64_t chunk_tets) {
    return estimate_needs(mesh, {.vertex = 8, .point_aside = aside}, chunk_tets, 2, {});
  };
  EXPECT_EQ(needs(8, 700).out_of_core, needs(0, 700).out_of_core);  // less than windows
  EXPECT_EQ(needs(8, 700).in_core - needs(0, 700).in_core, mesh.points * (3 * 8 + 8));
  EXPECT_EQ(needs(8, 700).pieces, needs(0, 700).pieces);
  const SteeringBytes with_starts{.vertex = 8, .point_aside = 8, .positions_aside = 2};
  EXPECT_EQ(estimate_needs(mesh, with_starts, 700, 2, {}).in_core - needs(8, 700).in_core,
            mesh.points * 3 * 8);
  const SteeringBytes with_cells{.vertex = 8, .point_aside = 8, .cell_aside = 4};
  EXPECT_EQ(estimate_needs(mesh, with_cells, 700, 2, {}).in_core - needs(8, 700).in_core,
            mesh.cells * (5 * 8 + 4));
  // They are there twice when they are sorted.
  const SteeringBytes with_wide_cells{.vertex = 8, .point_aside = 8, .cell_aside = 1200};
  EXPECT_GT(estimate_needs(mesh, with_wide_cells, 700, 2, {}).scratch,
            2 * mesh.cells * (5 * 8 + 1200));
}

// All of it is in memory while a result is written, and three times that with the way back.
TEST_F(MemoryPlan, FieldDataTakesMemory) {
  constexpr std::uint64_t kValues = 1 << 24;
  const MemoryNeeds none = needs_with(1);
  MemoryNeeds none_back = none;
  SimplifyRequest request;
  include_logs(request, mesh, 1, &none_back);
  mesh.field_data.arrays.push_back({"history", ValueType::kFloat64, 1, {}, kValues});
  MemoryNeeds needs = needs_with(1);
  EXPECT_EQ(needs.out_of_core, none.out_of_core + 8 * kValues);
  EXPECT_EQ(needs.in_core, none.in_core + 8 * kValues);
  include_logs(request, mesh, 1, &needs);
  EXPECT_EQ(needs.in_core, none_back.in_core + 3 * 8 * kValues);
  EXPECT_GT(needs.out_of_core, 3 * 8 * kValues);
}

// It is looked at in one piece, however small the chunks are.
TEST_F(MemoryPlan, AnExcerptTakesMemory) {
  mesh.cells = 20'000;
  mesh.cell_data.arrays.push_back({"wide", ValueType::kFloat64, 1000, {}, mesh.cells});
  EXPECT_GT(needs_with(1).out_of_core, 6 * mesh.cells * 8000);
}

// Means of cell arrays are made in memory, of all points at once.
TEST_F(MemoryPlan, CellArraysThatSteerTakeMemory) {
  mesh.points = 100'000'000;
  mesh.cells = 600'000'000;
  const auto needs = [&](std::uint64_t mean) {
    return estimate_needs(mesh, {.vertex = 8, .point_mean = mean}, 200'000, 2, {}).out_of_core;
  };
  EXPECT_GT(needs(8), 40u * mesh.points);
  EXPECT_EQ(needs(16) - needs(8), 8u * mesh.points);
}

}  // namespace
}  // namespace tetfusion
