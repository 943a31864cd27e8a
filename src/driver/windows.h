// A window of items, points or tetrahedra, on the way to their chunks: sorted by chunk, as pieces
// of columns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "base/vector.h"
#include "io/piece_store.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Writes the columns of a piece, each at a multiple of eight bytes.
class RowWriter {
 public:
  explicit RowWriter(Vector<std::byte>* out) : out_(out) {}

  // value(item) of each item.
  template <class T, class Value>
  void put(std::span<const std::uint32_t> items, Value value) {
    std::byte* to = grow(items.size() * sizeof(T));
    for (const std::uint32_t item : items) {
      const T v = value(item);
      std::memcpy(to, &v, sizeof v);
      to += sizeof v;
    }
  }

  // Rows of the column: of item i row rows[i], or i where `rows` is empty.
  void put_rows(const Column& column, std::span<const std::uint32_t> items,
                std::span<const std::uint64_t> rows) {
    const std::size_t stride = column.stride();
    std::byte* to = grow(items.size() * stride);
    for (const std::uint32_t item : items) {
      const std::uint64_t row = rows.empty() ? item : rows[item];
      std::memcpy(to, column.rows.data() + row * stride, stride);
      to += stride;
    }
  }

 private:
  std::byte* grow(std::size_t bytes) {
    const std::size_t begin = out_->size();
    out_->resize(begin + bytes);
    out_->resize(begin + (bytes + 7) / 8 * 8, std::byte{0});
    return out_->data() + begin;
  }

  Vector<std::byte>* out_;
};

// Reads them again, in the same order.
class RowReader {
 public:
  explicit RowReader(std::span<const std::byte> piece) : at_(piece.data()) {
    std::memcpy(&items_, at_, sizeof items_);
    at_ += sizeof items_;
  }
  std::uint64_t items() const { return items_; }
  template <class T>
  const T* take() {
    return reinterpret_cast<const T*>(take_bytes(items_ * sizeof(T)));
  }
  const std::byte* take_bytes(std::size_t bytes) {
    const std::byte* column = at_;
    at_ += (bytes + 7) / 8 * 8;
    return column;
  }

 private:
  const std::byte* at_;
  std::uint64_t items_ = 0;
};

// Sorts items 0, 1, ... by their chunks; in a chunk they keep their order.
class WindowPieces {
 public:
  WindowPieces(std::span<const std::uint32_t> chunk_of, std::uint32_t chunks) {
    begins_.assign(std::size_t{chunks} + 1, 0);
    for (const std::uint32_t c : chunk_of) ++begins_[c + 1];
    for (std::size_t c = 0; c < chunks; ++c) begins_[c + 1] += begins_[c];
    Vector<std::uint32_t> next = begins_;
    order_.resize(chunk_of.size());
    for (std::size_t i = 0; i < chunk_of.size(); ++i) {
      order_[next[chunk_of[i]]++] = static_cast<std::uint32_t>(i);
    }
  }

  // Adds a piece for each chunk that has items; write(items, writer) fills it.
  template <class Write>
  void add_to(std::uint32_t source, PieceStore* store, Write write) const {
    constexpr std::size_t kAlignment = 64;
    Vector<std::byte> bytes;
    std::vector<std::size_t> begins, ends;
    std::vector<PieceRef> pieces;
    for (std::size_t c = 0; c + 1 < begins_.size(); ++c) {
      const std::span<const std::uint32_t> items(order_.data() + begins_[c],
                                                 begins_[c + 1] - begins_[c]);
      if (items.empty()) continue;
      begins.push_back((bytes.size() + kAlignment - 1) / kAlignment * kAlignment);
      bytes.resize(begins.back() + sizeof(std::uint64_t));
      const std::uint64_t count = items.size();
      std::memcpy(bytes.data() + begins.back(), &count, sizeof count);
      RowWriter writer(&bytes);
      write(items, &writer);
      ends.push_back(bytes.size());
      pieces.push_back({static_cast<std::uint32_t>(c), {}});
    }
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      pieces[i].bytes = {bytes.data() + begins[i], ends[i] - begins[i]};
    }
    store->add(source, pieces);
  }

 private:
  Vector<std::uint32_t> begins_;  // of each chunk in order_; one entry more
  Vector<std::uint32_t> order_;
};

}  // namespace tetfusion
