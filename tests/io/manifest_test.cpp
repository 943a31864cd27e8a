// The log of a scratch folder, damaged and gone on with.
#include "io/store/manifest.h"

#include <fcntl.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "support/mesh_file.h"
#include "support/temp_dir.h"
#include "support/vtu_text.h"

namespace tetfusion {
namespace {

using testing::bytes_of;
using testing::TempDir;
using testing::write_file;

class ManifestFile : public ::testing::Test {
 protected:
  ManifestFile() { write_file(path_, ""); }

  Manifest open() const {
    return {Descriptor(file_system().openat(AT_FDCWD, path_.c_str(), O_RDWR | O_CLOEXEC, 0)),
            path_};
  }
  std::vector<std::string> names() const {
    const Manifest manifest = open();
    std::vector<std::string> found;
    for (const Commit& commit : manifest.commits()) found.push_back(commit.name);
    return found;
  }

  TempDir dir_ = TempDir::in_memory();
  std::string path_ = dir_.file("manifest");
};

using Names = std::vector<std::string>;

// A disk may lose a page in the middle when the power goes, and keep the next one.
TEST_F(ManifestFile, NothingBehindADamagedRecordComesBack) {
  {
    Manifest manifest = open();
    manifest.start("job");
    for (const char* name : {"round-0", "round-1", "round-2"}) manifest.commit({name, 1, 2, false});
  }
  std::string bytes = bytes_of(path_);
  bytes[bytes.find("round-1")] = 'x';
  write_file(path_, bytes);
  EXPECT_EQ(names(), Names{"round-0"});
  open().commit({"round-9", 1, 2, false});  // as long as the one that is damaged
  EXPECT_EQ(names(), (Names{"round-0", "round-9"}));
}

}  // namespace
}  // namespace tetfusion
