#include "io/store/piece_store_disk.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "base/error.h"
#include "base/vector.h"
#include "io/files/checksum.h"
#include "io/files/fault_guard.h"

namespace tetfusion {

Generation::Generation(std::shared_ptr<ScratchFolder> folder, std::string name)
    : folder_(std::move(folder)), name_(std::move(name)), id_(generation_id(name_)) {}

Generation::~Generation() {
  if (needed_) return;
  for (const File& file : files_) folder_->retire(scratch_name(name_, file.source), file.bytes);
}

void Generation::write(const SectionTable& table, std::span<const PieceRef> pieces) {
  folder_->write(scratch_name(name_, table.source), table, pieces);
  const std::lock_guard lock(mutex_);
  files_.push_back({table.source, table.file_bytes, table.checksum});
}

void Generation::adopt(const SectionTable& table) {
  folder_->adopt(table.file_bytes);
  const std::lock_guard lock(mutex_);
  files_.push_back({table.source, table.file_bytes, table.checksum});
}

std::vector<Generation::File> Generation::files() const {
  std::vector<File> files;
  {
    const std::lock_guard lock(mutex_);
    files = files_;
  }
  std::sort(files.begin(), files.end(),
            [](const File& a, const File& b) { return a.source < b.source; });
  return files;
}

std::uint64_t Generation::digest(const std::vector<File>& files) {
  std::vector<std::array<std::uint64_t, 3>> rows;
  rows.reserve(files.size());
  for (const File& file : files) rows.push_back({file.source, file.bytes, file.checksum});
  return checksum(std::as_bytes(std::span(rows)));
}

namespace {

class DiskPieces : public BucketPieces {
 protected:
  DiskPieces(std::shared_ptr<const Generation> generation, std::vector<PieceOnDisk> pieces)
      : generation_(std::move(generation)), pieces_on_disk_(std::move(pieces)) {}

  std::string file_of(std::size_t i) const {
    return scratch_name(generation_->name(), pieces_on_disk_[i].source);
  }
  std::string path_of(std::size_t i) const { return generation_->folder().path_of(file_of(i)); }

  void check_length(std::size_t i, const Descriptor& file) const {
    struct stat status {};
    if (file_system().fstat(file.get(), &status) != 0) {
      throw Error(ErrorCode::kIo,
                  fmt::format("{}: cannot look at it: {}", path_of(i), std::strerror(errno)));
    }
    const Section& section = pieces_on_disk_[i].section;
    const auto size = static_cast<std::uint64_t>(status.st_size);
    if (size < section.offset + section.bytes) {
      throw_damaged(path_of(i), fmt::format("has {} bytes, the section of bucket {} from byte {} "
                                            "needs {}",
                                            size, section.bucket, section.offset,
                                            section.offset + section.bytes));
    }
  }

  void check_sections() const {
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      check_section(path_of(i), pieces_on_disk_[i].section, pieces_[i]);
    }
  }

  std::shared_ptr<const Generation> generation_;
  std::vector<PieceOnDisk> pieces_on_disk_;
};

// Where they are many, which are small then: a process may have no more than so many mappings
// (FORMAT.md), and each thread has a bucket in hand.
class ReadPieces : public DiskPieces {
 public:
  ReadPieces(std::shared_ptr<const Generation> generation, std::vector<PieceOnDisk> pieces)
      : DiskPieces(std::move(generation), std::move(pieces)) {
    std::size_t bytes = kAlignment;
    for (const PieceOnDisk& piece : pieces_on_disk_) bytes += aligned(piece.section.bytes);
    bytes_.resize(bytes);
    std::byte* to = bytes_.data();
    to += aligned(reinterpret_cast<std::uintptr_t>(to)) - reinterpret_cast<std::uintptr_t>(to);
    for (std::size_t i = 0; i < pieces_on_disk_.size(); ++i) {
      const Section& section = pieces_on_disk_[i].section;
      const Descriptor file = generation_->folder().open(file_of(i));
      check_length(i, file);
      if (const int error = pread_all(file.get(), to, section.bytes, section.offset)) {
        throw Error(ErrorCode::kIo,
                    fmt::format("{}: cannot read {} bytes from byte {} on: {}", path_of(i),
                                section.bytes, section.offset,
                                error == kEndOfFile ? "it was cut off" : std::strerror(error)));
      }
      pieces_.emplace_back(to, section.bytes);
      to += aligned(section.bytes);
    }
    check_sections();
  }

 private:
  static constexpr std::size_t kAlignment = 64;
  static std::size_t aligned(std::size_t bytes) {
    return (bytes + kAlignment - 1) / kAlignment * kAlignment;
  }

  Vector<std::byte> bytes_;
};

// The sections lie side by side in one range of addresses, so that one guard watches them all.
class MappedPieces : public DiskPieces {
 public:
  MappedPieces(std::shared_ptr<const Generation> generation, std::vector<PieceOnDisk> pieces)
      : DiskPieces(std::move(generation), std::move(pieces)) {
    if (pieces_on_disk_.empty()) return;
    try {
      reserve();
      for (const PieceOnDisk& piece : pieces_on_disk_) map(piece);
      guard_ = guard_mapping(range_, range_bytes_);
      check_sections();
    } catch (...) {
      release();
      throw;
    }
  }

  ~MappedPieces() override {
    if (missing_page(guard_)) {
      generation_->folder().remember_failure(lost());
    }
    release();
  }

  void check() const override {
    if (missing_page(guard_)) throw Error(ErrorCode::kIo, lost());
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      check_length(i, generation_->folder().open(file_of(i)));
    }
  }

