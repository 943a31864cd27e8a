#include "io/store/scratch_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "base/error.h"
#include "base/numbers.h"

namespace tetfusion {

namespace {

constexpr std::string_view kPieces = ".pieces";
constexpr std::string_view kState = ".state";
constexpr std::string_view kPartSuffix = ".part";

// Only as scratch_name() writes it: no sign, no leading zero.
template <class T>
std::optional<T> parse_id(std::string_view text) {
  const auto value = number_in<T>(text);
  return value && std::to_string(*value) == text ? value : std::nullopt;
}

}  // namespace

bool is_generation_name(std::string_view name) {
  constexpr std::size_t kLongest = 200;  // a file's name has 255 at most
  return !name.empty() && name.size() <= kLongest &&
         name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") == std::string_view::npos;
}

std::string scratch_name(std::string_view generation, std::uint32_t source) {
  if (source == kStateSource) return fmt::format("{}{}", generation, kState);
  return fmt::format("{}.{}{}", generation, source, kPieces);
}

std::optional<ScratchFileName> parse_scratch_name(std::string_view name) {
  using Kind = ScratchFileName::Kind;
  if (name == kManifestName) return ScratchFileName{Kind::kManifest, {}, 0};
  const auto before = [&](std::string_view ending) {
    return name.ends_with(ending) ? name.substr(0, name.size() - ending.size())
                                  : std::string_view();
  };
  if (const auto number = before(kPartSuffix); parse_id<std::uint64_t>(number)) {
    return ScratchFileName{Kind::kPart, {}, 0};
  }
  if (const auto generation = before(kState); is_generation_name(generation)) {
    return ScratchFileName{Kind::kState, std::string(generation), kStateSource};
  }
  const auto both = before(kPieces);
  const std::size_t dot = both.find('.');
  if (dot == std::string_view::npos || !is_generation_name(both.substr(0, dot))) return {};
  const auto source = parse_id<std::uint32_t>(both.substr(dot + 1));
  if (!source || *source == kStateSource) return {};
  return ScratchFileName{Kind::kPieces, std::string(both.substr(0, dot)), *source};
}

ScratchFolder::ScratchFolder(Descriptor folder, std::string path)
    : folder_(std::move(folder)), path_(std::move(path)) {}

ScratchFolder::~ScratchFolder() { trim_spares(true); }

std::string ScratchFolder::path_of(std::string_view name) const {
  return fmt::format("{}/{}", path_, name);
}

std::vector<std::string> ScratchFolder::names() const {
  std::vector<std::string> names;
  if (file_system().list(fd(), &names) != 0) {
    throw Error(ErrorCode::kIo,
                fmt::format("{}: cannot list the scratch folder: {}", path_, std::strerror(errno)));
  }
  std::erase_if(names, is_left_by_nfs);
  std::sort(names.begin(), names.end());
  return names;
}

Descriptor ScratchFolder::open(const std::string& name) const {
  Descriptor file(retry([&] {
    return file_system().openat(fd(), name.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC, 0);
  }));
  if (file) return file;
  const int error = errno;
  if (error == ENOENT || error == ELOOP) throw_damaged(path_of(name), std::strerror(error));
  throw Error(ErrorCode::kIo,
              fmt::format("{}: cannot open it: {}", path_of(name), std::strerror(error)));
}

void ScratchFolder::write(const std::string& name, const SectionTable& table,
                          std::span<const PieceRef> pieces) {
  Descriptor file;
  std::string part;
  int error = 0;
  for (const bool again : {false, true}) {
    if (again) trim_spares(true);
    part = take_part(table.file_bytes, &file);
    error = write_sections(file.get(), table, pieces);
    if (const int closed = file.close(); error == 0) error = closed;
    if (error == 0) break;
    unlink(part);
    if (error != ENOSPC && error != EDQUOT) break;
  }
  if (error != 0) fail_writing(name, table.file_bytes, error);
  if (file_system().renameat(fd(), part.c_str(), fd(), name.c_str()) != 0) {
    error = errno;
    unlink(part);
    fail_writing(name, table.file_bytes, error);
  }
  count(table.file_bytes, 0);
}

// A file to write to, and its name: the shortest spare that is long enough, else the longest, else
// a new one.
std::string ScratchFolder::take_part(std::uint64_t bytes, Descriptor* file) {
  std::string part;
  std::string spare;
  std::uint64_t spare_bytes = 0;
  {
    const std::lock_guard lock(mutex_);
    part = fmt::format("{}{}", parts_++, kPartSuffix);
    auto found = spares_.lower_bound(bytes);
    if (found == spares_.end() && found != spares_.begin()) --found;
    if (found != spares_.end()) {
      spare_bytes = found->first;
      spare = std::move(found->second.name);
      spares_.erase(found);
    }
  }
  FileSystem& system = file_system();
  if (!spare.empty()) {
    count(0, spare_bytes);
    *file = Descriptor(retry(
        [&] { return system.openat(fd(), spare.c_str(), O_RDWR | O_NOFOLLOW | O_CLOEXEC, 0); }));
    if (*file) return spare;
    unlink(spare);
  }
  *file = Descriptor(retry([&] {
    return system.openat(fd(), part.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC,
                         0600);
  }));
  if (!*file) fail_writing(part, bytes, errno);
  return part;
}

// Renamed at once: what is half overwritten must not have the name of something whole, nor a new
// file of that name be taken for the spare one.
void ScratchFolder::retire(const std::string& name, std::uint64_t bytes) noexcept {
  try {
    const std::lock_guard lock(mutex_);
    std::string part = fmt::format("{}{}", parts_++, kPartSuffix);
    if (file_system().renameat(fd(), name.c_str(), fd(), part.c_str()) == 0) {
      spares_.emplace(bytes, Spare{std::move(part), trims_});
      return;
    }
  } catch (const std::exception&) {
  }
  unlink(name);
  count(0, bytes);
}

void ScratchFolder::trim_spares(bool all) noexcept {
  std::multimap<std::uint64_t, Spare> old;
  {
    const std::lock_guard lock(mutex_);
    for (auto spare = spares_.begin(); spare != spares_.end();) {
      const auto next = std::next(spare);
      if (all || spare->second.age < trims_) old.insert(spares_.extract(spare));
      spare = next;
    }
    ++trims_;
  }
  for (const auto& [bytes, spare] : old) {
    unlink(spare.name);
    count(0, bytes);
  }
}

int ScratchFolder::unlink(const std::string& name) const {
  return file_system().unlinkat(fd(), name.c_str(), 0) == 0 ? 0 : errno;
}

std::uint64_t ScratchFolder::free_bytes() const {
  struct statvfs status {};
  if (retry([&] { return file_system().fstatvfs(fd(), &status); }) != 0) {
    throw Error(ErrorCode::kIo, fmt::format("{}: cannot ask how much space the disk has: {}", path_,
                                            std::strerror(errno)));
  }
  return std::uint64_t{status.f_bavail} * status.f_frsize;
}

std::uint64_t ScratchFolder::peak_bytes() const {
  const std::lock_guard lock(mutex_);
  return peak_;
}

void ScratchFolder::count(std::uint64_t more, std::uint64_t less) {
  const std::lock_guard lock(mutex_);
  bytes_ += more;
  bytes_ -= std::min(less, bytes_);
  peak_ = std::max(peak_, bytes_);
}

void ScratchFolder::remember_failure(const std::string& message) noexcept {
  const std::lock_guard lock(mutex_);
  try {
    if (failure_.empty()) failure_ = message;
  } catch (const std::exception&) {
    failure_.assign(1, '?');  // no memory for words
  }
}

void ScratchFolder::throw_failure() const {
  const std::lock_guard lock(mutex_);
  if (!failure_.empty()) throw Error(ErrorCode::kIo, failure_);
}

void ScratchFolder::fail_writing(const std::string& name, std::uint64_t bytes, int error) const {
  if (error != ENOSPC && error != EDQUOT) {
    throw Error(ErrorCode::kIo,
                fmt::format("writing {} ({}) failed: {}; see whether its disk fails", path_of(name),
                            format_bytes(bytes), std::strerror(error)));
  }
  std::string room = "less is left";
  struct statvfs status {};
  if (file_system().fstatvfs(fd(), &status) == 0) {
    room = format_bytes(std::uint64_t{status.f_bavail} * status.f_frsize) + " is left";
  }
  throw Error(ErrorCode::kIo,
              fmt::format("no space left on the device for {}: {} needed, {} ({}); free some, or "
                          "use another scratch folder (--scratch)",
                          path_of(name), format_bytes(bytes), room, std::strerror(error)));
}

}  // namespace tetfusion
