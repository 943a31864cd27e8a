// Rows of the original, of its points or cells, that a run puts aside in its first round and looks
// at again when all is done: where they lie, and values.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "driver/rounds/windows.h"
#include "io/store/scratch.h"

namespace tetfusion {

// Rows as columns, from chunks of the original.
class OriginalRows {
 public:
  // Of columns with so many bytes a row. The scratch outlives this.
  OriginalRows(Scratch* scratch, std::string name, std::vector<std::size_t> strides)
      : scratch_(scratch), name_(std::move(name)), strides_(std::move(strides)) {}

  // What was put aside before is forgotten.
  void begin();
  // Each chunk once, from any thread; write(writer) writes the columns.
  void add(std::uint32_t chunk, std::uint64_t rows, const std::function<void(RowWriter*)>& write);
  void end() { store_->seal(); }

  // After end(): so that the run can be gone on with.
  void keep();
  // Takes up what was kept. Throws Error(kIo) if it is not there.
  void resume(Checkpoint* from);

  const std::vector<std::size_t>& strides() const { return strides_; }
  std::uint64_t row_bytes() const;
  const PieceStore& store() const { return *store_; }  // a bucket a chunk

 private:
  Scratch* scratch_;
  std::string name_;
  std::vector<std::size_t> strides_;
  std::unique_ptr<PieceStore> store_;
  bool is_kept_ = false;
};

// A piece of them.
struct OriginalPiece {
  OriginalPiece(std::span<const std::byte> piece, const std::vector<std::size_t>& strides);
  template <class T>
  std::span<const T> column(std::size_t c) const {
    return {reinterpret_cast<const T*>(columns[c]), rows};
  }
  std::uint64_t rows;
  std::vector<const std::byte*> columns;
};

// The same by the chunks of another mesh.
class SortedRows {
 public:
  // `rows` of so many chunks, which outlive this. They are for one chunk until sort() is called.
  SortedRows(const OriginalRows& rows, std::uint32_t chunks) : rows_(&rows), chunks_(chunks) {}

  // chunks_of(piece) says to which of the other mesh's chunks each row belongs.
  using ChunksOf = std::function<Vector<std::uint32_t>(const OriginalPiece& piece)>;
  void sort(const std::string& name, std::uint32_t chunks, int threads, Scratch* scratch,
            const ChunksOf& chunks_of);

  std::uint64_t count(std::uint32_t chunk) const;
  // Calls use(piece) with each that has rows of the chunk.
  void for_each_piece(std::uint32_t chunk,
                      const std::function<void(const OriginalPiece& piece)>& use) const;

 private:
  const OriginalRows* rows_;
  std::uint32_t chunks_;
  std::unique_ptr<PieceStore> sorted_;
};

}  // namespace tetfusion
