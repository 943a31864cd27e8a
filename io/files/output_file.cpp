#include "io/files/output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "base/error.h"
#include "base/numbers.h"
#include "io/files/file_system.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kWriteBehind = std::uint64_t{64} << 20;
constexpr int kMaxLinks = 40;           // as many as Linux follows
constexpr int kMaxTemporaries = 10000;  // left by killed runs under the same process number

constexpr std::string_view kTemporary = ".tetfusion-";  // then the process and a number
constexpr std::string_view kPart = ".part";

struct Target {
  std::string path;        // where links lead
  std::string folder;      // what holds it; "." for a bare name
  bool exists = false;     // a regular file of that name is there
  bool is_stream = false;  // standard output, a device or a pipe: written in place
  mode_t mode = 0;         // of the file that is there
};

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw Error(ErrorCode::kIo, fmt::format("cannot write {}: {}", path, why));
}

std::string follow_links(const std::string& path) {
  std::filesystem::path current = path;
  for (int i = 0; i < kMaxLinks; ++i) {
    std::string target(PATH_MAX, '\0');
    const ssize_t n = file_system().readlink(current.c_str(), target.data(), target.size());
    if (n < 0) {
      // Not a link, or nothing at all.
      if (errno == EINVAL || errno == ENOENT || errno == ENOTDIR) return current.string();
      refuse(path, std::strerror(errno));
    }
    const std::filesystem::path next = target.substr(0, static_cast<std::size_t>(n));
    current = next.is_absolute() ? next : current.parent_path() / next;
  }
  refuse(path, "its symbolic links lead round in a circle");
}

int look_at(const std::string& path, struct stat* status) {
  return file_system().fstatat(AT_FDCWD, path.c_str(), status, 0);
}

void check_folder(const std::string& path, const std::string& folder) {
  struct stat status {};
  if (look_at(folder, &status) != 0) {
    if (errno == ENOENT) {
      refuse(path, fmt::format("the folder {} does not exist; create it first", folder));
    }
    refuse(path, fmt::format("{}: {}", folder, std::strerror(errno)));
  }
  if (!S_ISDIR(status.st_mode)) refuse(path, fmt::format("{} is not a folder", folder));
  if (file_system().access(folder.c_str(), W_OK | X_OK) != 0) {
    refuse(path, fmt::format("nothing can be created in the folder {}: {}", folder,
                             std::strerror(errno)));
  }
}

// All that can be known about a target without creating anything. Throws what check_output_path()
// promises.
Target resolve(const std::string& path) {
  Target target;
  if (path.empty()) refuse("the output", "its name is empty");
  if (path == "-") {
    target.is_stream = true;
    return target;
  }
  struct stat status {};
  // Behind a link like /dev/stdout there may be a pipe, which has no name to follow the link to.
  const bool is_special =
      look_at(path, &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
  target.path = is_special ? path : follow_links(path);
  if (look_at(target.path, &status) == 0) {
    if (S_ISDIR(status.st_mode)) refuse(path, "it is a folder; give a file name");
    if (file_system().access(target.path.c_str(), W_OK) != 0) refuse(path, std::strerror(errno));
    target.is_stream = !S_ISREG(status.st_mode);
    target.exists = !target.is_stream;
    target.mode = status.st_mode & 0777;
    if (target.is_stream) return target;
  } else if (errno != ENOENT) {
    refuse(path, std::strerror(errno));
  }
  const std::filesystem::path parts = target.path;
  if (parts.filename().empty()) {
    refuse(path, fmt::format("the folder {} does not exist; create it first", target.path));
  }
  target.folder = parts.has_parent_path() ? parts.parent_path().string() : ".";
  check_folder(path, target.folder);
  return target;
}

}  // namespace

void check_output_path(const std::string& path) { resolve(path); }

OutputFile::OutputFile(const std::string& path, Access access)
    : path_(path), buffer_(std::make_unique_for_overwrite<std::byte[]>(kBufferBytes)) {
  const Target target = resolve(path);
  if (!target.is_stream) {
    target_ = target.path;
    open_temporary();
    // A file that is replaced keeps its permissions; failing to is no reason to lose the result.
    if (target.exists) static_cast<void>(file_system().fchmod(fd_, target.mode));
    return;
  }
  const int fd = path == "-" ? file_system().duplicate(STDOUT_FILENO) : retry([&] {
    return file_system().openat(AT_FDCWD, target.path.c_str(), O_WRONLY | O_CLOEXEC, 0);
  });
  if (fd < 0) fail("opening", errno);
  if (access == Access::kAppend) {
    fd_ = fd;
  } else {
    stream_ = fd;
    open_spool();
  }
}

bool is_temporary_name(std::string_view name) {
  return name.starts_with(kTemporary) && name.ends_with(kPart);
}

