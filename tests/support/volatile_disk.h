// A disk that forgets what was not synced when the power goes.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <string>

#include "support/faulty_file_system.h"

namespace tetfusion::testing {

// Follows the files and folders below one folder. A file's bytes are safe once it was synced, its
// name once the folder was. Between the rest a disk may choose, and so does lose_power().
class VolatileDisk : public FaultyFileSystem {
 public:
  enum class Keeps {
    kSynced,  // nothing else
    kNames,   // and all names: of files that are empty, or have their old bytes
    kData,    // and all bytes, under the old names
    kSome     // some names, and some pages of each file, as the seed says
  };

  // What the folder holds is safe.
  explicit VolatileDisk(std::string folder);

  // Once a run has ended by die(): the folder then holds what the disk still has. To be called
  // once.
  void lose_power(Keeps keeps, std::uint64_t seed = 0);

  int fsync(int fd) override;

 private:
  using Inode = std::uint64_t;
  using Names = std::map<std::string, Inode>;
  struct Loss;

  void take_folder(const std::string& path);  // as synced, with all below it

  std::string folder_;
  std::mutex mutex_;
  std::map<Inode, Names> safe_names_;        // of folders
  std::map<Inode, std::string> safe_bytes_;  // of files
  std::set<Inode> folders_;
};

}  // namespace tetfusion::testing
