// Pieces of which bytes are lost after they were checked, as where someone shortens a file that is
// mapped.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/error.h"
#include "base/vector.h"
#include "io/store/piece_store.h"

namespace tetfusion::testing {

// What another store has, with zeros for so many bytes from a place in each piece on.
class LossyStore : public PieceStore {
 public:
  LossyStore(const PieceStore& store, std::size_t at, std::size_t count)
      : store_(store), at_(at), count_(count) {}

  void add(std::uint32_t, std::span<const PieceRef>) override {}
  void seal() override {}
  void will_read(std::uint32_t) const override {}
  void forget(std::uint32_t) override {}
  std::uint64_t bytes(std::uint32_t bucket) const override { return store_.bytes(bucket); }
  std::uint64_t bytes() const override { return store_.bytes(); }
  std::unique_ptr<BucketPieces> read(std::uint32_t bucket) const override {
    return std::make_unique<Pieces>(*store_.read(bucket), at_, count_);
  }

 private:
  class Pieces : public BucketPieces {
   public:
    Pieces(const BucketPieces& all, std::size_t at, std::size_t count) {
      for (const std::span<const std::byte> piece : all.pieces()) {
        Vector<std::byte>& copy = copies_.emplace_back(piece.begin(), piece.end());
        const std::size_t begin = std::min(at, copy.size());
        std::fill_n(copy.begin() + static_cast<std::ptrdiff_t>(begin),
                    std::min(count, copy.size() - begin), std::byte{});
        pieces_.push_back(copy);
      }
    }
    void check() const override { throw Error(ErrorCode::kIo, "bytes were lost"); }

   private:
    std::vector<Vector<std::byte>> copies_;
  };

  const PieceStore& store_;
  std::size_t at_, count_;
};

}  // namespace tetfusion::testing
