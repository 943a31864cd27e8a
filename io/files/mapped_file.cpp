#include "io/files/mapped_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "base/error.h"
#include "base/numbers.h"
#include "base/vector.h"
#include "io/files/checksum.h"
#include "io/files/fault_guard.h"
#include "io/files/file_system.h"

namespace tetfusion {

namespace {

[[noreturn]] void fail(const std::string& what, int error) {
  throw Error(ErrorCode::kIo, what + ": " + std::strerror(error));
}

// Where a copy goes, and what to say when it cannot be made.
struct Spool {
  Spool(const std::string& what, const std::string& wanted) : name(what) {
    std::error_code ignored;
    if (wanted.empty()) {
      folder = temporary_folder();
      hint = "set TMPDIR to another folder";
      return;
    }
    hint = "use another scratch folder (--scratch)";
    const std::filesystem::path parent = std::filesystem::path(wanted).parent_path();
    folder = std::filesystem::is_directory(wanted, ignored) ? wanted
             : parent.empty()                               ? std::string(1, '.')
                                                            : parent.string();
  }
  [[noreturn]] void fail_creating(int error) const {
    throw Error(ErrorCode::kIo, fmt::format("{}: cannot make a temporary file in {}: {}; {}", name,
                                            folder, std::strerror(error), hint));
  }
  [[noreturn]] void fail_writing(std::uint64_t written, int error) const {
    throw Error(
        ErrorCode::kIo,
        fmt::format("{}: copying it to a temporary file in {} failed after {} ({} bytes): "
                    "{}; free some space, or {}",
                    name, folder, format_bytes(written), written, std::strerror(error), hint));
  }
  std::string name;
  std::string folder;
  std::string hint;
};

}  // namespace

MappedFile::MappedFile(std::string path, int fd, std::uint64_t size)
    : path_(std::move(path)), fd_(fd), size_(size) {
  void* p = file_system().mmap(nullptr, size_, PROT_READ, MAP_SHARED, fd_, 0);
  if (p == MAP_FAILED) {
    const int error = errno;
    file_system().close(fd_);
    fail(path_ + ": cannot map the file", error);
  }
  data_ = static_cast<const std::byte*>(p);
  guard_ = guard_mapping(p, size_);
}

MappedFile MappedFile::open(const std::string& path, const std::string& spool_folder,
                            const std::atomic<bool>* cancelled) {
  Descriptor fd(
      retry([&] { return file_system().openat(AT_FDCWD, path.c_str(), O_RDONLY | O_CLOEXEC, 0); }));
  if (!fd) fail(path + ": cannot open the file", errno);
  struct stat status {};
  if (file_system().fstat(fd.get(), &status) != 0) fail(path + ": cannot look at the file", errno);
  if (S_ISDIR(status.st_mode)) {
    throw Error(ErrorCode::kIo, path + ": is a folder, not a file");
  }
  if (!S_ISREG(status.st_mode)) return spool(fd.get(), path, spool_folder, cancelled);
  return of_descriptor(fd.release(), path);
}

MappedFile MappedFile::of_descriptor(int fd, const std::string& name) {
  Descriptor taken(fd);
  struct stat status {};
  if (file_system().fstat(fd, &status) != 0) fail(name + ": cannot look at the file", errno);
  if (status.st_size == 0) throw Error(ErrorCode::kBadInput, name + ": the file is empty");
  return MappedFile(name, taken.release(), static_cast<std::uint64_t>(status.st_size));
}

MappedFile MappedFile::spool(int fd, const std::string& name, const std::string& folder,
                             const std::atomic<bool>* cancelled) {
  const Spool to(name, folder);
  Descriptor copy(open_nameless(to.folder));
  if (!copy) to.fail_creating(errno);
  Vector<std::byte> buffer(std::size_t{1} << 20);
  RunningChecksum sum;
  std::uint64_t size = 0;
  for (;;) {
    const ssize_t n = file_system().read(fd, buffer.data(), buffer.size());
    if ((n < 0 && errno == EINTR) || (cancelled != nullptr && *cancelled)) {
      throw Error(ErrorCode::kInterrupted, name + ": interrupted while reading");
    }
    if (n < 0) fail(name + ": reading failed after " + std::to_string(size) + " bytes", errno);
    if (n == 0) break;
    const auto bytes = static_cast<std::size_t>(n);
    const int error = write_all(copy.get(), buffer.data(), bytes);
    if (error != 0) to.fail_writing(size, error);
    sum.add({buffer.data(), bytes});
    size += bytes;
  }
  if (size == 0) throw Error(ErrorCode::kBadInput, name + ": the input is empty");
  MappedFile file(name, copy.release(), size);
  file.spooled_checksum_ = sum.value();
  return file;
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : path_(std::move(other.path_)),
      fd_(std::exchange(other.fd_, -1)),
      guard_(std::exchange(other.guard_, -1)),
      size_(std::exchange(other.size_, 0)),
      data_(std::exchange(other.data_, nullptr)),
      spooled_checksum_(other.spooled_checksum_) {}

MappedFile::~MappedFile() {
  unguard_mapping(guard_);
  if (data_ != nullptr) file_system().munmap(const_cast<std::byte*>(data_), size_);
  if (fd_ >= 0) file_system().close(fd_);
}

void MappedFile::check() const {
  // The end of the last page reads as zeros without a fault.
  struct stat status {};
  const bool shortened =
      file_system().fstat(fd_, &status) == 0 && static_cast<std::uint64_t>(status.st_size) < size_;
  const auto missing =
      shortened ? std::optional(static_cast<std::uint64_t>(status.st_size)) : missing_page(guard_);
  if (!missing) return;
  throw Error(ErrorCode::kIo,
              path_ + ": byte " + std::to_string(*missing) + " of " + std::to_string(size_) +
                  " could not be read any more: the file was shortened while it was being read, or "
                  "its disk fails; run again when it is whole");
}

void MappedFile::will_need(std::uint64_t offset, std::uint64_t count) const {
  advise(offset, count, MADV_WILLNEED);
}

void MappedFile::populate(std::uint64_t offset, std::uint64_t count) const {
#ifdef MADV_POPULATE_READ
  advise(offset, count, MADV_POPULATE_READ);
#else
  will_need(offset, count);
#endif
}

void MappedFile::dont_need(std::uint64_t offset, std::uint64_t count) const {
  advise(offset, count, MADV_DONTNEED);
}

void MappedFile::dont_need_around(std::uint64_t offset, std::uint64_t count) const {
  constexpr std::uint64_t kLargestPiece = std::uint64_t{2} << 20;
  if (offset >= size_ || count == 0) return;
  const auto base = reinterpret_cast<std::uintptr_t>(data_);
  const std::uint64_t before = std::min((base + offset) % kLargestPiece, offset);
  advise(offset - before, std::min(before + count, size_) + kLargestPiece, MADV_DONTNEED);
}

void MappedFile::advise(std::uint64_t offset, std::uint64_t count, int advice) const {
  if (offset >= size_ || count == 0) return;
  const std::uint64_t page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  const std::uint64_t begin = offset / page * page;
  const std::uint64_t end = offset + std::min(count, size_ - offset);
  file_system().madvise(const_cast<std::byte*>(data_) + begin, end - begin, advice);
}

}  // namespace tetfusion
