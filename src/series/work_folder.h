// The folder where a shared series keeps what it needs until it is done.
#pragma once

#include <string>

#include "io/files/file_system.h"

namespace tetfusion {

// Made here, and locked by this process; removed, with what lies under the names below, with this
// object. What a process left that was killed is removed first. Throws Error(kUsage) where another
// process uses it, or something lies in it that is not ours; Error(kIo).
class WorkFolder {
 public:
  explicit WorkFolder(std::string path);
  ~WorkFolder();
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;

  const std::string& path() const { return path_; }
  // The result without the steps' arrays, where points went, and the scratch folder.
  std::string mesh() const { return path_ + "/tetfusion-series.vtu"; }
  std::string map() const { return path_ + "/tetfusion-series.map"; }
  std::string chunks() const { return path_ + "/tetfusion-series.chunks"; }

 private:
  void claim();
  void remove_contents() noexcept;
  [[noreturn]] void fail(const char* what) const;

  std::string path_;
  Descriptor folder_;
};

}  // namespace tetfusion
