// The seam between this folder and the operating system: every call on files goes through it, so
// that tests can make any of them fail.
#pragma once

#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/types.h>
#include <sys/uio.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tetfusion {

// The calls mean what POSIX and Linux say: -1 (MAP_FAILED) and errno where they fail, short
// transfers and EINTR included. This class asks the system; tests derive from it. Thread-safe.
class FileSystem {
 public:
  virtual ~FileSystem() = default;

  virtual int openat(int folder, const char* name, int flags, mode_t mode);
  virtual int close(int fd);
  virtual int duplicate(int fd);  // close-on-exec
  virtual int fstat(int fd, struct stat* status);
  virtual int fstatat(int folder, const char* name, struct stat* status, int flags);
  virtual int fstatvfs(int fd, struct statvfs* status);
  virtual int access(const char* path, int mode);
  virtual ssize_t readlink(const char* path, char* target, std::size_t bytes);

  virtual ssize_t read(int fd, void* data, std::size_t bytes);
  virtual ssize_t write(int fd, const void* data, std::size_t bytes);
  virtual ssize_t pread(int fd, void* data, std::size_t bytes, off_t offset);
  virtual ssize_t pwritev(int fd, const struct iovec* parts, int count, off_t offset);
  virtual int fallocate(int fd, int mode, off_t offset, off_t bytes);
  virtual int ftruncate(int fd, off_t bytes);
  virtual int fchmod(int fd, mode_t mode);
  virtual int fsync(int fd);
  virtual int start_writing(int fd);  // of all that is dirty; returns at once
  virtual int flock(int fd, int operation);

  virtual int renameat(int from_folder, const char* from, int to_folder, const char* to);
  // Gives an open file that has no name one, in the current folder if it is relative.
  virtual int link_descriptor(int fd, const char* name);
  virtual int unlinkat(int folder, const char* name, int flags);
  virtual int mkdir(const char* path, mode_t mode);
  virtual int list(int folder, std::vector<std::string>* names);  // unsorted, without . and ..

  virtual void* mmap(void* address, std::size_t bytes, int protection, int flags, int fd,
                     off_t offset);
  virtual int munmap(void* address, std::size_t bytes);
  virtual int madvise(void* address, std::size_t bytes, int advice);
  virtual int fadvise(int fd, off_t offset, off_t bytes, int advice);  // returns errno, or 0
};

FileSystem& file_system();

// For tests: puts another one in its place and returns the one before; nullptr means the system.
// Not while files are in use.
FileSystem* replace_file_system(FileSystem* other);

// Calls f() again as long as it is interrupted.
template <class F>
auto retry(F f) {
  for (;;) {
    const auto result = f();
    if (result != -1 || errno != EINTR) return result;
  }
}

// Transfers all of it, however many calls that takes. Return 0 or errno.
int write_all(int fd, const void* data, std::size_t bytes);
int pwrite_all(int fd, const void* data, std::size_t bytes, std::uint64_t offset);
int pwritev_all(int fd, std::span<struct iovec> parts, std::uint64_t offset);  // changes `parts`
// kEndOfFile when the file ends before.
inline constexpr int kEndOfFile = -1;
int pread_all(int fd, void* data, std::size_t bytes, std::uint64_t offset);

// Where temporary files go: TMPDIR, else /tmp.
std::string temporary_folder();
// Where an output of that name will lie; of standard output, "-", temporary_folder().
std::string output_folder(const std::string& output);
// For a folder that no other process has, on no host and in no container that shares the disk:
// numbers of processes and what hosts are called may be the same there.
std::string temporary_name();
bool is_temporary_folder(std::string_view name);  // may temporary_name() have made it?
// A file for reading and writing that has no name, or has none any more. -1 and errno on failure.
int open_nameless(const std::string& folder);

// Is it of a file that was removed while a process had it open? On network file systems it stays
// under such a name until that process is gone, or its host has noticed.
bool is_left_by_nfs(std::string_view name);

// A path that leads to an open file, even to one without a name.
std::string open_file_path(int fd);

// Owns a file descriptor.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(other.release()) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    if (this != &other) {
      static_cast<void>(close());
      fd_ = other.release();
    }
    return *this;
  }
  ~Descriptor() { static_cast<void>(close()); }

  int get() const { return fd_; }
  explicit operator bool() const { return fd_ >= 0; }
  int release() { return std::exchange(fd_, -1); }
  int close();  // 0 or errno: a network or a quota may report a lost write only here

 private:
  int fd_ = -1;
};

}  // namespace tetfusion
