#include "vtk/vtk_trial.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cerrno>
#include <functional>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

namespace tetfusion {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr char kPath[] = "mesh.case";
constexpr char kNoError[] = "no error";

// The message of what the trial throws; no child is left behind.
std::string told_of(const std::function<void()>& work, ErrorCode expected = ErrorCode::kBadInput) {
  std::string message = kNoError;
  try {
    try_in_child(kPath, work);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), expected) << error.what();
    message = error.what();
  }
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
  return message;
}

TEST(VtkTrial, WorkThatIsDoneIsForgotten) {
  int done = 0;
  EXPECT_EQ(told_of([&] { done = 1; }), kNoError);
  EXPECT_EQ(done, 0);
}

TEST(VtkTrial, ErrorsComeThroughAndWordsOfLibrariesDoNot) {
  EXPECT_EQ(told_of([] { throw Error(ErrorCode::kIo, "our words"); }, ErrorCode::kIo), "our words");
  EXPECT_EQ(told_of([] { throw InvalidMesh("is met again"); }), kNoError);
  const auto count_is_wrong =
      AllOf(StartsWith("mesh.case: a count in it"), HasSubstr("the file is damaged"),
            Not(HasSubstr("vector")), Not(HasSubstr("bad_")));
  std::vector<int> list;
  EXPECT_THAT(told_of([&] { list.resize(list.max_size() + 1); }), count_is_wrong);
  EXPECT_THAT(told_of([] { throw std::bad_array_new_length(); }), count_is_wrong);
  EXPECT_THAT(told_of([] { throw std::bad_alloc(); }, ErrorCode::kMemory),
              AllOf(StartsWith("mesh.case: there is not enough memory"), HasSubstr("damaged"),
                    Not(HasSubstr("bad_"))));
  EXPECT_THAT(told_of([] { throw std::runtime_error("no such thing"); }),
              AllOf(HasSubstr("VTK gives up"), HasSubstr("(no such thing)"), HasSubstr("damaged")));
  EXPECT_THAT(told_of([] { throw 1; }), HasSubstr("VTK gives up"));
}

}  // namespace
}  // namespace tetfusion
