#include "io/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>
#include <vector>

#include "base/error.h"
#include "io/fault_guard.h"

namespace tetfusion {

namespace {

[[noreturn]] void fail(const std::string& what, int error) {
  throw Error(ErrorCode::kIo, what + ": " + std::strerror(error));
}

// Closes a file descriptor unless it is released.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }
  int release() { return std::exchange(fd_, -1); }

 private:
  int fd_;
};

// A file without a name. Not every file system knows O_TMPFILE.
int open_unnamed(const std::string& folder) {
  const int fd = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (fd >= 0) return fd;
  std::string name = folder + "/tetfusion-XXXXXX";
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named < 0) fail("cannot make a temporary file in " + folder + " (set TMPDIR)", errno);
  ::unlink(name.c_str());
  return named;
}

void write_all(int fd, const char* data, std::size_t count, const std::string& what) {
  while (count > 0) {
    const ssize_t n = ::write(fd, data, count);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail(what, errno);
    data += n;
    count -= static_cast<std::size_t>(n);
  }
}

}  // namespace

MappedFile::MappedFile(std::string path, int fd, std::uint64_t size)
    : path_(std::move(path)), fd_(fd), size_(size) {
  void* p = ::mmap(nullptr, size_, PROT_READ, MAP_SHARED, fd_, 0);
  if (p == MAP_FAILED) {
    const int error = errno;
    ::close(fd_);
    fail(path_ + ": cannot map the file", error);
  }
  data_ = static_cast<const std::byte*>(p);
  guard_ = guard_mapping(p, size_);
}

MappedFile MappedFile::open(const std::string& path) {
  Descriptor fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (fd.get() < 0) fail(path + ": cannot open the file", errno);
  struct stat status {};
  if (::fstat(fd.get(), &status) != 0) fail(path + ": cannot look at the file", errno);
  if (S_ISDIR(status.st_mode)) {
    throw Error(ErrorCode::kIo, path + ": is a folder, not a file");
  }
  if (!S_ISREG(status.st_mode)) return spool(fd.get(), path);
  if (status.st_size == 0) throw Error(ErrorCode::kBadInput, path + ": the file is empty");
  return MappedFile(path, fd.release(), static_cast<std::uint64_t>(status.st_size));
}

MappedFile MappedFile::spool(int fd, const std::string& name) {
  const char* folder = std::getenv("TMPDIR");
  const std::string where = folder != nullptr && *folder != '\0' ? folder : "/tmp";
  Descriptor copy(open_unnamed(where));
  std::vector<char> buffer(std::size_t{1} << 20);
  std::uint64_t size = 0;
  for (;;) {
    const ssize_t n = ::read(fd, buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) {
      throw Error(ErrorCode::kInterrupted, name + ": interrupted while reading");
    }
    if (n < 0) fail(name + ": reading failed after " + std::to_string(size) + " bytes", errno);
    if (n == 0) break;
    write_all(copy.get(), buffer.data(), static_cast<std::size_t>(n),
              name + ": cannot spool to " + where + " (set TMPDIR)");
    size += static_cast<std::uint64_t>(n);
  }
  if (size == 0) throw Error(ErrorCode::kBadInput, name + ": the input is empty");
  return MappedFile(name, copy.release(), size);
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : path_(std::move(other.path_)),
      fd_(std::exchange(other.fd_, -1)),
      guard_(std::exchange(other.guard_, -1)),
      size_(std::exchange(other.size_, 0)),
      data_(std::exchange(other.data_, nullptr)) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
  if (this != &other) {
    release();
    path_ = std::move(other.path_);
    fd_ = std::exchange(other.fd_, -1);
    guard_ = std::exchange(other.guard_, -1);
    size_ = std::exchange(other.size_, 0);
    data_ = std::exchange(other.data_, nullptr);
  }
  return *this;
}

MappedFile::~MappedFile() { release(); }

void MappedFile::check() const {
  // The end of the last page reads as zeros without a fault.
  struct stat status {};
  const bool shortened =
      ::fstat(fd_, &status) == 0 && static_cast<std::uint64_t>(status.st_size) < size_;
  const auto missing =
      shortened ? std::optional(static_cast<std::uint64_t>(status.st_size)) : missing_page(guard_);
  if (!missing) return;
  throw Error(ErrorCode::kIo,
              path_ + ": byte " + std::to_string(*missing) + " of " + std::to_string(size_) +
                  " could not be read any more: the file was shortened while it was being read, or "
                  "its disk fails; run again when it is whole");
}

void MappedFile::release() noexcept {
  unguard_mapping(guard_);
  guard_ = -1;
  if (data_ != nullptr) ::munmap(const_cast<std::byte*>(data_), size_);
  if (fd_ >= 0) ::close(fd_);
  data_ = nullptr;
  fd_ = -1;
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

void MappedFile::advise(std::uint64_t offset, std::uint64_t count, int advice) const {
  if (offset >= size_ || count == 0) return;
  const std::uint64_t page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  const std::uint64_t begin = offset / page * page;
  const std::uint64_t end = offset + std::min(count, size_ - offset);
  ::madvise(const_cast<std::byte*>(data_) + begin, end - begin, advice);
}

}  // namespace tetfusion
