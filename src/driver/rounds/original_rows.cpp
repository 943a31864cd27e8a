#include "driver/rounds/original_rows.h"

#include <numeric>

#include "base/pool.h"
#include "base/serialize.h"
#include "base/tasks.h"

namespace tetfusion {

void OriginalRows::begin() {
  store_.reset();  // its name is free again
  store_ = scratch_->begin(name_);
}

// A piece: the number of rows, and the columns.
void OriginalRows::add(std::uint32_t chunk, std::uint64_t rows,
                       const std::function<void(RowWriter*)>& write) {
  if (rows == 0) return;
  ByteWriter count;
  count.put(rows);
  Vector<std::byte> piece = count.take();
  constexpr std::uint64_t kPadding = 8;  // of a column, at most
  piece.reserve(piece.size() + rows * row_bytes() + kPadding * strides_.size());
  RowWriter writer(&piece);
  write(&writer);
  const PieceRef ref{chunk, piece};
  store_->add(chunk, {&ref, 1});
}

void OriginalRows::keep() {
  if (!is_kept_) scratch_->keep(name_);
  is_kept_ = true;
}

void OriginalRows::resume(Checkpoint* from) {
  store_ = from->take_kept(name_, "the original's values");
  is_kept_ = true;
}

std::uint64_t OriginalRows::row_bytes() const {
  return std::accumulate(strides_.begin(), strides_.end(), std::uint64_t{0});
}

OriginalPiece::OriginalPiece(std::span<const std::byte> piece,
                             const std::vector<std::size_t>& strides) {
  RowReader reader(piece);
  rows = reader.items();
  for (const std::size_t s : strides) columns.push_back(reader.take_bytes(rows * s));
}

void SortedRows::sort(const std::string& name, std::uint32_t chunks, int threads, Scratch* scratch,
                      const ChunksOf& chunks_of) {
  auto sorted = scratch->begin(name);
  const std::vector<std::size_t>& strides = rows_->strides();
  Pool<WindowPieces> tools;
  run_tasks(chunks_, threads, [&](std::size_t c, std::size_t) {
    const auto chunk = static_cast<std::uint32_t>(c);
    rows_->store().read(chunk)->use([&](const auto& pieces) {
      if (pieces.empty()) return;
      const OriginalPiece piece(pieces[0], strides);
      tools.borrow()->add(chunk, chunks_of(piece), chunks, sorted.get(),
                          [&](const auto& items, RowWriter* to) {
                            for (std::size_t k = 0; k < strides.size(); ++k) {
                              to->put_rows(piece.columns[k], strides[k], items);
                            }
                          });
    });
  });
  sorted->seal();
  sorted_ = std::move(sorted);
}

std::uint64_t SortedRows::count(std::uint32_t chunk) const {
  return (sorted_ ? sorted_->bytes(chunk) : rows_->store().bytes()) / rows_->row_bytes();
}

void SortedRows::for_each_piece(std::uint32_t chunk,
                                const std::function<void(const OriginalPiece& piece)>& use) const {
  const auto use_piece = [&](std::span<const std::byte> piece) {
    use(OriginalPiece(piece, rows_->strides()));
  };
  if (sorted_) return sorted_->for_each(chunk, use_piece);
  for (std::uint32_t c = 0; c < chunks_; ++c) rows_->store().for_each(c, use_piece);
}

}  // namespace tetfusion
