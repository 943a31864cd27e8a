// What meshes are written as, and where to.
#pragma once

#include <functional>
#include <string>

namespace tetfusion {

enum class Encoding { kRaw, kZlib, kLz4, kInline, kAscii };

struct WriteOptions {
  Encoding encoding = Encoding::kRaw;
  std::function<void(double share)> progress;  // 0..1; may be empty
};

// Throws what writing a mesh of that name would throw, before any work: Error(kUsage) for a format
// that cannot be written, Error(kIo) where no file can be made. Creates nothing. "-" is standard
// output.
void check_mesh_output(const std::string& path);

}  // namespace tetfusion
