#include "driver/checkpoint.h"

#include <gtest/gtest.h>

#include "support/import.h"
#include "support/mesh_file.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

// A state with something in every field.
RunState<double> rich_state() {
  RunState<double> state;
  const testing::TempDir folder = testing::TempDir::in_memory();
  testing::rich_box(6).write(folder.file("in.vtu"));
  testing::Import<double> import(folder.file("in.vtu"), {.chunk_tets = 100});
  state.mesh = std::move(import.imported.mesh);
  state.input = std::move(import.imported);
  state.mesh.pieces.reset();
  state.mesh.locks = {3, 17, 99};
  state.input.rewound.resize(21);
  state.input.rewound[3] = state.input.rewound[16] = state.input.rewound[20] = true;
  state.input.facts.locked_vertices = 12;
  state.mesh.facing.reset({{0, -1, 0.5}, {1, 2, 3}});
  state.mesh.facing.cells()[70] = 9;
  state.fields = {{0, 1, 3.5, {}}, {1, 3, 0.75, 0.01}};
  state.field_names = {"f", "", "cell:stress with a long name that does not fit into the string"};
  state.steering_width = 4;
  state.rounds.resize(3);
  state.rounds[1].pass.fused = 77;
  state.rounds[2].seconds = 0.25;
  state.outputs = {{"level_1.vtu", 8, 5, 12, 0.5}, {"level_2.vtu", 4, 1, 4, 0.125}};
  state.log_slices = {1, 17, 3};
  state.chunk_tets = 1234;
  state.shrink = 0.875;
  state.spread = 0;
  state.end = StageEnd::kSaturated;
  return state;
}

TEST(Checkpoint, GivesBackWhatWasSaved) {
  const RunState<double> state = rich_state();
  const Vector<std::byte> bytes = save(state);
  RunState<double> loaded;
  load(bytes, &loaded);
  EXPECT_EQ(save(loaded), bytes);
  EXPECT_EQ(loaded.mesh.tets, 1080u);
  EXPECT_EQ(loaded.mesh.chunks, 11u);
  EXPECT_EQ(loaded.mesh.interface.entries().size(), state.mesh.interface.entries().size());
  EXPECT_EQ(loaded.mesh.locks, (Vector<VertexId>{3, 17, 99}));
  EXPECT_EQ(loaded.mesh.facing.cells(), state.mesh.facing.cells());
  EXPECT_EQ(loaded.mesh.facing.box().lo, (Point3{0, -1, 0.5}));
  EXPECT_EQ(loaded.mesh.samples.size(), state.mesh.samples.size());
  EXPECT_EQ(loaded.input.box.hi.x, 6);
  EXPECT_EQ(loaded.input.rewound, state.input.rewound);
  EXPECT_EQ(loaded.input.facts.locked_vertices, 12u);
  EXPECT_EQ(loaded.input.lower.cells.connectivity, state.input.lower.cells.connectivity);
  ASSERT_EQ(loaded.input.lower.columns.size(), 3u);
  EXPECT_EQ(loaded.input.lower.columns[1].rows, state.input.lower.columns[1].rows);
  EXPECT_EQ(loaded.input.lower.columns[1].type, ValueType::kFloat64);
  EXPECT_EQ(loaded.input.lower.columns[1].components, 3u);
  EXPECT_EQ(loaded.input.lower.loose_ids, state.input.lower.loose_ids);
  EXPECT_EQ(loaded.field_names, state.field_names);
  ASSERT_EQ(loaded.fields.size(), 2u);
  EXPECT_EQ(loaded.fields[1].tolerance, 0.01);
  EXPECT_EQ(loaded.rounds.at(1).pass.fused, 77u);
  EXPECT_EQ(loaded.rounds.at(2).seconds, 0.25);
  EXPECT_EQ(loaded.outputs, state.outputs);
  EXPECT_EQ(loaded.log_slices, (std::vector<std::uint32_t>{1, 17, 3}));
  EXPECT_EQ(loaded.chunk_tets, 1234u);
  EXPECT_EQ(loaded.shrink, 0.875);
  EXPECT_EQ(loaded.spread, 0);
  EXPECT_EQ(loaded.end, StageEnd::kSaturated);
}

TEST(Checkpoint, GivesBackAnEmptyState) {
  const Vector<std::byte> bytes = save(RunState<float>{});
  RunState<float> loaded;
  loaded.outputs = {{"left over", 1, 2, 3, 4}};
  loaded.rounds.resize(2);
  load(bytes, &loaded);
  EXPECT_EQ(save(loaded), bytes);
  EXPECT_TRUE(loaded.outputs.empty());
}

TEST(Checkpoint, RefusesBytesThatAreCutOff) {
  const Vector<std::byte> bytes = save(rich_state());
  for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 50) {
    RunState<double> loaded;
    try {
      load(std::span(bytes).first(size), &loaded);
      ADD_FAILURE() << "took " << size << " of " << bytes.size() << " bytes";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kIo);
    }
  }
  RunState<double> loaded;
  EXPECT_THROW(load(std::span(bytes).first(bytes.size() - 1), &loaded), Error);
}

// Checksums keep other bytes away; if they did not, nothing worse than an Error would come of it.
// Without the grid, whose cells are a megabyte that holds no sizes.
TEST(Checkpoint, SizesThatAreTooLargeAreRefused) {
  RunState<double> state = rich_state();
  state.mesh.facing = {};
  const Vector<std::byte> bytes = save(state);
  for (std::size_t at = 0; at + 8 <= bytes.size(); at += 8) {
    Vector<std::byte> damaged = bytes;
    for (std::size_t i = 4; i < 8; ++i) damaged[at + i] = std::byte{0x7F};
    RunState<double> loaded;
    try {
      load(damaged, &loaded);
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kIo);
    }
  }
}

}  // namespace
}  // namespace tetfusion
