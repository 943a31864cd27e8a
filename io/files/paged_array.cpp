#include "io/files/paged_array.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <vector>

#include "base/error.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kPage = 4096;
constexpr std::uint64_t kHugePage = std::uint64_t{2} << 20;

}  // namespace

PagedBytes::PagedBytes(std::string folder, std::uint64_t bytes) : folder_(std::move(folder)) {
  if (!folder_.empty()) {
    file_ = Descriptor(open_nameless(folder_));
    if (!file_) fail("making", errno);
  }
  set_size(std::max<std::uint64_t>(bytes, 1));
}

PagedBytes::~PagedBytes() {
  if (data_ != nullptr) file_system().munmap(data_, bytes_);
}

PagedBytes& PagedBytes::operator=(PagedBytes&& other) noexcept {
  std::swap(folder_, other.folder_);
  std::swap(file_, other.file_);
  std::swap(data_, other.data_);
  std::swap(bytes_, other.bytes_);
  return *this;
}

void PagedBytes::grow(std::uint64_t bytes) {
  if (bytes > bytes_) set_size(bytes);
}

// A page that the disk has no room for could not be told from one that is lost.
void PagedBytes::set_size(std::uint64_t bytes) {
  const std::uint64_t unit = file_ || bytes < kHugePage ? kPage : kHugePage;
  const std::uint64_t rounded = (bytes + unit - 1) / unit * unit;
  if (file_) {
    FileSystem& system = file_system();
    const auto from = static_cast<off_t>(bytes_), more = static_cast<off_t>(rounded - bytes_);
    if (retry([&] { return system.fallocate(file_.get(), 0, from, more); }) != 0) {
      if (errno != EOPNOTSUPP && errno != ENOSYS) fail("making room in", errno);
      fill_with_zeros(bytes_, rounded);
    }
  }
  void* data = data_ == nullptr ? map(rounded) : ::mremap(data_, bytes_, rounded, MREMAP_MAYMOVE);
  if (data == MAP_FAILED) throw std::bad_alloc();
  data_ = static_cast<std::byte*>(data);
  bytes_ = rounded;
  if (!file_ && rounded >= kHugePage) file_system().madvise(data_, rounded, MADV_HUGEPAGE);
}

// For file systems that cannot set room aside.
void PagedBytes::fill_with_zeros(std::uint64_t begin, std::uint64_t end) const {
  const std::vector<std::byte> zeros(kHugePage);
  for (std::uint64_t at = begin; at < end; at += zeros.size()) {
    const std::uint64_t count = std::min<std::uint64_t>(zeros.size(), end - at);
    if (const int error = pwrite_all(file_.get(), zeros.data(), count, at)) {
      fail("making room in", error);
    }
  }
}

void* PagedBytes::map(std::uint64_t bytes) const {
  const int flags = file_ ? MAP_SHARED : MAP_PRIVATE | MAP_ANONYMOUS;
  return file_system().mmap(nullptr, bytes, PROT_READ | PROT_WRITE, flags, file_ ? file_.get() : -1,
                            0);
}

void PagedBytes::let_go() const {
  if (file_) file_system().madvise(data_, bytes_, MADV_DONTNEED);
}

void PagedBytes::fail(const char* what, int error) const {
  throw Error(ErrorCode::kIo, fmt::format("{}: {} a temporary file failed: {}: free some room, or "
                                          "give another folder (--scratch)",
                                          folder_, what, std::strerror(error)));
}

}  // namespace tetfusion
