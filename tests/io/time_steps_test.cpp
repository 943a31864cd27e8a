// Which of a file's own time steps is wanted. Files that have some: cli/exodus_test.py.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "base/error.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "support/mesh_file.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string refusal(std::size_t steps, std::uint64_t wanted) {
  try {
    return "chosen: " + std::to_string(choose_time_step("run.e", steps, wanted));
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
    return error.what();
  }
}

TEST(TimeSteps, TheFirstIsTakenUnlessOneIsWanted) {
  for (const std::size_t steps : {0, 1, 3}) {
    EXPECT_EQ(choose_time_step("run.e", steps, std::nullopt), 0u);
    EXPECT_EQ(choose_time_step("run.e", steps, 0), 0u);
  }
  EXPECT_EQ(choose_time_step("run.e", 3, 2), 2u);
  EXPECT_EQ(choose_time_step("run.e", 3, kLastTimeStep), 2u);
  EXPECT_EQ(choose_time_step("run.e", 1, kLastTimeStep), 0u);
}

TEST(TimeSteps, OneThatIsNotThereIsRefusedWithWhatThereIs) {
  EXPECT_EQ(refusal(3, 3), "run.e: there is no time step 3 (--time-step): it has 3, from 0 to 2");
  EXPECT_EQ(refusal(1, 7), "run.e: there is no time step 7 (--time-step): it has 1, number 0");
  for (const std::uint64_t wanted : {std::uint64_t{1}, kLastTimeStep}) {
    EXPECT_THAT(refusal(0, wanted), HasSubstr("run.e: there are no time steps in it"));
  }
}

TEST(TimeSteps, OtherFormatsHaveNone) {
  const testing::TempDir dir;
  const std::string path = dir.file("a.vtu");
  testing::rich_box(2).write(path);
  EXPECT_THAT(time_steps_of(path), IsEmpty());
  EXPECT_THAT(time_steps_of("-"), IsEmpty());
  EXPECT_THAT(time_steps_of(dir.file("nothing.e")), IsEmpty());
  OpenOptions options;
  options.time_step = 0;
  EXPECT_THAT(open_mesh(path, options)->description().time_steps, IsEmpty());
  options.time_step = kLastTimeStep;
  EXPECT_THROW(open_mesh(path, options), Error);
}

}  // namespace
}  // namespace tetfusion