OutputFile::~OutputFile() {
  if (fd_ >= 0) file_system().close(fd_);
  if (stream_ >= 0) file_system().close(stream_);
  if (!temporary_.empty()) file_system().unlinkat(AT_FDCWD, temporary_.c_str(), 0);
}

// Calls make(name) with one temporary name after the other until it is free, and returns that;
// empty where anything else is in the way, and errno says what. They are short names of their own:
// the target's may be as long as the file system allows.
template <class F>
std::string OutputFile::take_temporary_name(F make) const {
  const std::filesystem::path folder = std::filesystem::path(target_).parent_path();
  for (int i = 0; i < kMaxTemporaries; ++i) {
    std::string name =
        (folder / fmt::format("{}{}-{}{}", kTemporary, ::getpid(), i, kPart)).string();
    if (retry([&] { return make(name.c_str()); }) >= 0) return name;
    if (errno != EEXIST) return {};
  }
  errno = EEXIST;
  return {};
}

void OutputFile::open_temporary() {
  if (open_without_name()) return;
  temporary_ = take_temporary_name([&](const char* name) {
    fd_ = file_system().openat(AT_FDCWD, name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    return fd_;
  });
  if (temporary_.empty()) fail("creating a temporary file beside", errno);
}

// Giving such a file a name must not fail after hours of work: it is tried first, with another one.
bool OutputFile::open_without_name() {
  FileSystem& system = file_system();
  const std::filesystem::path parent = std::filesystem::path(target_).parent_path();
  const std::string folder = parent.empty() ? "." : parent.string();
  const auto open = [&] {
    return Descriptor(retry([&] {
      return system.openat(AT_FDCWD, folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
    }));
  };
  Descriptor trial = open();
  if (!trial) return false;
  const std::string name = take_temporary_name(
      [&](const char* free) { return system.link_descriptor(trial.get(), free); });
  if (name.empty()) return false;
  if (system.unlinkat(AT_FDCWD, name.c_str(), 0) != 0) {
    temporary_ = name;
    fd_ = trial.release();
    return true;
  }
  fd_ = open().release();
  nameless_ = fd_ >= 0;
  return nameless_;
}

void OutputFile::open_spool() {
  fd_ = open_nameless(temporary_folder());
  if (fd_ < 0) {
    const int reason = errno;
    file_system().close(stream_);
    stream_ = -1;
    throw Error(
        ErrorCode::kIo,
        fmt::format("creating a temporary file for standard output in {} (TMPDIR) failed: {}",
                    temporary_folder(), std::strerror(reason)));
  }
  spooled_ = true;
}

void OutputFile::expect(std::uint64_t bytes) {
  expected_ = bytes;
  if ((target_.empty() && !spooled_) || bytes == 0) return;
  const auto length = static_cast<off_t>(bytes);
  if (retry([&] { return file_system().fallocate(fd_, FALLOC_FL_KEEP_SIZE, 0, length); }) == 0) {
    return;
  }
  // Other errors mean that this file system sets nothing aside.
  if (errno == ENOSPC || errno == EDQUOT || errno == EFBIG) fail("setting space aside for", errno);
}

void OutputFile::append(const void* data, std::size_t bytes) {
  size_ += bytes;
  if (buffered_ + bytes < kBufferBytes) {
    std::memcpy(buffer_.get() + buffered_, data, bytes);
    buffered_ += bytes;
    return;
  }
  flush();
  if (bytes >= kBufferBytes / 2) {
    write_out(data, bytes);
    return;
  }
  std::memcpy(buffer_.get(), data, bytes);
  buffered_ = bytes;
}

void OutputFile::overwrite(std::uint64_t offset, const void* data, std::size_t bytes) {
  if (offset > size_ || bytes > size_ - offset) {
    throw std::logic_error("OutputFile::overwrite() past the end");
  }
  if (target_.empty() && !spooled_) throw std::logic_error("a stream cannot be patched");
  if (offset + bytes > written_) flush();
  const int error = pwrite_all(fd_, data, bytes, offset);
  if (error != 0) fail("writing", error);
}

std::uint64_t OutputFile::leave_room(std::uint64_t bytes) {
  if (!can_leave_room()) throw std::logic_error("a stream has to be written in order");
  flush();
  const std::uint64_t offset = size_;
  size_ += bytes;
  written_ += bytes;
  return offset;
}

void OutputFile::place(std::uint64_t offset, const void* data, std::size_t bytes) const {
  if (offset > written_ || bytes > written_ - offset) {
    throw std::logic_error("OutputFile::place() past the end");
  }
  const int error = pwrite_all(fd_, data, bytes, offset);
  if (error != 0) fail("writing", error);
  write_behind(bytes);
}

// So that little is left for the disk to do in commit(). What fails here fails there, too.
void OutputFile::write_behind(std::uint64_t bytes) const {
  if (target_.empty() || behind_.fetch_add(bytes) + bytes < kWriteBehind) return;
  behind_ = 0;
  static_cast<void>(file_system().start_writing(fd_));
}

void OutputFile::flush() {
  write_out(buffer_.get(), buffered_);
  buffered_ = 0;
}

void OutputFile::write_out(const void* data, std::size_t bytes) {
  const int error =
      can_leave_room() ? pwrite_all(fd_, data, bytes, written_) : write_all(fd_, data, bytes);
  if (error != 0) fail("writing", error);
  written_ += bytes;
  write_behind(bytes);
}

MappedFile OutputFile::read_back() {
  if (!can_leave_room()) throw std::logic_error("a stream cannot be read back");
  flush();
  const int copy = file_system().duplicate(fd_);
  if (copy < 0) fail("reading back", errno);
  return MappedFile::of_descriptor(copy, path_);
}

std::string OutputFile::path_to_read() {
  if (target_.empty() && !spooled_) throw std::logic_error("a stream cannot be read again");
  flush();
  return temporary_.empty() ? open_file_path(fd_) : temporary_;
}

void OutputFile::finish() {
  FileSystem& system = file_system();
  flush();
  finished_ = true;
  if (target_.empty()) {
    if (spooled_) copy_spool();
    // A device may refuse to sync, but close() can still report a lost write (a network pipe, a
    // quota).
    close(spooled_ ? &stream_ : &fd_);
    return;
  }
  // Space set aside beyond the end would stay with the file.
  const auto length = static_cast<off_t>(written_);
  if (expected_ > written_ && retry([&] { return system.ftruncate(fd_, length); }) != 0) {
    fail("writing", errno);
  }
  if (retry([&] { return system.fsync(fd_); }) != 0) fail("syncing", errno);
}

void OutputFile::commit(const std::function<void()>& before_name) {
  if (!finished_) finish();
  if (target_.empty()) {
    if (before_name) before_name();
    return;
  }
  FileSystem& system = file_system();
  if (nameless_) {
    temporary_ =
        take_temporary_name([&](const char* name) { return system.link_descriptor(fd_, name); });
    if (temporary_.empty()) fail("naming", errno);
  }
  close(&fd_);
  if (before_name) before_name();
  if (system.renameat(AT_FDCWD, temporary_.c_str(), AT_FDCWD, target_.c_str()) != 0) {
    fail("renaming a temporary file to", errno);
  }
  temporary_.clear();
  // The file is whole and has its name. A folder that cannot be synced (some network file systems)
  // only means that a power cut in the next seconds could bring the old file back.
  const auto folder = std::filesystem::path(target_).parent_path();
  const Descriptor opened(system.openat(AT_FDCWD, folder.empty() ? "." : folder.c_str(),
                                        O_RDONLY | O_DIRECTORY | O_CLOEXEC, 0));
  if (opened) static_cast<void>(system.fsync(opened.get()));
}

void OutputFile::close(int* fd) {
  Descriptor last(std::exchange(*fd, -1));
  const int error = last.close();
  if (error != 0) fail("closing", error);
}

void OutputFile::copy_spool() {
  std::uint64_t offset = 0;
  while (offset < written_) {
    const auto want =
        static_cast<std::size_t>(std::min<std::uint64_t>(kBufferBytes, written_ - offset));
    const ssize_t n = retry(
        [&] { return file_system().pread(fd_, buffer_.get(), want, static_cast<off_t>(offset)); });
    if (n <= 0) fail("reading the temporary file of", n < 0 ? errno : EIO);
    const int error = write_all(stream_, buffer_.get(), static_cast<std::size_t>(n));
    if (error != 0) {
      spooled_ = false;  // it is not the copy that has no room
      written_ = offset;
      fail("writing", error);
    }
    offset += static_cast<std::uint64_t>(n);
  }
}

void OutputFile::fail(const char* what, int error) const {
  const std::string name = path_ == "-" ? "standard output" : path_;
  std::string message =
      fmt::format("{} {} failed at byte {}: {}", what, name, written_, std::strerror(error));
  if (error == ENOSPC || error == EDQUOT) {
    const std::uint64_t needed = std::max(expected_, size_);
    message = fmt::format(
        "no space left on the device for {}: needed {} {} ({} bytes), {} were written; free some "
        "or use another folder",
        spooled_ ? "the temporary copy of " + name + " (TMPDIR names its folder)" : name,
        expected_ > size_ ? "about" : "at least", format_bytes(needed), needed,
        format_bytes(written_));
  } else if (error == EPIPE) {
    message = fmt::format("writing {} failed: its reader has gone", name);
  }
  throw Error(ErrorCode::kIo, message);
}

}  // namespace tetfusion
