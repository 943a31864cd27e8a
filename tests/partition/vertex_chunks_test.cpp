#include "partition/vertex_chunks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <thread>
#include <vector>

#include "support/meshes.h"

namespace tetfusion {
namespace {

struct Note {
  VertexId vertex;
  std::uint32_t chunk;
};

// Some vertices are noted for one chunk alone, some for many, a few for none.
std::vector<Note> random_notes(std::size_t count, VertexId vertices, std::uint32_t chunks) {
  std::vector<Note> notes;
  for (std::size_t i = 0; i < count; ++i) {
    const auto v = static_cast<VertexId>(vertices * testing::uniform(1, 2 * i));
    const double spread = v % 3 == 0 ? 1 : (v % 3 == 1 ? chunks : 3);
    const auto offset = static_cast<std::uint32_t>(spread * testing::uniform(1, 2 * i + 1));
    notes.push_back({v, (v * 7 + offset) % chunks});
  }
  return notes;
}

// `homes` are where points lie; a point's tetrahedra may all be elsewhere.
std::uint32_t home_of(VertexId v, std::uint32_t chunks) { return (v * 7 + v / 5 % 2) % chunks; }

std::vector<std::set<std::uint32_t>> brute(const std::vector<Note>& notes, VertexId vertices) {
  std::vector<std::set<std::uint32_t>> out(vertices);
  for (const Note& n : notes) out[n.vertex].insert(n.chunk);
  return out;
}

void expect_chunks(const VertexChunks& table,
                   const std::vector<std::set<std::uint32_t>>& expected) {
  for (VertexId v = 0; v < expected.size(); ++v) {
    Vector<std::uint32_t> chunks{99};  // what is there stays
    table.chunks_of(v, &chunks);
    ASSERT_EQ(chunks[0], 99u);
    chunks.erase(chunks.begin());
    EXPECT_TRUE(std::ranges::equal(chunks, expected[v])) << "vertex " << v;
  }
}

TEST(VertexChunks, ATetrahedronIsInTheLowestOfItsPointsChunks) {
  VertexChunks table(6);
  for (VertexId v = 0; v < 6; ++v) table.set_home(v, v < 4 ? 2 : v);
  VertexChunks::Notes notes(&table);
  EXPECT_EQ(notes.add({0, 1, 2, 3}), 2u);
  EXPECT_EQ(notes.add({0, 1, 2, 3}), 2u);
  EXPECT_EQ(notes.add({5, 1, 4, 3}), 2u);
  EXPECT_EQ(notes.add({5, 5, 4, 4}), 4u);
  notes.hand_over();
  table.finish();
  expect_chunks(table, {{2}, {2}, {2}, {2}, {2, 4}, {2, 4}});
}

TEST(VertexChunks, KnowsTheChunksOfAVertex) {
  VertexChunks table(4);
  table.set_home(0, 5);
  table.set_home(1, 5);
  table.set_home(2, VertexChunks::kMaxChunks - 1);
  table.set_home(3, 0);
  VertexChunks::Notes notes(&table);
  notes.add(0, 5);  // at home
  for (const std::uint32_t c : {7, 1, 7, 5, 2, 1}) notes.add(1, c);
  notes.add(2, 0);  // never at home
  notes.hand_over();
  table.finish();
  expect_chunks(table, {{5}, {1, 2, 5, 7}, {0}, {}});
}

TEST(VertexChunks, AgreesWithBruteForceFromSeveralThreads) {
  constexpr VertexId kVertices = 3000;
  for (const std::uint32_t chunks : {2u, 40u, VertexChunks::kMaxChunks}) {
    const std::vector<Note> notes = random_notes(60'000, kVertices, chunks);
    auto expected = brute(notes, kVertices);
    for (const Note& n : notes) expected[n.vertex].insert(home_of(n.vertex, chunks));
    for (const std::size_t threads : {1, 2, 5}) {
      VertexChunks table(kVertices);
      for (VertexId v = 0; v < kVertices; ++v) table.set_home(v, home_of(v, chunks));
      std::vector<std::jthread> workers;
      for (std::size_t w = 0; w < threads; ++w) {
        workers.emplace_back([&, w] {
          // Several runs of notes a thread, some of them of tetrahedra.
          constexpr std::size_t kRun = 700;
          for (std::size_t begin = w * kRun; begin < notes.size(); begin += threads * kRun) {
            VertexChunks::Notes mine(&table);
            for (std::size_t i = begin; i < std::min(begin + kRun, notes.size()); ++i) {
              const VertexId v = notes[i].vertex;
              mine.add(v, notes[i].chunk);
              ASSERT_EQ(mine.add({v, v, v, v}), home_of(v, chunks));
            }
            mine.hand_over();
          }
        });
      }
      workers.clear();  // joins
      table.finish();
      expect_chunks(table, expected);
    }
  }
}

// More notes than are kept unsorted.
TEST(VertexChunks, TakesMoreNotesThanItKeepsApart) {
  constexpr VertexId kVertices = 200'000;
  VertexChunks table(kVertices);
  for (VertexId v = 0; v < kVertices; ++v) table.set_home(v, 0);
  for (int repeat = 0; repeat < 2; ++repeat) {
    for (std::uint32_t c = 0; c < 9; ++c) {
      VertexChunks::Notes notes(&table);
      for (VertexId v = 0; v < kVertices; ++v) notes.add(v, c);
      notes.hand_over();
    }
  }
  table.finish();
  for (const VertexId v : {0u, 1u, 77'777u, kVertices - 1}) {
    Vector<std::uint32_t> chunks;
    table.chunks_of(v, &chunks);
    EXPECT_EQ(chunks, count_up<std::uint32_t>(9));
  }
}

}  // namespace
}  // namespace tetfusion
