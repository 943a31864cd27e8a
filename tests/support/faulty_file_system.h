// Stands in the place of the system's file calls while it lives, and lets any of them go wrong.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "io/files/file_system.h"

namespace tetfusion::testing {

// Thread-safe, except for before().
class FaultyFileSystem : public FileSystem {
 public:
  enum class Call {
    kOpen,
    kClose,
    kDuplicate,
    kStat,
    kSpace,
    kAccess,
    kReadLink,
    kRead,
    kWrite,
    kAllocate,
    kTruncate,
    kChangeMode,
    kSync,
    kLock,
    kRename,
    kLink,
    kUnlink,
    kMakeFolder,
    kList,
    kMap,
    kAdvise
  };
  static constexpr std::int64_t kNever = -1;

  FaultyFileSystem();
  ~FaultyFileSystem() override;

  // Calls are counted from 0, munmap() excepted: it cannot fail.
  std::int64_t calls() const { return calls_; }
  // Call n fails with this error, once.
  void fail(std::int64_t n, int error);
  // Call n, if it moves bytes, moves half of them.
  void cut_short(std::int64_t n);
  // Call n and all after it fail and do nothing, as if the process had been killed before it.
  void die(std::int64_t n);
  // The same, but if call n moves bytes, it still moves half of them.
  void die_torn(std::int64_t n);
  // Every call of this kind fails.
  void fail_all(Call call, int error);
  // The disk is full after so many more bytes of new space.
  void fill_up_after(std::int64_t bytes);
  // The file system knows no files without names (O_TMPFILE).
  void forbid_nameless() { nameless_ = false; }
  // Before each call; may do anything but use this file system.
  void before(std::function<void(Call)> watch) { watch_ = std::move(watch); }
  bool struck() const { return struck_; }  // has anything gone wrong?

  int openat(int folder, const char* name, int flags, mode_t mode) override;
  int close(int fd) override;
  int duplicate(int fd) override;
  int fstat(int fd, struct stat* status) override;
  int fstatat(int folder, const char* name, struct stat* status, int flags) override;
  int fstatvfs(int fd, struct statvfs* status) override;
  int access(const char* path, int mode) override;
  ssize_t readlink(const char* path, char* target, std::size_t bytes) override;
  ssize_t read(int fd, void* data, std::size_t bytes) override;
  ssize_t write(int fd, const void* data, std::size_t bytes) override;
  ssize_t pread(int fd, void* data, std::size_t bytes, off_t offset) override;
  ssize_t pwritev(int fd, const struct iovec* parts, int count, off_t offset) override;
  int fallocate(int fd, int mode, off_t offset, off_t bytes) override;
  int ftruncate(int fd, off_t bytes) override;
  int fchmod(int fd, mode_t mode) override;
  int fsync(int fd) override;
  int start_writing(int fd) override;
  int flock(int fd, int operation) override;
  int renameat(int from_folder, const char* from, int to_folder, const char* to) override;
  int link_descriptor(int fd, const char* name) override;
  int unlinkat(int folder, const char* name, int flags) override;
  int mkdir(const char* path, mode_t mode) override;
  int list(int folder, std::vector<std::string>* names) override;
  void* mmap(void* address, std::size_t bytes, int protection, int flags, int fd,
             off_t offset) override;
  int madvise(void* address, std::size_t bytes, int advice) override;
  int fadvise(int fd, off_t offset, off_t bytes, int advice) override;

 private:
  int strike(Call call, std::int64_t* number = nullptr);  // the error of this call; 0: none
  bool is_short(std::int64_t number);
  std::size_t room(std::size_t bytes);  // how much of it the disk still takes

  FileSystem* before_;
  std::atomic<std::int64_t> calls_{0};
  std::atomic<bool> struck_{false};
  std::atomic<std::int64_t> fail_at_{kNever};
  std::atomic<int> fail_error_{0};
  std::atomic<std::int64_t> short_at_{kNever};
  std::atomic<std::int64_t> die_at_{kNever};
  std::atomic<Call> fail_call_{Call::kOpen};
  std::atomic<int> fail_call_error_{0};
  std::atomic<std::int64_t> room_{kNever};
  std::atomic<bool> nameless_{true};
  std::function<void(Call)> watch_;
};

}  // namespace tetfusion::testing
