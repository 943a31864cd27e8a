#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <set>
#include <string>

#include "io/files/file_system.h"

namespace tetfusion {
namespace {

// What stands behind the number of the process.
std::string own_part(const std::string& name) { return name.substr(name.find_last_of('-') + 1); }

std::string name_of_another_process() {
  int ends[2];
  EXPECT_EQ(::pipe(ends), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    const std::string name = temporary_name();
    _exit(::write(ends[1], name.data(), name.size()) == static_cast<ssize_t>(name.size()) ? 0 : 1);
  }
  ::close(ends[1]);
  char name[256];
  const ssize_t bytes = ::read(ends[0], name, sizeof(name));
  ::close(ends[0]);
  int status = -1;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  return {name, bytes > 0 ? static_cast<std::size_t>(bytes) : 0};
}

TEST(TemporaryName, SaysWhoseItIs) {
  EXPECT_TRUE(temporary_name().starts_with("tetfusion-" + std::to_string(::getpid()) + "-"));
}

// In two containers processes may have the same number and have made as many names before.
TEST(TemporaryName, DiffersWhateverTheNumberOfTheProcess) {
  std::set<std::string> seen;
  for (int i = 0; i < 8; ++i) {
    EXPECT_TRUE(seen.insert(own_part(name_of_another_process())).second);
    EXPECT_TRUE(seen.insert(own_part(temporary_name())).second);
  }
}

}  // namespace
}  // namespace tetfusion
