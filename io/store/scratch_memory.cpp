// The in-core side: pieces in memory, nothing to resume.
#include <algorithm>
#include <atomic>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <utility>

#include "base/page_pool.h"
#include "io/store/scratch.h"

namespace tetfusion {

namespace {

constexpr std::align_val_t kBlockAlignment{64};

// Of all generations together. Thread-safe.
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

// Pieces of this size and more are pages of their own: freed, they leave no holes in a heap that
// others use between two generations.
constexpr std::size_t kOwnPages = std::size_t{64} << 10;

std::byte* allocate(std::size_t bytes) {
  if (bytes >= kOwnPages) return allocate_pages(bytes);
  return static_cast<std::byte*>(::operator new(bytes, kBlockAlignment));
}

void release(std::byte* data, std::size_t bytes) noexcept {
  if (bytes >= kOwnPages) {
    free_pages(data, bytes);
  } else {
    ::operator delete(data, kBlockAlignment);
  }
}

// A piece's own copy of its bytes: no more of them than there are, freed with it.
class Piece {
 public:
  Piece(std::uint32_t source, std::span<const std::byte> bytes, std::shared_ptr<ByteCount> count)
      : source_(source),
        size_(bytes.size()),
        data_(allocate(bytes.size())),
        count_(std::move(count)) {
    std::memcpy(data_, bytes.data(), size_);
    count_->add(size_);
  }
  ~Piece() {
    if (count_ == nullptr) return;
    release(data_, size_);
    count_->subtract(size_);
  }
  Piece(Piece&& other) noexcept
      : source_(other.source_),
        size_(other.size_),
        data_(std::exchange(other.data_, nullptr)),
        count_(std::move(other.count_)) {}
  Piece& operator=(Piece&& other) noexcept {
    std::swap(source_, other.source_);
    std::swap(size_, other.size_);
    std::swap(data_, other.data_);
    std::swap(count_, other.count_);
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
  std::shared_ptr<ByteCount> count_;
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
  explicit MemoryPieceStore(std::shared_ptr<ByteCount> count) : count_(std::move(count)) {}
  ~MemoryPieceStore() override {
    buckets_.clear();
    free_spare_pages();
  }
  MemoryPieceStore(const MemoryPieceStore&) = delete;
  MemoryPieceStore& operator=(const MemoryPieceStore&) = delete;

  void add(std::uint32_t source, std::span<const PieceRef> pieces) override {
    std::vector<Piece> copies;
    copies.reserve(pieces.size());
    for (const PieceRef& piece : pieces) copies.emplace_back(source, piece.bytes, count_);
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
  std::shared_ptr<ByteCount> count_;
};

class MemoryScratch : public Scratch {
 public:
  std::unique_ptr<PieceStore> begin(const std::string&) override {
    return std::make_unique<MemoryPieceStore>(count_);
  }
  void commit(const std::string&, std::span<const std::byte>) override {}
  void keep(const std::string&) override {}
  std::optional<Checkpoint> resume() override { return std::nullopt; }
  void check() const override {}
  void drop_spares() override {}
  void remove() override {}
  std::uint64_t peak_bytes() const override { return count_->peak(); }

 private:
  std::shared_ptr<ByteCount> count_ = std::make_shared<ByteCount>();
};

}  // namespace

std::unique_ptr<Scratch> memory_scratch() { return std::make_unique<MemoryScratch>(); }

}  // namespace tetfusion