 private:
  struct Pages {
    std::uint64_t offset = 0;  // in the file
    std::uint64_t lead = 0;    // bytes before the section
    std::uint64_t bytes = 0;
  };
  static Pages pages_of(const Section& section) {
    const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
    const std::uint64_t lead = section.offset % page;
    return {section.offset - lead, lead, (lead + section.bytes + page - 1) / page * page};
  }

  void reserve() {
    for (const PieceOnDisk& piece : pieces_on_disk_) range_bytes_ += pages_of(piece.section).bytes;
    void* range = file_system().mmap(nullptr, range_bytes_, PROT_NONE,
                                     MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (range == MAP_FAILED) fail_mapping(0, errno);
    range_ = static_cast<std::byte*>(range);
    end_ = range_;
  }

  void map(const PieceOnDisk& piece) {
    const std::size_t i = pieces_.size();
    const Descriptor file = generation_->folder().open(file_of(i));
    check_length(i, file);
    const Pages pages = pages_of(piece.section);
    // All pages at once: the checksum needs them anyway, and faults are dear.
    void* mapped =
        file_system().mmap(end_, pages.bytes, PROT_READ, MAP_SHARED | MAP_FIXED | MAP_POPULATE,
                           file.get(), static_cast<off_t>(pages.offset));
    if (mapped == MAP_FAILED) fail_mapping(i, errno);
    pieces_.emplace_back(end_ + pages.lead, piece.section.bytes);
    end_ += pages.bytes;
  }

  std::string lost() const {
    return fmt::format(
        "{}: a page could not be read any more: a file of generation {} was "
        "shortened while it was in use, or its disk fails; remove the scratch folder "
        "and start the run again",
        generation_->folder().path(), generation_->name());
  }

  [[noreturn]] void fail_mapping(std::size_t i, int error) const {
    throw Error(ErrorCode::kIo, fmt::format("{}: cannot map {} bytes: {}", path_of(i), range_bytes_,
                                            std::strerror(error)));
  }

  void release() noexcept {
    unguard_mapping(guard_);
    guard_ = -1;
    if (range_ != nullptr) file_system().munmap(range_, range_bytes_);
    range_ = nullptr;
  }

  std::byte* range_ = nullptr;
  std::byte* end_ = nullptr;  // of what is mapped
  std::uint64_t range_bytes_ = 0;
  int guard_ = -1;
};

}  // namespace

std::unique_ptr<BucketPieces> load_pieces(std::shared_ptr<const Generation> generation,
                                          std::vector<PieceOnDisk> pieces) {
  constexpr std::size_t kMostMapped = 128;
  if (pieces.size() > kMostMapped) {
    return std::make_unique<ReadPieces>(std::move(generation), std::move(pieces));
  }
  return std::make_unique<MappedPieces>(std::move(generation), std::move(pieces));
}

DiskPieceStore::DiskPieceStore(std::shared_ptr<Generation> generation)
    : generation_(std::move(generation)) {}

void DiskPieceStore::add(std::uint32_t source, std::span<const PieceRef> pieces) {
  {
    const std::lock_guard lock(mutex_);
    if (source == kStateSource || !sources_.insert(source).second) {
      throw std::logic_error("a source adds its pieces twice");
    }
  }
  if (pieces.empty()) return;
  const SectionTable table = plan_sections(generation_->id(), source, pieces);
  generation_->write(table, pieces);
  enter(table);
}

void DiskPieceStore::enter(const SectionTable& table) {
  const std::lock_guard lock(mutex_);
  for (const Section& section : table.sections) {
    buckets_[section.bucket].push_back({table.source, section});
    bytes_ += section.bytes;
  }
}

void DiskPieceStore::seal() {
  const std::lock_guard lock(mutex_);
  for (auto& [bucket, pieces] : buckets_) {
    std::sort(pieces.begin(), pieces.end(),
              [](const PieceOnDisk& a, const PieceOnDisk& b) { return a.source < b.source; });
  }
}

std::vector<PieceOnDisk> DiskPieceStore::pieces_of(std::uint32_t bucket) const {
  const std::lock_guard lock(mutex_);
  const auto found = buckets_.find(bucket);
  return found == buckets_.end() ? std::vector<PieceOnDisk>() : found->second;
}

void DiskPieceStore::will_read(std::uint32_t bucket) const {
  for (const PieceOnDisk& piece : pieces_of(bucket)) {
    const std::string name = scratch_name(generation_->name(), piece.source);
    const Descriptor file(file_system().openat(generation_->folder().fd(), name.c_str(),
                                               O_RDONLY | O_NOFOLLOW | O_CLOEXEC, 0));
    if (!file) return;  // read() will say so
    file_system().fadvise(file.get(), static_cast<off_t>(piece.section.offset),
                          static_cast<off_t>(piece.section.bytes), POSIX_FADV_WILLNEED);
  }
}

std::unique_ptr<BucketPieces> DiskPieceStore::read(std::uint32_t bucket) const {
  return load_pieces(generation_, pieces_of(bucket));
}

void DiskPieceStore::for_each(std::uint32_t bucket, const UsePiece& use) const {
  for (const PieceOnDisk& piece : pieces_of(bucket)) {
    load_pieces(generation_, {piece})->use([&](const auto& one) { use(one[0]); });
  }
}

void DiskPieceStore::forget(std::uint32_t bucket) {
  const std::lock_guard lock(mutex_);
  buckets_.erase(bucket);
}

std::uint64_t DiskPieceStore::bytes(std::uint32_t bucket) const {
  std::uint64_t sum = 0;
  for (const PieceOnDisk& piece : pieces_of(bucket)) sum += piece.section.bytes;
  return sum;
}

std::uint64_t DiskPieceStore::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

}  // namespace tetfusion
