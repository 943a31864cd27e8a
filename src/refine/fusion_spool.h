// The fusions of a round, sorted by chunks on a disk.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "io/files/row_file.h"
#include "mesh/fusion_log.h"

namespace tetfusion {

// Chunks of a round do not know each other, so one may be done after another: then what is touched
// lies together, where the file's order goes all over the mesh.
class FusionSpool {
 public:
  // On the disk of that folder. Throws Error(kIo).
  explicit FusionSpool(const std::string& folder) : file_(folder, 0) {}

  void add(const FusionRecord& record, std::uint32_t chunk);
  // Hands over all, chunk by chunk, in the order in which each chunk's came; it is empty then.
  void take(const std::function<void(const FusionLog& log)>& undo);

 private:
  struct Extent {
    std::uint64_t offset, bytes;
  };
  void put_away();

  RowFile file_;
  std::uint64_t end_ = 0;
  std::uint64_t in_memory_ = 0;  // bytes, about
  std::map<std::uint32_t, FusionLog> logs_;
  std::map<std::uint32_t, std::vector<Extent>> extents_;
};

}  // namespace tetfusion
