// The log of a scratch folder: which generations are whole (FORMAT.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/files/file_system.h"

namespace tetfusion {

struct KeptGeneration {
  std::string name;
  std::uint64_t files = 0;
  std::uint64_t digest = 0;
};

struct Commit {
  std::string name;
  std::uint64_t files = 0;   // of pieces
  std::uint64_t digest = 0;  // of all files, the state too
  bool durable = false;
  std::vector<KeptGeneration> kept = {};  // that belong to it
};

// Thread-safe.
class Manifest {
 public:
  // Takes a manifest that is open for reading and writing, and locked, and reads what is whole of
  // it. `path` is what messages call it. Throws Error(kIo).
  Manifest(Descriptor file, std::string path);

  // Neither a fingerprint nor anything behind it is there: the file is new, or its writer was
  // killed in its first moments, or the beginning is damaged.
  bool blank() const { return blank_; }
  std::uint64_t file_bytes() const { return file_bytes_; }  // as it was found
  const std::string& fingerprint() const { return fingerprint_; }
  const std::vector<Commit>& commits() const {
    return commits_;
  }  // as they were found, oldest first
  // What the next commit that was found would have been given.
  const std::vector<KeptGeneration>& kept() const { return kept_; }

  // Begins anew, for the run of this fingerprint. The functions below throw Error(kIo) too.
  void start(const std::string& fingerprint);
  void keep(const KeptGeneration& generation);
  void forget(std::string_view name);  // it belongs to nothing that is committed later
  void commit(const Commit& commit);  // with all that was kept before
  void mark_durable(std::string_view name);
  void end();  // nobody needs what was committed
  int sync();  // 0 or errno

 private:
  void load();
  bool take(std::uint32_t kind, std::span<const std::byte> payload);
  void append(std::uint32_t kind, std::span<const std::byte> payload);
  [[noreturn]] void fail(const char* what, std::uint64_t at, int error) const;

  Descriptor file_;
  std::string path_;
  std::uint64_t file_bytes_ = 0;
  bool blank_ = true;
  std::string fingerprint_;
  std::vector<Commit> commits_;
  std::vector<KeptGeneration> kept_;  // as they were found
  std::mutex mutex_;
  std::uint64_t end_ = 0;  // of the last whole record
  bool has_tail_ = false;  // something stands behind it
};

}  // namespace tetfusion
