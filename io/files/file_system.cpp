#include "io/files/file_system.h"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <climits>
#include <cstdlib>
#include <filesystem>
#include <string_view>

namespace tetfusion {

int FileSystem::openat(int folder, const char* name, int flags, mode_t mode) {
  return ::openat(folder, name, flags, mode);
}
int FileSystem::close(int fd) { return ::close(fd); }
int FileSystem::duplicate(int fd) { return ::fcntl(fd, F_DUPFD_CLOEXEC, 0); }
int FileSystem::fstat(int fd, struct stat* status) { return ::fstat(fd, status); }
int FileSystem::fstatat(int folder, const char* name, struct stat* status, int flags) {
  return ::fstatat(folder, name, status, flags);
}
int FileSystem::fstatvfs(int fd, struct statvfs* status) { return ::fstatvfs(fd, status); }
int FileSystem::access(const char* path, int mode) { return ::access(path, mode); }
ssize_t FileSystem::readlink(const char* path, char* target, std::size_t bytes) {
  return ::readlink(path, target, bytes);
}

ssize_t FileSystem::read(int fd, void* data, std::size_t bytes) { return ::read(fd, data, bytes); }
ssize_t FileSystem::write(int fd, const void* data, std::size_t bytes) {
  return ::write(fd, data, bytes);
}
ssize_t FileSystem::pread(int fd, void* data, std::size_t bytes, off_t offset) {
  return ::pread(fd, data, bytes, offset);
}
ssize_t FileSystem::pwritev(int fd, const struct iovec* parts, int count, off_t offset) {
  return ::pwritev(fd, parts, count, offset);
}
int FileSystem::fallocate(int fd, int mode, off_t offset, off_t bytes) {
  return ::fallocate(fd, mode, offset, bytes);
}
int FileSystem::ftruncate(int fd, off_t bytes) { return ::ftruncate(fd, bytes); }
int FileSystem::fchmod(int fd, mode_t mode) { return ::fchmod(fd, mode); }
int FileSystem::fsync(int fd) { return ::fsync(fd); }
int FileSystem::start_writing(int fd) { return ::sync_file_range(fd, 0, 0, SYNC_FILE_RANGE_WRITE); }
int FileSystem::flock(int fd, int operation) { return ::flock(fd, operation); }

int FileSystem::renameat(int from_folder, const char* from, int to_folder, const char* to) {
  return ::renameat(from_folder, from, to_folder, to);
}
// The way that needs no privilege (open(2), O_TMPFILE).
int FileSystem::link_descriptor(int fd, const char* name) {
  return ::linkat(AT_FDCWD, open_file_path(fd).c_str(), AT_FDCWD, name, AT_SYMLINK_FOLLOW);
}
int FileSystem::unlinkat(int folder, const char* name, int flags) {
  return ::unlinkat(folder, name, flags);
}
int FileSystem::mkdir(const char* path, mode_t mode) { return ::mkdir(path, mode); }

int FileSystem::list(int folder, std::vector<std::string>* names) {
  // The stream takes the descriptor it is given, and moves its position.
  const int fd = ::openat(folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return -1;
  DIR* stream = ::fdopendir(fd);
  if (stream == nullptr) {
    const int error = errno;
    ::close(fd);
    errno = error;
    return -1;
  }
  names->clear();
  int error = 0;
  for (;;) {
    errno = 0;
    const dirent* entry = ::readdir(stream);
    if (entry == nullptr) {
      error = errno;
      break;
    }
    const std::string_view name = entry->d_name;
    if (name != "." && name != "..") names->emplace_back(name);
  }
  ::closedir(stream);
  errno = error;
  return error == 0 ? 0 : -1;
}

void* FileSystem::mmap(void* address, std::size_t bytes, int protection, int flags, int fd,
                       off_t offset) {
  return ::mmap(address, bytes, protection, flags, fd, offset);
}
int FileSystem::munmap(void* address, std::size_t bytes) { return ::munmap(address, bytes); }
int FileSystem::madvise(void* address, std::size_t bytes, int advice) {
  return ::madvise(address, bytes, advice);
}
int FileSystem::fadvise(int fd, off_t offset, off_t bytes, int advice) {
  return ::posix_fadvise(fd, offset, bytes, advice);
}

namespace {

FileSystem the_system;
std::atomic<FileSystem*> current{&the_system};

}  // namespace

FileSystem& file_system() { return *current.load(); }

FileSystem* replace_file_system(FileSystem* other) {
  return current.exchange(other == nullptr ? &the_system : other);
}

int write_all(int fd, const void* data, std::size_t bytes) {
  const auto* at = static_cast<const std::byte*>(data);
  while (bytes > 0) {
    const ssize_t n = retry([&] { return file_system().write(fd, at, bytes); });
    if (n < 0) return errno;
    if (n == 0) return EIO;  // no progress: rather an error than a loop without end
    at += n;
    bytes -= static_cast<std::size_t>(n);
  }
  return 0;
}

int pwrite_all(int fd, const void* data, std::size_t bytes, std::uint64_t offset) {
  struct iovec part = {const_cast<void*>(data), bytes};
  return pwritev_all(fd, {&part, 1}, offset);
}

int pwritev_all(int fd, std::span<struct iovec> parts, std::uint64_t offset) {
  for (;;) {
    while (!parts.empty() && parts.front().iov_len == 0) parts = parts.subspan(1);
    if (parts.empty()) return 0;
    const int count = static_cast<int>(std::min<std::size_t>(parts.size(), IOV_MAX));
    const ssize_t n = retry(
        [&] { return file_system().pwritev(fd, parts.data(), count, static_cast<off_t>(offset)); });
    if (n < 0) return errno;
    if (n == 0) return EIO;
    offset += static_cast<std::uint64_t>(n);
    auto written = static_cast<std::size_t>(n);
    while (written > 0) {
      struct iovec& part = parts.front();
      const std::size_t step = std::min(written, part.iov_len);
      part.iov_base = static_cast<std::byte*>(part.iov_base) + step;
      part.iov_len -= step;
      written -= step;
      if (part.iov_len == 0) parts = parts.subspan(1);
    }
  }
}

int pread_all(int fd, void* data, std::size_t bytes, std::uint64_t offset) {
  auto* at = static_cast<std::byte*>(data);
  while (bytes > 0) {
    const ssize_t n =
        retry([&] { return file_system().pread(fd, at, bytes, static_cast<off_t>(offset)); });
    if (n < 0) return errno;
    if (n == 0) return kEndOfFile;
    at += n;
    offset += static_cast<std::uint64_t>(n);
    bytes -= static_cast<std::size_t>(n);
  }
  return 0;
}

bool is_left_by_nfs(std::string_view name) { return name.starts_with(".nfs"); }

std::string open_file_path(int fd) { return "/proc/self/fd/" + std::to_string(fd); }

std::string temporary_folder() {
  const char* folder = std::getenv("TMPDIR");
  return folder != nullptr && *folder != '\0' ? folder : "/tmp";
}

std::string output_folder(const std::string& output) {
  if (output == "-") return temporary_folder();
  const std::string parent = std::filesystem::path(output).parent_path().string();
  return parent.empty() ? "." : parent;
}

std::string temporary_name() {
  // Where the system has no random bytes (before Linux 3.17) the time must do.
  auto number = static_cast<std::uint64_t>(
      std::chrono::high_resolution_clock::now().time_since_epoch().count());
  std::uint64_t random = 0;
  if (::getrandom(&random, sizeof(random), 0) == static_cast<ssize_t>(sizeof(random))) {
    number = random;
  }
  return fmt::format("tetfusion-{}-{:016x}", ::getpid(), number);
}

bool is_temporary_folder(std::string_view name) {
  constexpr std::string_view kBegin = "tetfusion-";
  constexpr std::size_t kDigits = 16;
  const std::size_t dash = name.rfind('-');
  return name.starts_with(kBegin) && dash > kBegin.size() &&
         name.substr(dash + 1).size() == kDigits &&
         name.find_first_not_of("0123456789abcdef-", kBegin.size()) == std::string_view::npos;
}

int open_nameless(const std::string& folder) {
  FileSystem& system = file_system();
  const int fd = retry([&] {
    return system.openat(AT_FDCWD, folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  });
  if (fd >= 0) return fd;
  // Not every file system knows O_TMPFILE.
  constexpr int kTries = 10000;  // names left by killed runs under the same process number
  for (int i = 0; i < kTries; ++i) {
    const std::string name =
        folder + "/tetfusion-" + std::to_string(::getpid()) + "-" + std::to_string(i);
    const int named = retry([&] {
      return system.openat(AT_FDCWD, name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    });
    if (named >= 0) {
      system.unlinkat(AT_FDCWD, name.c_str(), 0);
      return named;
    }
    if (errno != EEXIST) break;
  }
  return -1;
}

int Descriptor::close() {
  if (fd_ < 0) return 0;
  const int result = file_system().close(release());
  // Interrupted or not, the descriptor is gone.
  return result == 0 || errno == EINTR ? 0 : errno;
}

}  // namespace tetfusion
