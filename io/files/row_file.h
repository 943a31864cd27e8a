// Bytes that a run puts aside and takes back, in a file without a name: nothing is left of it when
// the process ends, however it ends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "io/files/file_system.h"

namespace tetfusion {

// Every function throws Error(kIo). read() is safe to call from several threads.
class RowFile {
 public:
  // On the disk of that folder, which must be there. What was not written yet reads as zeros.
  RowFile(std::string folder, std::uint64_t bytes);

  void write(std::uint64_t offset, std::span<const std::byte> bytes);
  void read(std::uint64_t offset, std::span<std::byte> bytes) const;

 private:
  [[noreturn]] void fail(const char* what, int error) const;

  std::string folder_;
  Descriptor file_;
};

}  // namespace tetfusion
