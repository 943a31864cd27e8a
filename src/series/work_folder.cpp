#include "series/work_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "base/error.h"
#include "io/files/output_file.h"

namespace tetfusion {

namespace {

bool is_ours(const std::string& name) { return name.starts_with("tetfusion-series."); }

}  // namespace

WorkFolder::WorkFolder(std::string path) : path_(std::move(path)) {
  const bool is_new = file_system().mkdir(path_.c_str(), 0700) == 0;
  if (!is_new && errno != EEXIST) fail("making");
  try {
    claim();
  } catch (const Error& error) {
    // It may be another process's by now.
    const bool is_ours_alone = is_new && error.code() != ErrorCode::kUsage;
    std::error_code ignored;
    if (is_ours_alone) std::filesystem::remove(path_, ignored);
    throw;
  }
}

void WorkFolder::fail(const char* what) const {
  throw Error(ErrorCode::kIo,
              fmt::format("{}: {} the folder failed: {}", path_, what, std::strerror(errno)));
}

// Where it is there already, what an earlier series has left goes.
void WorkFolder::claim() {
  FileSystem& system = file_system();
  folder_ = Descriptor(retry([&] {
    return system.openat(AT_FDCWD, path_.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC,
                         0);
  }));
  if (!folder_ && (errno == ENOTDIR || errno == ELOOP)) {
    throw Error(
        ErrorCode::kUsage,
        fmt::format("{}: a file or a link has this name; give another one (--scratch)", path_));
  }
  if (!folder_) fail("opening");
  const auto refuse = [&](const std::string& what) {
    throw Error(ErrorCode::kUsage, fmt::format("{}: {}", path_, what));
  };
  if (retry([&] { return system.flock(folder_.get(), LOCK_EX | LOCK_NB); }) != 0) {
    if (errno != EWOULDBLOCK) fail("locking");
    refuse("another process uses this folder: wait for it, or give another --scratch");
  }
  std::vector<std::string> names;
  if (system.list(folder_.get(), &names) != 0) fail("reading");
  for (const std::string& name : names) {
    if (is_ours(name) || is_temporary_name(name) || is_left_by_nfs(name)) continue;
    refuse(
        fmt::format("in this folder lies {}, which is not of a series: remove the folder, or "
                    "give another --scratch",
                    name));
  }
  remove_contents();
  for (const std::string& name : names) {
    std::error_code ignored;
    if (is_temporary_name(name)) std::filesystem::remove(path_ + "/" + name, ignored);
  }
}

WorkFolder::~WorkFolder() {
  if (!folder_) return;
  remove_contents();
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

void WorkFolder::remove_contents() noexcept {
  std::error_code ignored;
  for (const std::string& name : {mesh(), map(), chunks()}) {
    std::filesystem::remove_all(name, ignored);
  }
}

}  // namespace tetfusion
