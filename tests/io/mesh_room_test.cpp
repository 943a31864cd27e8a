#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

#include "io/source/mesh_sink.h"

namespace tetfusion {
namespace {

constexpr std::uint64_t kMost32 = std::numeric_limits<std::int32_t>::max();

ValueType ids_of(std::uint64_t corners, ValueType wanted) {
  MeshLayout layout;
  layout.corners = corners;
  return id_type_for(layout, wanted);
}

TEST(MeshRoom, IdsAreThoseOfTheInput) {
  EXPECT_EQ(ids_of(0, ValueType::kInt32), ValueType::kInt32);
  EXPECT_EQ(ids_of(kMost32, ValueType::kInt32), ValueType::kInt32);
  EXPECT_EQ(ids_of(0, ValueType::kInt64), ValueType::kInt64);
  EXPECT_EQ(ids_of(kMost32 + 1, ValueType::kInt64), ValueType::kInt64);
}

// 100 million hexahedra of 8 corners have offsets of 32 bits, their 600 million tetrahedra have
// not.
TEST(MeshRoom, IdsAreLongWhereTheLastOffsetIs) {
  EXPECT_EQ(ids_of(kMost32 + 1, ValueType::kInt32), ValueType::kInt64);
  EXPECT_EQ(ids_of(4 * std::uint64_t{600'000'000}, ValueType::kInt32), ValueType::kInt64);
}

}  // namespace
}  // namespace tetfusion
