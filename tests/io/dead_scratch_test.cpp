#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "io/files/file_system.h"
#include "io/store/scratch.h"
#include "support/pieces.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

// Of killed processes: a copy of a folder is one that nobody has locked.
TEST(DeadScratch, GoesWhereNobodyResumesIt) {
  namespace fs = std::filesystem;
  const testing::TempDir folder = testing::TempDir::in_memory();
  const std::string live = folder.file(temporary_name()), other = folder.file(temporary_name());
  const auto scratch = disk_scratch({live, "a test", false, 0});
  const auto others = disk_scratch({other, "another test", false, 0});
  const auto store = scratch->begin("pieces");
  testing::add_pieces(store.get(), 0, {{0, "a piece"}});
  store->seal();
  const auto copy = [&](const std::string& from, const std::string& name, bool settled) {
    fs::copy(from, folder.file(name), fs::copy_options::recursive);
    if (settled) {
      fs::last_write_time(folder.file(name),
                          fs::file_time_type::clock::now() - std::chrono::minutes(2));
    }
    return folder.file(name);
  };
  const std::string dead = copy(live, temporary_name(), true);
  const std::vector<std::string> kept{live, other, copy(live, temporary_name(), false),
                                      copy(other, temporary_name(), true),
                                      copy(live, "tetfusion-mine", true)};
  for (const std::string& path : {live, other}) {
    fs::last_write_time(path, fs::file_time_type::clock::now() - std::chrono::minutes(2));
  }
  ASSERT_TRUE(fs::exists(dead));
  remove_dead_scratch(folder.path(), "a test");
  EXPECT_FALSE(fs::exists(dead));
  for (const std::string& path : kept) EXPECT_TRUE(fs::exists(path + "/manifest")) << path;
  remove_dead_scratch(folder.file("missing"), "a test");
}

}  // namespace
}  // namespace tetfusion
