// The in-core side: pieces in memory, nothing to resume.
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <stdexcept>
#include <utility>

#include "io/scratch.h"

namespace tetfusion {

namespace {

constexpr std::align_val_t kAlignment{64};

// Of all generations together.
class ByteCount {
 public:
  void add(std::uint64_t bytes) {
    const std::uint64_t now = now_.fetch_add(bytes) + bytes;
    std::uint64_t peak = peak_.load();
    while (peak < now && !peak_.compare_exchange_weak(peak, now)) {
    }
  }
  void subtract(std::uint64_t bytes) { now_ -= bytes; }
  std::uint64_t peak() const { return peak_; }

 private:
  std::atomic<std::uint64_t> now_{0};
  std::atomic<std::uint64_t> peak_{0};
};

// Blocks of this size and more are the system's pages: freed, they leave no holes in a heap that
// others use between two generations.
constexpr std::size_t kOwnPages = std::size_t{64} << 10;
// So much of what one chunk's pieces have left is kept for the pieces that the next one makes.
constexpr std::size_t kMostSpare = std::size_t{16} << 20;

// Where pieces have their bytes. Pages that have been freed are used again: the first touch of a
// new one costs more than copying a page's bytes. Thread-safe.
class Pages {
 public:
  Pages() = default;
  ~Pages() { release_spare(); }
  Pages(const Pages&) = delete;
  Pages& operator=(const Pages&) = delete;

  std::byte* allocate(std::size_t bytes) {
    if (bytes < kOwnPages) return static_cast<std::byte*>(::operator new(bytes, kAlignment));
    const std::size_t size = whole(bytes);
    const std::lock_guard lock(mutex_);
    if (std::byte* spare = take_spare(size)) return spare;
    void* pages = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages == MAP_FAILED) throw std::bad_alloc();
    return static_cast<std::byte*>(pages);
  }

  void release(std::byte* data, std::size_t bytes) {
    if (bytes < kOwnPages) {
      ::operator delete(data, kAlignment);
      return;
    }
    const std::size_t size = whole(bytes);
    const std::lock_guard lock(mutex_);
    if (spare_bytes_ + size > kMostSpare) {
      ::munmap(data, size);
      return;
    }
    spare_bytes_ += size;
    auto at = spare_.emplace(data, size).first;
    const auto after = std::next(at);
    if (after != spare_.end() && data + size == after->first) {
      at->second += after->second;
      spare_.erase(after);
    }
    if (at == spare_.begin()) return;
    const auto before = std::prev(at);
    if (before->first + before->second != data) return;
    before->second += at->second;
    spare_.erase(at);
  }

  // Back to the system.
  void release_spare() {
    const std::lock_guard lock(mutex_);
    for (const auto& [data, size] : spare_) ::munmap(data, size);
    spare_.clear();
    spare_bytes_ = 0;
  }

 private:
  static std::size_t whole(std::size_t bytes) {
    static const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    return (bytes + page - 1) / page * page;
  }

  // The beginning of the smallest that is large enough; null: there is none.
  std::byte* take_spare(std::size_t size) {
    auto best = spare_.end();
    for (auto it = spare_.begin(); it != spare_.end(); ++it) {
      if (it->second >= size && (best == spare_.end() || it->second < best->second)) best = it;
    }
    if (best == spare_.end()) return nullptr;
    const auto [data, all] = *best;
    spare_.erase(best);
    if (all > size) spare_.emplace(data + size, all - size);
    spare_bytes_ -= size;
    return data;
  }

  std::mutex mutex_;
  std::map<std::byte*, std::size_t> spare_;  // ranges, none beside another
  std::size_t spare_bytes_ = 0;
};

// What all generations share.
struct Memory {
  ByteCount count;
  Pages pages;
};

// A piece's own copy of its bytes: no more of them than there are, freed with it.
class Piece {
 public:
  Piece(std::uint32_t source, std::span<const std::byte> bytes, std::shared_ptr<Memory> memory)
      : source_(source),
        size_(bytes.size()),
        data_(memory->pages.allocate(bytes.size())),
        memory_(std::move(memory)) {
    std::memcpy(data_, bytes.data(), size_);
    memory_->count.add(size_);
  }
  ~Piece() {
    if (memory_ == nullptr) return;
    memory_->pages.release(data_, size_);
    memory_->count.subtract(size_);
  }
  Piece(Piece&& other) noexcept
      : source_(other.source_),
        size_(other.size_),
        data_(std::exchange(other.data_, nullptr)),
        memory_(std::move(other.memory_)) {}
  Piece& operator=(Piece&& other) noexcept {
    std::swap(source_, other.source_);
    std::swap(size_, other.size_);
    std::swap(data_, other.data_);
    std::swap(memory_, other.memory_);
    return *this;
  }
  Piece(const Piece&) = delete;
  Piece& operator=(const Piece&) = delete;

