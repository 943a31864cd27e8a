// A window of items, points or tetrahedra, on the way to their chunks: sorted by chunk, as pieces
// of columns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "base/copy_few.h"
#include "base/vector.h"
#include "io/source/mesh_stream.h"
#include "io/store/piece_store.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Reads `count` rows of each of some arrays to the first columns.
inline void read_columns(const MeshStream& stream, Association association,
                         const std::vector<std::size_t>& indices, std::uint64_t first,
                         std::uint64_t count, std::vector<Column>* columns) {
  for (std::size_t c = 0; c < indices.size(); ++c) {
    (*columns)[c].resize(count);
    stream.read_rows(association, indices[c], first, count, (*columns)[c].rows);
  }
}

inline void append_row(const Column& from, std::size_t row, Column* to) {
  const std::byte* begin = from.rows.data() + row * from.stride();
  to->rows.insert(to->rows.end(), begin, begin + from.stride());
}

template <class T>
void append(const Vector<T>& rows, Vector<T>* to) {
  to->insert(to->end(), rows.begin(), rows.end());
}

// To columns of the same kinds.
inline void append_rows(const std::vector<Column>& columns, std::vector<Column>* to) {
  for (std::size_t c = 0; c < columns.size(); ++c) append(columns[c].rows, &(*to)[c].rows);
}

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

  // Rows of so many bytes: of item i row i.
  void put_rows(const std::byte* rows, std::size_t stride, std::span<const std::uint32_t> items) {
    std::byte* to = grow(items.size() * stride);
    for (const std::uint32_t item : items) {
      copy_few(rows + item * stride, stride, to);
      to += stride;
    }
  }

  // Rows of the column: of item i row rows[i], or i where `rows` is empty.
  template <class Rows>
  void put_rows(const Column& column, std::span<const std::uint32_t> items, const Rows& rows) {
    const std::size_t stride = column.stride();
    std::byte* to = grow(items.size() * stride);
    for (const std::uint32_t item : items) {
      const std::uint64_t row = rows.empty() ? item : rows[item];
      copy_few(column.rows.data() + row * stride, stride, to);
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

// Sorts items 0, 1, ... by their chunks; in a chunk they keep their order. Keeps its memory.
class WindowPieces {
 public:
  // Adds a piece for each chunk that has items to the store; write(items, writer) fills it.
  template <class Write>
  void add(std::uint32_t source, std::span<const std::uint32_t> chunk_of, std::uint32_t chunks,
           PieceStore* store, Write write) {
    sort(chunk_of, chunks);
    constexpr std::size_t kAlignment = 64;
    bytes_.clear();
    pieces_.clear();
    extents_.clear();
    for (std::uint32_t c = 0; c < chunks; ++c) {
      const std::span<const std::uint32_t> items(order_.data() + begins_[c],
                                                 begins_[c + 1] - begins_[c]);
      if (items.empty()) continue;
      const std::size_t begin = (bytes_.size() + kAlignment - 1) / kAlignment * kAlignment;
      bytes_.resize(begin + sizeof(std::uint64_t));
      const std::uint64_t count = items.size();
      std::memcpy(bytes_.data() + begin, &count, sizeof count);
      RowWriter writer(&bytes_);
      write(items, &writer);
      extents_.emplace_back(begin, bytes_.size() - begin);
      pieces_.push_back({c, {}});
    }
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      pieces_[i].bytes = {bytes_.data() + extents_[i].first, extents_[i].second};
    }
    store->add(source, pieces_);
  }

 private:
  void sort(std::span<const std::uint32_t> chunk_of, std::uint32_t chunks) {
    begins_.assign(std::size_t{chunks} + 1, 0);
    for (const std::uint32_t c : chunk_of) ++begins_[c + 1];
    for (std::size_t c = 0; c < chunks; ++c) begins_[c + 1] += begins_[c];
    next_ = begins_;
    order_.resize(chunk_of.size());
    for (std::size_t i = 0; i < chunk_of.size(); ++i) {
      order_[next_[chunk_of[i]]++] = static_cast<std::uint32_t>(i);
    }
  }

  Vector<std::uint32_t> begins_;  // of each chunk in order_; one entry more
  Vector<std::uint32_t> next_;
  Vector<std::uint32_t> order_;
  Vector<std::byte> bytes_;
  std::vector<PieceRef> pieces_;
  std::vector<std::pair<std::size_t, std::size_t>> extents_;  // of the pieces in bytes_
};

}  // namespace tetfusion
