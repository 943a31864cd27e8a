#include "io/files/row_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "base/error.h"

namespace tetfusion {

RowFile::RowFile(std::string folder, std::uint64_t bytes)
    : folder_(std::move(folder)), file_(open_nameless(folder_)) {
  if (!file_) fail("making", errno);
  const auto size = static_cast<off_t>(bytes);
  if (retry([&] { return file_system().ftruncate(file_.get(), size); }) != 0) fail("making", errno);
}

void RowFile::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  if (const int error = pwrite_all(file_.get(), bytes.data(), bytes.size(), offset)) {
    fail("writing", error);
  }
}

void RowFile::read(std::uint64_t offset, std::span<std::byte> bytes) const {
  if (const int error = pread_all(file_.get(), bytes.data(), bytes.size(), offset)) {
    fail("reading", error);
  }
}

void RowFile::fail(const char* what, int error) const {
  throw Error(ErrorCode::kIo,
              fmt::format("{}: {} a temporary file failed: {}", folder_, what,
                          error == kEndOfFile ? "it was cut off" : std::strerror(error)));
}

}  // namespace tetfusion
