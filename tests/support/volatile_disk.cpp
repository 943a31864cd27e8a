#include "support/volatile_disk.h"

#include <dirent.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "support/mesh_file.h"
#include "support/meshes.h"

namespace tetfusion::testing {

namespace {

namespace fs = std::filesystem;
constexpr std::size_t kPage = 4096;

struct stat look_at(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) throw std::runtime_error("cannot look at " + path);
  return status;
}

std::map<std::string, std::uint64_t> names_in(const std::string& path) {
  std::map<std::string, std::uint64_t> names;
  for (const auto& entry : fs::directory_iterator(path)) {
    struct stat status {};
    if (::stat(entry.path().c_str(), &status) != 0) continue;  // another thread has just renamed it
    names[entry.path().filename().string()] = status.st_ino;
  }
  return names;
}

}  // namespace

// What is there when the power goes, and what becomes of it.
struct VolatileDisk::Loss {
  const VolatileDisk& disk;
  Keeps keeps;
  std::uint64_t seed;
  std::map<Inode, Names> names;              // as they are, of folders
  std::map<Inode, std::string> bytes;        // of files
  std::map<std::string, std::string> files;  // the outcome, by path
  std::vector<std::string> made;             // folders of the outcome
  std::uint64_t choices = 0;

  bool choose() { return uniform(seed, choices++) < 0.5; }

  void look(const std::string& path) {
    const Inode folder = look_at(path).st_ino;
    names[folder] = names_in(path);
    for (const auto& [name, inode] : names[folder]) {
      const std::string below = path + "/" + name;
      if (fs::is_directory(below)) {
        look(below);
      } else {
        bytes[inode] = bytes_of(below);
      }
    }
  }

  template <class Map>
  static const typename Map::mapped_type* find(const Map& map, Inode inode) {
    const auto at = map.find(inode);
    return at == map.end() ? nullptr : &at->second;
  }

  void keep_folder(Inode folder, const std::string& path) {
    static const Names kNone;
    const Names* const now = find(names, folder);
    const Names* const safe = find(disk.safe_names_, folder);
    std::set<std::string> all;
    for (const Names* some : {now, safe}) {
      for (const auto& [name, inode] : some != nullptr ? *some : kNone) all.insert(name);
    }
    for (const std::string& name : all) {
      const bool new_name = keeps == Keeps::kNames || (keeps == Keeps::kSome && choose());
      const Names* const from = new_name ? now : safe;
      if (from == nullptr) continue;
      const auto entry = from->find(name);
      if (entry == from->end()) continue;
      const std::string below = path + "/" + name;
      if (names.contains(entry->second) || disk.folders_.contains(entry->second)) {
        made.push_back(below);
        keep_folder(entry->second, below);
      } else {
        files[below] = kept_bytes(entry->second);
      }
    }
  }

  std::string kept_bytes(Inode file) {
    const std::string* const now = find(bytes, file);
    const std::string* const safe = find(disk.safe_bytes_, file);
    const std::string old = safe != nullptr ? *safe : std::string();
    if (now == nullptr || keeps == Keeps::kSynced || keeps == Keeps::kNames) return old;
    if (keeps == Keeps::kData) return *now;
    if (*now == old) return old;
    std::string mixed = old;
    mixed.resize(choose() ? now->size() : old.size());
    for (std::size_t at = 0; at < std::min(mixed.size(), now->size()); at += kPage) {
      if (choose()) mixed.replace(at, kPage, now->substr(at, std::min(kPage, mixed.size() - at)));
    }
    return mixed;
  }
};

VolatileDisk::VolatileDisk(std::string folder) : folder_(std::move(folder)) {
  take_folder(folder_);
}

void VolatileDisk::take_folder(const std::string& path) {
  const Inode folder = look_at(path).st_ino;
  folders_.insert(folder);
  safe_names_[folder] = names_in(path);
  for (const auto& [name, inode] : safe_names_[folder]) {
    const std::string below = path + "/" + name;
    if (fs::is_directory(below)) {
      take_folder(below);
    } else {
      safe_bytes_[inode] = bytes_of(below);
    }
  }
}

int VolatileDisk::fsync(int fd) {
  if (FaultyFileSystem::fsync(fd) != 0) return -1;
  const std::string path = open_file_path(fd);
  const struct stat status = look_at(path);
  const std::lock_guard lock(mutex_);
  if (S_ISDIR(status.st_mode)) {
    folders_.insert(status.st_ino);
    safe_names_[status.st_ino] = names_in(path);
  } else if (S_ISREG(status.st_mode)) {
    safe_bytes_[status.st_ino] = bytes_of(path);
  }
  return 0;
}

void VolatileDisk::lose_power(Keeps keeps, std::uint64_t seed) {
  Loss loss{*this, keeps, seed, {}, {}, {}, {}};
  loss.look(folder_);
  loss.keep_folder(look_at(folder_).st_ino, folder_);
  for (const auto& entry : fs::directory_iterator(folder_)) fs::remove_all(entry.path());
  for (const std::string& path : loss.made) fs::create_directory(path);
  for (const auto& [path, bytes] : loss.files) std::ofstream(path, std::ios::binary) << bytes;
}

}  // namespace tetfusion::testing
