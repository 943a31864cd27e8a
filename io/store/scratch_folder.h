// The folder of a run on disk: its files by name, and those that wait to be overwritten.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/files/file_system.h"
#include "io/store/section_file.h"

namespace tetfusion {

inline constexpr const char* kManifestName = "manifest";

// What a name in the folder says (FORMAT.md).
struct ScratchFileName {
  enum class Kind { kManifest, kPieces, kState, kPart } kind = Kind::kManifest;
  std::string generation;    // of kPieces and kState
  std::uint32_t source = 0;  // of kPieces; kStateSource of kState
};
std::optional<ScratchFileName> parse_scratch_name(std::string_view name);  // nothing: not ours
std::string scratch_name(std::string_view generation, std::uint32_t source);
bool is_generation_name(std::string_view name);

// Every function throws Error(kIo) unless it says otherwise. Thread-safe.
class ScratchFolder {
 public:
  // `folder` is open; `path` is what messages call it.
  ScratchFolder(Descriptor folder, std::string path);
  ~ScratchFolder();  // removes the spare files
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::string& path() const { return path_; }
  std::string path_of(std::string_view name) const;
  int fd() const { return folder_.get(); }

  // Of all that is there, sorted; but not of what a network file system leaves (is_left_by_nfs).
  std::vector<std::string> names() const;
  Descriptor open(const std::string& name) const;
  // Makes a file of that name, which appears when it is whole.
  void write(const std::string& name, const SectionTable& table, std::span<const PieceRef> pieces);
  // A file that was there before, and is counted from now on.
  void adopt(std::uint64_t bytes) { count(bytes, 0); }
  // The file is not needed any more and nobody reads it: it may be overwritten. Does not throw.
  void retire(const std::string& name, std::uint64_t bytes) noexcept;
  // Removes spare files that have not been needed since the call before the last; all: every one.
  void trim_spares(bool all) noexcept;
  int unlink(const std::string& name) const;  // 0 or errno

  std::uint64_t free_bytes() const;  // that the disk has for us
  std::uint64_t peak_bytes() const;

  // What went wrong where nothing can be thrown; the first one is kept.
  void remember_failure(const std::string& message) noexcept;
  void throw_failure() const;

 private:
  struct Spare {
    std::string name;
    std::uint64_t age = 0;
  };

  std::string take_part(std::uint64_t bytes, Descriptor* file);
  void count(std::uint64_t more, std::uint64_t less);
  [[noreturn]] void fail_writing(const std::string& name, std::uint64_t bytes, int error) const;

  Descriptor folder_;
  std::string path_;
  mutable std::mutex mutex_;
  std::multimap<std::uint64_t, Spare> spares_;  // by length
  std::uint64_t trims_ = 0;
  std::uint64_t parts_ = 0;  // numbers for new names
  std::uint64_t bytes_ = 0;
  std::uint64_t peak_ = 0;
  std::string failure_;
};

}  // namespace tetfusion
