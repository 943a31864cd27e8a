#include "base/id_map.h"

#include <gtest/gtest.h>

#include <map>

namespace tetfusion {
namespace {

TEST(IdMap, FindsWhatWasPutIn) {
  IdMap map;
  for (const std::size_t ids : {0u, 1u, 8u, 9u, 1000u}) {
    for (const std::uint32_t step : {1u, 16u, 0x10000u, 0x9E3779B1u}) {
      map.reset(ids);
      std::map<std::uint32_t, std::uint32_t> expected;
      for (std::uint32_t i = 0; i < ids; ++i) {
        const std::uint32_t id = i * step;
        EXPECT_EQ(map.find(id), expected.contains(id) ? expected[id] : IdMap::kNone);
        std::uint32_t& value = map[id];
        if (value == IdMap::kNone) expected[id] = value = 7 * i;
      }
      for (const auto& [id, value] : expected) {
        EXPECT_EQ(map.find(id), value);
        EXPECT_EQ(map[id], value);
      }
      EXPECT_EQ(map.find(0xFFFFFFFEu), IdMap::kNone);
    }
  }
}

TEST(IdMap, ForgetsEverything) {
  IdMap map;
  map.reset(100);
  map[5] = 6;
  map.reset(1);
  EXPECT_EQ(map.find(5), IdMap::kNone);
}

}  // namespace
}  // namespace tetfusion
