// The out-of-core side: a folder that a killed run can be resumed from (FORMAT.md).
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

#include "base/error.h"
#include "base/numbers.h"
#include "io/files/file_system.h"
#include "io/store/durable_sync.h"
#include "io/store/manifest.h"
#include "io/store/piece_store_disk.h"
#include "io/store/scratch.h"
#include "io/store/scratch_folder.h"
#include "io/store/section_file.h"

namespace tetfusion {

namespace {

// A generation that is whole.
struct Found {
  std::shared_ptr<Generation> generation;
  std::vector<SectionTable> tables;  // of all its files
};

// A committed one, and what belongs to it.
struct FoundCommit {
  Found found;
  std::vector<Found> kept;
};

std::unique_ptr<BucketPieces> map_sections(const std::shared_ptr<Generation>& generation,
                                           const SectionTable& table) {
  std::vector<PieceOnDisk> pieces;
  for (const Section& section : table.sections) pieces.push_back({table.source, section});
  return load_pieces(generation, std::move(pieces));
}

class DiskScratch : public Scratch {
 public:
  // `fresh`: there is nothing to resume.
  DiskScratch(std::shared_ptr<ScratchFolder> folder, std::shared_ptr<Manifest> manifest, bool fresh)
      : folder_(std::move(folder)),
        manifest_(std::move(manifest)),
        ready_(fresh),
        sync_(folder_, manifest_) {}
  ~DiskScratch() override;

  std::unique_ptr<PieceStore> begin(const std::string& name) override;
  void commit(const std::string& name, std::span<const std::byte> state) override;
  void keep(const std::string& name) override;
  std::optional<Checkpoint> resume() override;
  void check() const override { folder_->throw_failure(); }
  void drop_spares() override { sync_.drop_spares(); }
  void remove() override;
  std::uint64_t peak_bytes() const override { return folder_->peak_bytes(); }

 private:
  std::shared_ptr<Generation> begun(const std::string& name) const;
  Found find(const KeptGeneration& record, bool durable,
             const std::vector<std::string>& names) const;
  Found find_pieces(const Commit& commit, const std::vector<std::string>& names) const;
  FoundCommit find(const Commit& commit, const std::vector<std::string>& names) const;
  std::unique_ptr<PieceStore> open(const Found& found, Vector<std::byte>* state);
  Checkpoint open(const FoundCommit& commit);

