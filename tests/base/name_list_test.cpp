#include "base/name_list.h"

#include <gtest/gtest.h>

namespace tetfusion {
namespace {

TEST(NameList, HasTheFirstOfMany) {
  EXPECT_EQ(list_names({}, 2), "");
  EXPECT_EQ(list_names({"a"}, 2), "a");
  EXPECT_EQ(list_names({"a", "b"}, 2), "a, b");
  EXPECT_EQ(list_names({"a", "b", "c", "d"}, 2), "a, b and 2 more");
}

}  // namespace
}  // namespace tetfusion
