#include "support/faulty_file_system.h"

#include <fcntl.h>
#include <sys/mman.h>

#include <algorithm>
#include <vector>

namespace tetfusion::testing {

FaultyFileSystem::FaultyFileSystem() : before_(replace_file_system(this)) {}
FaultyFileSystem::~FaultyFileSystem() { replace_file_system(before_); }

void FaultyFileSystem::fail(std::int64_t n, int error) {
  fail_error_ = error;
  fail_at_ = n;
}
void FaultyFileSystem::cut_short(std::int64_t n) { short_at_ = n; }
void FaultyFileSystem::die(std::int64_t n) { die_at_ = n; }
void FaultyFileSystem::die_torn(std::int64_t n) {
  cut_short(n);
  die(n + 1);
}
void FaultyFileSystem::fail_all(Call call, int error) {
  fail_call_ = call;
  fail_call_error_ = error;
}
void FaultyFileSystem::fill_up_after(std::int64_t bytes) { room_ = bytes; }

int FaultyFileSystem::strike(Call call, std::int64_t* number) {
  if (watch_) watch_(call);
  const std::int64_t n = calls_++;
  if (number != nullptr) *number = n;
  int error = 0;
  if (fail_call_error_ != 0 && call == fail_call_) error = fail_call_error_;
  if (n == fail_at_) error = fail_error_;
  if (die_at_ != kNever && n >= die_at_) error = EIO;
  if (error != 0) {
    struck_ = true;
    errno = error;
  }
  return error;
}

bool FaultyFileSystem::is_short(std::int64_t number) {
  if (number != short_at_) return false;
  struck_ = true;
  return true;
}

std::size_t FaultyFileSystem::room(std::size_t bytes) {
  if (room_ == kNever) return bytes;
  const auto taken = std::min(static_cast<std::int64_t>(bytes), room_.load());
  room_ -= taken;
  return static_cast<std::size_t>(taken);
}

int FaultyFileSystem::openat(int folder, const char* name, int flags, mode_t mode) {
  if (strike(Call::kOpen) != 0) return -1;
  if (!nameless_ && (flags & O_TMPFILE) == O_TMPFILE) {
    errno = EOPNOTSUPP;
    return -1;
  }
  return FileSystem::openat(folder, name, flags, mode);
}
// Closes in any case, as Linux does, and as the end of a process does.
int FaultyFileSystem::close(int fd) {
  const int error = strike(Call::kClose);
  const int result = FileSystem::close(fd);
  if (error == 0) return result;
  errno = error;
  return -1;
}
int FaultyFileSystem::duplicate(int fd) {
  return strike(Call::kDuplicate) != 0 ? -1 : FileSystem::duplicate(fd);
}
int FaultyFileSystem::fstat(int fd, struct stat* status) {
  return strike(Call::kStat) != 0 ? -1 : FileSystem::fstat(fd, status);
}
int FaultyFileSystem::fstatat(int folder, const char* name, struct stat* status, int flags) {
  return strike(Call::kStat) != 0 ? -1 : FileSystem::fstatat(folder, name, status, flags);
}
int FaultyFileSystem::fstatvfs(int fd, struct statvfs* status) {
  return strike(Call::kSpace) != 0 ? -1 : FileSystem::fstatvfs(fd, status);
}
int FaultyFileSystem::access(const char* path, int mode) {
  return strike(Call::kAccess) != 0 ? -1 : FileSystem::access(path, mode);
}
ssize_t FaultyFileSystem::readlink(const char* path, char* target, std::size_t bytes) {
  return strike(Call::kReadLink) != 0 ? -1 : FileSystem::readlink(path, target, bytes);
}

ssize_t FaultyFileSystem::read(int fd, void* data, std::size_t bytes) {
  std::int64_t number = 0;
  if (strike(Call::kRead, &number) != 0) return -1;
  return FileSystem::read(fd, data, is_short(number) ? (bytes + 1) / 2 : bytes);
}
ssize_t FaultyFileSystem::pread(int fd, void* data, std::size_t bytes, off_t offset) {
  std::int64_t number = 0;
  if (strike(Call::kRead, &number) != 0) return -1;
  return FileSystem::pread(fd, data, is_short(number) ? (bytes + 1) / 2 : bytes, offset);
}
ssize_t FaultyFileSystem::write(int fd, const void* data, std::size_t bytes) {
  std::int64_t number = 0;
  if (strike(Call::kWrite, &number) != 0) return -1;
  const std::size_t taken = room(is_short(number) ? (bytes + 1) / 2 : bytes);
  if (taken > 0 || bytes == 0) return FileSystem::write(fd, data, taken);
  struck_ = true;
  errno = ENOSPC;
  return -1;
}
ssize_t FaultyFileSystem::pwritev(int fd, const struct iovec* parts, int count, off_t offset) {
  std::int64_t number = 0;
  if (strike(Call::kWrite, &number) != 0) return -1;
  std::vector<struct iovec> some(parts, parts + count);
  std::size_t bytes = 0;
  for (const struct iovec& part : some) bytes += part.iov_len;
  std::size_t taken = room(is_short(number) ? (bytes + 1) / 2 : bytes);
  if (taken == 0 && bytes > 0) {
    struck_ = true;
    errno = ENOSPC;
    return -1;
  }
  for (struct iovec& part : some) {
    part.iov_len = std::min(part.iov_len, taken);
    taken -= part.iov_len;
  }
  return FileSystem::pwritev(fd, some.data(), count, offset);
}

int FaultyFileSystem::fallocate(int fd, int mode, off_t offset, off_t bytes) {
  if (strike(Call::kAllocate) != 0) return -1;
  if (room_ != kNever && bytes > room_) {
    struck_ = true;
    errno = ENOSPC;
    return -1;
  }
  return FileSystem::fallocate(fd, mode, offset, bytes);
}
int FaultyFileSystem::ftruncate(int fd, off_t bytes) {
  return strike(Call::kTruncate) != 0 ? -1 : FileSystem::ftruncate(fd, bytes);
}
int FaultyFileSystem::fchmod(int fd, mode_t mode) {
  return strike(Call::kChangeMode) != 0 ? -1 : FileSystem::fchmod(fd, mode);
}
int FaultyFileSystem::fsync(int fd) {
  // A test cannot tell whether the disk has it, and disks are slow.
  static_cast<void>(fd);
  return strike(Call::kSync) != 0 ? -1 : 0;
}
int FaultyFileSystem::start_writing(int fd) {
  return strike(Call::kAdvise) != 0 ? -1 : FileSystem::start_writing(fd);
}
int FaultyFileSystem::flock(int fd, int operation) {
  return strike(Call::kLock) != 0 ? -1 : FileSystem::flock(fd, operation);
}

int FaultyFileSystem::renameat(int from_folder, const char* from, int to_folder, const char* to) {
  return strike(Call::kRename) != 0 ? -1 : FileSystem::renameat(from_folder, from, to_folder, to);
}
int FaultyFileSystem::link_descriptor(int fd, const char* name) {
  return strike(Call::kLink) != 0 ? -1 : FileSystem::link_descriptor(fd, name);
}
int FaultyFileSystem::unlinkat(int folder, const char* name, int flags) {
  return strike(Call::kUnlink) != 0 ? -1 : FileSystem::unlinkat(folder, name, flags);
}
int FaultyFileSystem::mkdir(const char* path, mode_t mode) {
  return strike(Call::kMakeFolder) != 0 ? -1 : FileSystem::mkdir(path, mode);
}
int FaultyFileSystem::list(int folder, std::vector<std::string>* names) {
  return strike(Call::kList) != 0 ? -1 : FileSystem::list(folder, names);
}

void* FaultyFileSystem::mmap(void* address, std::size_t bytes, int protection, int flags, int fd,
                             off_t offset) {
  if (strike(Call::kMap) != 0) return MAP_FAILED;
  return FileSystem::mmap(address, bytes, protection, flags, fd, offset);
}
int FaultyFileSystem::madvise(void* address, std::size_t bytes, int advice) {
  return strike(Call::kAdvise) != 0 ? -1 : FileSystem::madvise(address, bytes, advice);
}
int FaultyFileSystem::fadvise(int fd, off_t offset, off_t bytes, int advice) {
  const int error = strike(Call::kAdvise);
  return error != 0 ? error : FileSystem::fadvise(fd, offset, bytes, advice);
}

}  // namespace tetfusion::testing