  std::shared_ptr<ScratchFolder> folder_;
  std::shared_ptr<Manifest> manifest_;
  bool ready_;  // nothing of an interrupted run is in the way
  std::map<std::string, std::weak_ptr<Generation>> begun_;
  DurableSync sync_;
};

// What was not committed cannot be resumed: no folder is left behind for that.
DiskScratch::~DiskScratch() {
  if (!ready_ || !sync_.empty()) return;
  try {
    remove();
  } catch (const std::exception&) {
  }
}

std::unique_ptr<PieceStore> DiskScratch::begin(const std::string& name) {
  if (!ready_) throw std::logic_error("begin() before resume()");
  if (!is_generation_name(name)) throw std::logic_error("not a generation's name: " + name);
  std::erase_if(begun_, [](const auto& entry) { return entry.second.expired(); });
  if (begun_.contains(name) || sync_.holds(name)) {
    throw std::logic_error("a generation of this name is in use: " + name);
  }
  auto generation = std::make_shared<Generation>(folder_, name);
  begun_[name] = generation;
  return std::make_unique<DiskPieceStore>(std::move(generation));
}

std::shared_ptr<Generation> DiskScratch::begun(const std::string& name) const {
  const auto found = begun_.find(name);
  std::shared_ptr<Generation> generation = found == begun_.end() ? nullptr : found->second.lock();
  if (generation == nullptr) throw std::logic_error("no such generation: " + name);
  return generation;
}

void DiskScratch::keep(const std::string& name) {
  folder_->throw_failure();
  const std::shared_ptr<Generation> generation = begun(name);
  const std::vector<Generation::File> files = generation->files();
  manifest_->keep({name, files.size(), Generation::digest(files)});
  sync_.keep(generation);
}

void DiskScratch::commit(const std::string& name, std::span<const std::byte> state) {
  folder_->throw_failure();
  const std::shared_ptr<Generation> generation = begun(name);
  std::vector<PieceRef> pieces;
  if (!state.empty()) pieces.push_back({0, state});
  const std::uint64_t files = generation->files().size();
  generation->write(plan_sections(generation->id(), kStateSource, pieces), pieces);
  manifest_->commit({name, files, Generation::digest(generation->files()), false});
  sync_.commit(generation);
}

// Throws DamagedFile unless the files of a generation are what was recorded: by their tables, and
// by all their bytes where a loss of power may have taken some.
Found DiskScratch::find(const KeptGeneration& record, bool durable,
                        const std::vector<std::string>& names) const {
  Found found;
  found.generation = std::make_shared<Generation>(folder_, record.name);
  // Nothing of it is lost before something newer takes its place.
  found.generation->set_needed(true);
  for (const std::string& name : names) {
    const auto parsed = parse_scratch_name(name);
    if (!parsed || parsed->generation != record.name) continue;
    SectionTable table = read_sections(folder_->open(name).get(), folder_->path_of(name));
    if (table.generation != found.generation->id() || table.source != parsed->source) {
      throw_damaged(folder_->path_of(name), "it was written as another file");
    }
    found.generation->adopt(table);
    found.tables.push_back(std::move(table));
  }
  const std::vector<Generation::File> files = found.generation->files();
  if (files.size() != record.files || Generation::digest(files) != record.digest) {
    throw_damaged(folder_->path(), "not the files of generation " + record.name);
  }
  if (!durable) {
    for (const SectionTable& table : found.tables) map_sections(found.generation, table);
  }
  return found;
}

// Without what belongs to it.
Found DiskScratch::find_pieces(const Commit& commit, const std::vector<std::string>& names) const {
  // The state is a file more.
  return find({commit.name, commit.files + 1, commit.digest}, commit.durable, names);
}

FoundCommit DiskScratch::find(const Commit& commit, const std::vector<std::string>& names) const {
  FoundCommit result{find_pieces(commit, names), {}};
  for (const KeptGeneration& kept : commit.kept) {
    result.kept.push_back(find(kept, commit.durable, names));
  }
  return result;
}

// The state, if there is one, goes there.
std::unique_ptr<PieceStore> DiskScratch::open(const Found& found, Vector<std::byte>* state) {
  auto store = std::make_unique<DiskPieceStore>(found.generation);
  for (const SectionTable& table : found.tables) {
    if (table.source != kStateSource) {
      store->enter(table);
      continue;
    }
    const auto mapped = map_sections(found.generation, table);
    if (mapped->pieces().empty()) continue;
    const auto bytes = mapped->pieces().front();
    state->assign(bytes.begin(), bytes.end());
  }
  store->seal();
  begun_[found.generation->name()] = found.generation;
  return store;
}

Checkpoint DiskScratch::open(const FoundCommit& commit) {
  Checkpoint checkpoint;
  checkpoint.generation = commit.found.generation->name();
  checkpoint.pieces = open(commit.found, &checkpoint.state);
  for (const Found& kept : commit.kept) {
    Vector<std::byte> none;
    checkpoint.kept.emplace(kept.generation->name(), open(kept, &none));
  }
  return checkpoint;
}

std::optional<Checkpoint> DiskScratch::resume() {
  if (ready_) return std::nullopt;
  const std::vector<std::string> names = folder_->names();
  std::optional<Checkpoint> checkpoint;
  std::shared_ptr<Generation> newest;
  std::shared_ptr<Generation> durable;
  std::set<std::string> needed;
  const std::vector<Commit>& commits = manifest_->commits();
  for (auto commit = commits.rbegin(); commit != commits.rend() && !durable; ++commit) {
    // Behind one that is not durable stays the last one that is.
    if (checkpoint && !commit->durable) continue;
    try {
      if (checkpoint) {
        // What belongs to it belongs to the newer one, too.
        durable = find_pieces(*commit, names).generation;
      } else {
        const FoundCommit whole = find(*commit, names);
        checkpoint = open(whole);
        newest = whole.found.generation;
        if (commit->durable) durable = newest;
        for (const Found& kept : whole.kept) {
          needed.insert(kept.generation->name());
          sync_.keep(kept.generation, commit->durable);
        }
      }
      needed.insert(commit->name);
    } catch (const DamagedFile&) {
      // Not whole: an older one may be.
    }
  }
  // What was kept for commits behind it is no part of those that come.
  for (const KeptGeneration& kept : manifest_->kept()) {
    if (checkpoint && !needed.contains(kept.name)) manifest_->forget(kept.name);
  }
  for (const std::string& name : names) {
    const auto parsed = parse_scratch_name(name);
    if (!parsed || parsed->kind == ScratchFileName::Kind::kManifest) continue;
    if (!needed.contains(parsed->generation)) folder_->unlink(name);
  }
  if (durable) sync_.commit(durable, true);
  if (newest && newest != durable) sync_.commit(newest);
  if (!checkpoint) manifest_->start(manifest_->fingerprint());
  ready_ = true;
  return checkpoint;
}

// Whatever is left in the folder is not ours, and stays.
void remove_folder(const ScratchFolder& folder) {
  int error = 0;
  for (const std::string& name : folder.names()) {
    if (!parse_scratch_name(name) || name == kManifestName) continue;
    if (const int failed = folder.unlink(name); failed != 0 && failed != ENOENT) error = failed;
  }
  // The manifest goes last: as long as it is there, the folder is known to be ours.
  if (error == 0) error = folder.unlink(kManifestName);
  if (error == 0 && file_system().unlinkat(AT_FDCWD, folder.path().c_str(), AT_REMOVEDIR) != 0) {
    error = errno;
  }
  if (error == 0 || error == ENOENT || error == ENOTEMPTY || error == EEXIST) return;
  throw Error(ErrorCode::kIo,
              fmt::format("cannot remove the scratch folder {}: {}; remove it by hand",
                          folder.path(), std::strerror(error)));
}

void DiskScratch::remove() {
  sync_.drop_all();
  // Whoever finds what is left of it, if the rest is not reached, need not resume it.
  try {
    manifest_->end();
  } catch (const Error&) {
    // Its file goes, too.
  }
  folder_->trim_spares(true);
  remove_folder(*folder_);
  ready_ = false;
}

[[noreturn]] void refuse_folder(const std::string& folder, const std::string& why) {
  throw Error(ErrorCode::kUsage, fmt::format("scratch folder {}: {}", folder, why));
}

[[noreturn]] void fail(const std::string& folder, const std::string& what, int error) {
  throw Error(ErrorCode::kIo,
              fmt::format("scratch folder {}: {}: {}", folder, what, std::strerror(error)));
}

// The first line that differs.
std::string difference(const std::string& there, const std::string& here) {
  const auto before = split(there, '\n');
  const auto now = split(here, '\n');
  for (std::size_t i = 0; i < std::max(before.size(), now.size()); ++i) {
    const std::string a = i < before.size() ? before[i] : "";
    const std::string b = i < now.size() ? now[i] : "";
    if (a != b) return fmt::format("it has '{}', this run has '{}'", a, b);
  }
  return "";
}

[[noreturn]] void fail_making(const std::string& path, int error) {
  if (error == ENOENT)
    fail(path, "the folder that is to hold it does not exist; create it first", error);
  fail(path,
       error == ENAMETOOLONG ? "cannot make it (--scratch gives another name)" : "cannot make it",
       error);
}

std::string without_slashes_behind(const std::string& path) {
  return path.substr(0, path.find_last_not_of('/') + 1);
}

// Null where there is none.
std::shared_ptr<ScratchFolder> find_scratch_folder(const std::string& path) {
  if (path.empty()) throw Error(ErrorCode::kUsage, "the scratch folder's name is empty");
  FileSystem& system = file_system();
  Descriptor folder(retry([&] {
    return system.openat(AT_FDCWD, path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC,
                         0);
  }));
  if (folder) return std::make_shared<ScratchFolder>(std::move(folder), path);
  const int error = errno;
  struct stat status {};
  if (system.fstatat(AT_FDCWD, without_slashes_behind(path).c_str(), &status,
                     AT_SYMLINK_NOFOLLOW) != 0) {
    return nullptr;  // nor, perhaps, the folder that is to hold it
  }
  if (error == ENOTDIR || error == ELOOP) {
    refuse_folder(path, "a file or a link has this name; give another one (--scratch)");
  }
  fail(path, "cannot open it", error);
}

std::shared_ptr<ScratchFolder> make_scratch_folder(const std::string& path) {
  if (path.empty()) throw Error(ErrorCode::kUsage, "the scratch folder's name is empty");
  if (retry([&] { return file_system().mkdir(path.c_str(), 0700); }) != 0 && errno != EEXIST) {
    fail_making(path, errno);
  }
  auto folder = find_scratch_folder(path);
  if (!folder) fail(path, "cannot open it", ENOENT);
  return folder;
}

// Throws when something else lies in the folder.
bool holds_manifest(const ScratchFolder& folder) {
  const std::vector<std::string> names = folder.names();
  const bool found = std::binary_search(names.begin(), names.end(), kManifestName);
  for (const std::string& name : names) {
    if (found && parse_scratch_name(name)) continue;
    refuse_folder(folder.path(),
                  fmt::format("it holds {}, which is not ours; give a folder that is empty "
                              "or does not exist (--scratch)",
                              name));
  }
  return found;
}

Descriptor lock_manifest(const ScratchFolder& folder) {
  FileSystem& system = file_system();
  Descriptor file(retry([&] {
    return system.openat(folder.fd(), kManifestName, O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC,
                         0600);
  }));
  if (!file) fail(folder.path(), "cannot open its manifest", errno);
  if (retry([&] { return system.flock(file.get(), LOCK_EX | LOCK_NB); }) != 0) {
    if (errno == EWOULDBLOCK) {
      refuse_folder(folder.path(),
                    "another process is using it; wait for it, or give another folder "
                    "(--scratch)");
    }
    fail(folder.path(), "cannot lock its manifest; use another file system (--scratch)", errno);
  }
  struct stat status {};
  if (system.fstat(file.get(), &status) != 0)
    fail(folder.path(), "cannot look at its manifest", errno);
  // Who had it open before may have removed it since.
  if (status.st_nlink == 0)
    refuse_folder(folder.path(), "another process has just removed it; try again");
  if (!S_ISREG(status.st_mode)) refuse_folder(folder.path(), "its manifest is not a file");
  return file;
}

std::uint64_t bytes_in(const ScratchFolder& folder) {
  std::uint64_t bytes = 0;
  for (const std::string& name : folder.names()) {
    struct stat status {};
    if (file_system().fstatat(folder.fd(), name.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0) {
      bytes += static_cast<std::uint64_t>(status.st_size);
    }
  }
  return bytes;
}

// `ours` may be overwritten.
void check_room(const ScratchFolder& folder, std::uint64_t ours, std::uint64_t expected) {
  if (expected == 0) return;
  const std::uint64_t room = folder.free_bytes() + ours;
  if (room >= expected) return;
  throw Error(
      ErrorCode::kIo,
      fmt::format("scratch folder {}: the run needs about {} ({} bytes) there, the disk has "
                  "room for {} ({} bytes); free some, or use a folder on another disk "
                  "(--scratch)",
                  folder.path(), format_bytes(expected), expected, format_bytes(room), room));
}

// Without a commit in it the manifest holds no work, and the folder is taken over.
bool has_work(const ScratchFolder& folder, const Manifest& manifest) {
  if (!manifest.blank()) return !manifest.commits().empty();
  if (manifest.file_bytes() == 0 || folder.names().size() == 1) return false;
  throw Error(ErrorCode::kIo,
              fmt::format("{}: its beginning is damaged, so nothing can be resumed: remove the "
                          "scratch folder and start the run again",
                          folder.path_of(kManifestName)));
}

// Makes its name durable; until then a loss of power may take the folder with all that was synced
// in it. Where that cannot be done (some network file systems) it is as durable as it gets.
void sync_name(const ScratchFolder& folder) {
  FileSystem& system = file_system();
  const Descriptor parent(retry(
      [&] { return system.openat(folder.fd(), "..", O_RDONLY | O_DIRECTORY | O_CLOEXEC, 0); }));
  if (parent) static_cast<void>(retry([&] { return system.fsync(parent.get()); }));
}

void start_anew(const ScratchFolder& folder, Manifest* manifest, const std::string& fingerprint) {
  for (const std::string& name : folder.names()) {
    if (parse_scratch_name(name) && name != kManifestName) folder.unlink(name);
  }
  manifest->start(fingerprint);
  if (const int error = manifest->sync(); error != 0) {
    fail(folder.path(), "cannot sync its manifest", error);
  }
  sync_name(folder);
}

// As long as the manifest is there nobody else has the folder.
struct LockedFolder {
  std::shared_ptr<Manifest> manifest;
  bool has_work = false;  // of this run
};

// Throws what disk_scratch() throws.
LockedFolder lock_folder(const ScratchFolder& folder, const ScratchOptions& options) {
  auto manifest = std::make_shared<Manifest>(lock_manifest(folder), folder.path_of(kManifestName));
  const bool work = has_work(folder, *manifest);
  if (work && !options.resume) {
    refuse_folder(
        options.folder,
        "it holds the work of a run that was interrupted; give --resume to go on with it, or "
        "remove the folder");
  }
  if (work && manifest->fingerprint() != options.fingerprint) {
    refuse_folder(
        options.folder,
        fmt::format("it holds the work of a run that is not this one: {}; go on as it was begun, "
                    "or remove the folder",
                    difference(manifest->fingerprint(), options.fingerprint)));
  }
  check_room(folder, bytes_in(folder), options.expected_bytes);
  return {std::move(manifest), work};
}

std::unique_ptr<Scratch> take_folder(const std::shared_ptr<ScratchFolder>& folder,
                                     const ScratchOptions& options) {
  const auto [manifest, has_work] = lock_folder(*folder, options);
  if (!has_work) start_anew(*folder, manifest.get(), options.fingerprint);
  return std::make_unique<DiskScratch>(folder, manifest, !has_work);
}

// Of a folder that is not there.
void check_making(const ScratchOptions& options) {
  const std::filesystem::path name = without_slashes_behind(options.folder);
  const std::string parent = name.has_parent_path() ? name.parent_path().string() : ".";
  FileSystem& system = file_system();
  Descriptor disk(retry([&] {
    return system.openat(AT_FDCWD, parent.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC, 0);
  }));
  if (!disk || system.access(parent.c_str(), W_OK | X_OK) != 0) fail_making(options.folder, errno);
  check_room(ScratchFolder(std::move(disk), options.folder), 0, options.expected_bytes);
}

void remove_if_dead(const std::string& path, const std::string& fingerprint) {
  constexpr std::time_t kSettled = 60;  // seconds
  FileSystem& system = file_system();
  const auto folder = find_scratch_folder(path);
  struct stat status {};
  if (!folder || system.fstat(folder->fd(), &status) != 0) return;
  if (std::time(nullptr) - status.st_mtime < kSettled) return;
  Descriptor file(system.openat(folder->fd(), kManifestName, O_RDWR | O_NOFOLLOW | O_CLOEXEC, 0));
  if (!file || system.flock(file.get(), LOCK_EX | LOCK_NB) != 0) return;
  const Manifest manifest(std::move(file), folder->path_of(kManifestName));
  if (!manifest.blank() && manifest.fingerprint() == fingerprint) remove_folder(*folder);
}

}  // namespace

void check_scratch_folder(const std::string& path) {
  const auto folder = find_scratch_folder(path);
  if (folder) holds_manifest(*folder);
}

void check_disk_scratch(const ScratchOptions& options) {
  const auto folder = find_scratch_folder(options.folder);
  if (!folder) return check_making(options);
  if (holds_manifest(*folder)) {
    lock_folder(*folder, options);
    return;
  }
  if (file_system().access(folder->path().c_str(), W_OK | X_OK) != 0) {
    fail(folder->path(), "cannot open its manifest", errno);
  }
  check_room(*folder, 0, options.expected_bytes);
}

void remove_dead_scratch(const std::string& parent, const std::string& fingerprint) noexcept {
  try {
    for (const auto& entry : std::filesystem::directory_iterator(parent)) {
      if (!is_temporary_folder(entry.path().filename().string())) continue;
      try {
        remove_if_dead(entry.path().string(), fingerprint);
      } catch (const Error&) {  // somebody else's
      }
    }
  } catch (const std::exception&) {  // no such folder, or no memory for names
  }
}

std::unique_ptr<Scratch> disk_scratch(const ScratchOptions& options) {
  const std::shared_ptr<ScratchFolder> folder = make_scratch_folder(options.folder);
  const bool is_new = !holds_manifest(*folder);
  try {
    return take_folder(folder, options);
  } catch (const Error& e) {
    if (!is_new || e.code() == ErrorCode::kUsage) throw;  // another process may have taken it
    try {
      remove_folder(*folder);
    } catch (const Error&) {  // the first failure is the one to tell
    }
    throw;
  }
}

}  // namespace tetfusion
