#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "io/store/scratch.h"
#include "support/pieces.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

// A name may be used again when its generation is gone. Its files wait to be overwritten then; that
// must not take the new files of these names.
TEST(ScratchNames, MayBeUsedAgain) {
  const testing::TempDir folder = testing::TempDir::in_memory();
  const auto scratch = disk_scratch({folder.file("scratch"), "a test", false, 0});
  for (std::uint32_t round = 0; round < 6; ++round) {
    const auto store = scratch->begin("again");
    const auto piece = [&](std::uint32_t source) {
      return std::string(1 + (source * 977 + round * 3001) % 5000, static_cast<char>('a' + source));
    };
    for (std::uint32_t i = 0; i < 12; ++i) {
      const std::uint32_t source = (i * 5 + round) % 12;
      testing::add_pieces(store.get(), source, {{0, piece(source)}});
    }
    store->seal();
    std::vector<std::string> expected;
    for (std::uint32_t source = 0; source < 12; ++source) expected.push_back(piece(source));
    EXPECT_EQ(testing::pieces_in(*store, 0), expected);
  }
}

}  // namespace
}  // namespace tetfusion
