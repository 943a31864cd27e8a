// The lists of a mesh that grows, and a round's fusions sorted by chunks.
#include "refine/stars.h"

#include <gtest/gtest.h>

#include <vector>

#include "refine/fusion_spool.h"
#include "support/meshes.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using testing::TempDir;

// Against lists that are plain; those that outgrow their room leave it to others.
TEST(StarsTest, AreWhatWasPutIn) {
  const TempDir folder = TempDir::in_memory();
  for (const std::string& where : {std::string(), folder.path().string()}) {
    constexpr VertexId kVertices = 50;
    Stars stars(where, kVertices, 1);  // has to grow
    std::vector<std::vector<TetId>> expected(kVertices);
    for (std::uint32_t i = 0; i < 20'000; ++i) {
      const auto v = static_cast<VertexId>(testing::uniform(1, i) * kVertices);
      if (testing::uniform(2, i) < 0.97) {
        stars.add(v, i);
        expected[v].push_back(i);
      } else {
        std::vector<TetId> some;
        const auto count = static_cast<TetId>(testing::uniform(3, i) * 400);
        for (TetId k = 0; k < count; ++k) some.push_back(i + k);
        stars.replace(v, some);
        expected[v] = some;
      }
      if (i % 1000 == 0) stars.let_go();
      stars.stamp(v) = i;
      EXPECT_EQ(stars.stamp(v), i);
    }
    for (VertexId v = 0; v < kVertices; ++v) {
      const auto list = stars.of(v);
      EXPECT_EQ(std::vector<TetId>(list.begin(), list.end()), expected[v]) << v;
    }
  }
}

TEST(FusionSpoolTest, ChunksComeOneAfterAnother) {
  const TempDir folder = TempDir::in_memory();
  FusionSpool spool(folder.path().string());
  const auto put = [&](VertexId kept, std::uint32_t chunk, std::size_t bytes) {
    FusionRecord record;
    record.kept = kept;
    const std::vector<std::byte> rows(bytes, static_cast<std::byte>(kept));
    record.rows = rows;
    spool.add(record, chunk);
  };
  const auto taken = [&] {
    std::vector<VertexId> kept;
    spool.take([&](const FusionLog& log) {
      for (std::size_t i = 0; i < log.size(); ++i) {
        kept.push_back(log[i].kept);
        for (const std::byte b : log[i].rows) {
          ASSERT_EQ(b, static_cast<std::byte>(log[i].kept));
        }
      }
    });
    return kept;
  };
  EXPECT_EQ(taken(), std::vector<VertexId>{});
  // More than is kept in memory, so that a chunk's lie in several places.
  for (VertexId i = 0; i < 12; ++i) put(i, i % 3 == 0 ? 7 : i % 3, 4 << 20);
  EXPECT_EQ(taken(), (std::vector<VertexId>{1, 4, 7, 10, 2, 5, 8, 11, 0, 3, 6, 9}));
  put(40, 3, 5);
  put(41, 1, 0);
  EXPECT_EQ(taken(), (std::vector<VertexId>{41, 40}));
}

}  // namespace
}  // namespace tetfusion