  std::uint32_t source() const { return source_; }
  std::span<const std::byte> bytes() const { return {data_, size_}; }

 private:
  std::uint32_t source_;
  std::size_t size_;
  std::byte* data_;
  std::shared_ptr<Memory> memory_;
};

struct Bucket {
  std::vector<Piece> pieces;  // in any order until the store is sealed
  std::uint64_t bytes = 0;
};

class MemoryBucketPieces : public BucketPieces {
 public:
  explicit MemoryBucketPieces(std::shared_ptr<const Bucket> bucket) : bucket_(std::move(bucket)) {
    if (bucket_ == nullptr) return;
    pieces_.reserve(bucket_->pieces.size());
    for (const Piece& piece : bucket_->pieces) pieces_.push_back(piece.bytes());
  }

 private:
  std::shared_ptr<const Bucket> bucket_;
};

class MemoryPieceStore : public PieceStore {
 public:
  explicit MemoryPieceStore(std::shared_ptr<Memory> memory) : memory_(std::move(memory)) {}
  ~MemoryPieceStore() override {
    buckets_.clear();
    memory_->pages.release_spare();
  }
  MemoryPieceStore(const MemoryPieceStore&) = delete;
  MemoryPieceStore& operator=(const MemoryPieceStore&) = delete;

  void add(std::uint32_t source, std::span<const PieceRef> pieces) override {
    std::vector<Piece> copies;
    copies.reserve(pieces.size());
    for (const PieceRef& piece : pieces) copies.emplace_back(source, piece.bytes, memory_);
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      std::shared_ptr<Bucket>& bucket = buckets_[pieces[i].bucket];
      if (bucket == nullptr) bucket = std::make_shared<Bucket>();
      bucket->bytes += pieces[i].bytes.size();
      bytes_ += pieces[i].bytes.size();
      bucket->pieces.push_back(std::move(copies[i]));
    }
  }

  void seal() override {
    for (auto& [number, bucket] : buckets_) {
      std::sort(bucket->pieces.begin(), bucket->pieces.end(),
                [](const Piece& a, const Piece& b) { return a.source() < b.source(); });
    }
  }

  void will_read(std::uint32_t) const override {}

  std::unique_ptr<BucketPieces> read(std::uint32_t bucket) const override {
    const std::lock_guard lock(mutex_);
    const auto found = buckets_.find(bucket);
    return std::make_unique<MemoryBucketPieces>(found == buckets_.end() ? nullptr : found->second);
  }

  void forget(std::uint32_t bucket) override {
    std::shared_ptr<Bucket> gone;  // freed after the lock
    const std::lock_guard lock(mutex_);
    const auto found = buckets_.find(bucket);
    if (found == buckets_.end()) return;
    gone = std::move(found->second);
    buckets_.erase(found);
  }

  std::uint64_t bytes(std::uint32_t bucket) const override {
    const std::lock_guard lock(mutex_);
    const auto found = buckets_.find(bucket);
    return found == buckets_.end() ? 0 : found->second->bytes;
  }

  std::uint64_t bytes() const override {
    const std::lock_guard lock(mutex_);
    return bytes_;
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::uint32_t, std::shared_ptr<Bucket>> buckets_;
  std::uint64_t bytes_ = 0;
  std::shared_ptr<Memory> memory_;
};

class MemoryScratch : public Scratch {
 public:
  std::unique_ptr<PieceStore> begin(const std::string&) override {
    return std::make_unique<MemoryPieceStore>(memory_);
  }
  void commit(const std::string&, std::span<const std::byte>) override {}
  void keep(const std::string&) override {}
  std::optional<Checkpoint> resume() override { return std::nullopt; }
  void drop_spares() override {}
  void remove() override {}
  std::uint64_t peak_bytes() const override { return memory_->count.peak(); }

 private:
  std::shared_ptr<Memory> memory_ = std::make_shared<Memory>();
};

}  // namespace

std::unique_ptr<Scratch> memory_scratch() { return std::make_unique<MemoryScratch>(); }

}  // namespace tetfusion
