// Pieces of a mesh on their way from one set of chunks to the next: bytes that a source leaves for
// a bucket. In memory, or in files that are mapped when a bucket is read, or copied where its
// pieces are very many (FORMAT.md); what comes back is the same.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace tetfusion {

// What a source has for one bucket. The bytes need to live only as long as add() runs.
struct PieceRef {
  std::uint32_t bucket = 0;
  std::span<const std::byte> bytes;  // not empty
};

// The pieces of one bucket, ascending by source, checked, each at an address that is a multiple of
// 64. The spans live as long as this object.
class BucketPieces {
 public:
  virtual ~BucketPieces() = default;
  const std::vector<std::span<const std::byte>>& pieces() const { return pieces_; }

  // Throws Error(kIo) when bytes have been lost since read(), as someone shortened a file: there
  // are zeros then. Scratch::check() says so, too, when this object is gone.
  virtual void check() const {}

  // Calls use(pieces), and throws what that does, and check(): where bytes have been lost that
  // alone, whatever came of it. Zeros may turn up while it is at it, so it looks at no number of
  // rows twice.
  template <class Use>
  void use(Use use) const {
    try {
      use(pieces_);
    } catch (...) {
      check();
      throw;
    }
    check();
  }

 protected:
  std::vector<std::span<const std::byte>> pieces_;
};

// One generation of pieces: first all are added, then seal(), then they are read. Within either
// half, different sources or buckets may be worked on by several threads at once.
class PieceStore {
 public:
  virtual ~PieceStore() = default;

  // Each source adds once; `pieces` ascend by bucket, one a bucket. Throws Error(kIo).
  virtual void add(std::uint32_t source, std::span<const PieceRef> pieces) = 0;

  // All sources have been added.
  virtual void seal() = 0;

  // Starts reading a bucket ahead; returns at once.
  virtual void will_read(std::uint32_t bucket) const = 0;

  // May be called again and again until forget(). Throws Error(kIo) with file and byte when the
  // bytes are not what was added (length and checksum are compared before they are handed out).
  virtual std::unique_ptr<BucketPieces> read(std::uint32_t bucket) const = 0;

  // Calls use(piece) with what read() has, one after the other, each of which is there only
  // meanwhile: for buckets that are much larger than a chunk. Throws what read() and check() do.
  using UsePiece = std::function<void(std::span<const std::byte> piece)>;
  virtual void for_each(std::uint32_t bucket, const UsePiece& use) const {
    read(bucket)->use([&](const auto& pieces) {
      for (const auto piece : pieces) use(piece);
    });
  }

  // The bucket will not be read again: its memory is freed, when no BucketPieces of it lives.
  virtual void forget(std::uint32_t bucket) = 0;

  virtual std::uint64_t bytes(std::uint32_t bucket) const = 0;  // of a bucket's pieces
  virtual std::uint64_t bytes() const = 0;                      // of all pieces that were added
};

}  // namespace tetfusion
