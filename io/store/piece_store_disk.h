// Generations of pieces in a scratch folder: written once, then mapped bucket by bucket.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "io/store/piece_store.h"
#include "io/store/scratch_folder.h"
#include "io/store/section_file.h"

namespace tetfusion {

// The files of a generation. They are free to go when nothing holds this object any more (the
// store, what was read from it, the scratch), unless `needed`. Thread-safe.
class Generation {
 public:
  struct File {
    std::uint32_t source = 0;  // kStateSource: the state
    std::uint64_t bytes = 0;
    std::uint64_t checksum = 0;  // of header and table
  };

  Generation(std::shared_ptr<ScratchFolder> folder, std::string name);
  ~Generation();
  Generation(const Generation&) = delete;
  Generation& operator=(const Generation&) = delete;

  ScratchFolder& folder() const { return *folder_; }
  const std::string& name() const { return name_; }
  std::uint64_t id() const { return id_; }

  void write(const SectionTable& table, std::span<const PieceRef> pieces);  // Error(kIo)
  void adopt(const SectionTable& table);  // a file of it that was there before
  std::vector<File> files() const;        // ascending by source
  static std::uint64_t digest(const std::vector<File>& files);

  void set_needed(bool needed) { needed_ = needed; }  // by a run that is resumed

 private:
  std::shared_ptr<ScratchFolder> folder_;
  std::string name_;
  std::uint64_t id_;
  mutable std::mutex mutex_;
  std::vector<File> files_;
  std::atomic<bool> needed_{false};
};

struct PieceOnDisk {
  std::uint32_t source = 0;
  Section section;
};

// Maps sections, or reads them where they are many, and compares their checksums. Throws
// Error(kIo).
std::unique_ptr<BucketPieces> load_pieces(std::shared_ptr<const Generation> generation,
                                          std::vector<PieceOnDisk> pieces);

class DiskPieceStore : public PieceStore {
 public:
  explicit DiskPieceStore(std::shared_ptr<Generation> generation);

  void add(std::uint32_t source, std::span<const PieceRef> pieces) override;
  void seal() override;
  void will_read(std::uint32_t bucket) const override;
  std::unique_ptr<BucketPieces> read(std::uint32_t bucket) const override;
  void for_each(std::uint32_t bucket, const UsePiece& use) const override;
  void forget(std::uint32_t bucket) override;
  std::uint64_t bytes(std::uint32_t bucket) const override;
  std::uint64_t bytes() const override;

  // A file that the generation has already.
  void enter(const SectionTable& table);

 private:
  std::vector<PieceOnDisk> pieces_of(std::uint32_t bucket) const;

  std::shared_ptr<Generation> generation_;
  mutable std::mutex mutex_;
  std::set<std::uint32_t> sources_;
  std::map<std::uint32_t, std::vector<PieceOnDisk>> buckets_;
  std::uint64_t bytes_ = 0;
};

}  // namespace tetfusion
