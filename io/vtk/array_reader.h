// One array of a VTK file, read in chunks that are independent of one another.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "base/blocks.h"
#include "base/vector.h"
#include "io/files/mapped_file.h"
#include "io/vtk/byte_stream.h"
#include "io/vtk/computed_array.h"
#include "io/vtk/decode.h"
#include "mesh/data_array.h"

namespace tetfusion {

// What all binary arrays of a file have in common.
struct BinaryLayout {
  Compressor compressor = Compressor::kNone;
  // Of one number of an array's header: 4 or 8. 0: no array has a header, or is compressed, and the
  // number of values is known.
  std::size_t header_bytes = 4;
  bool swap = false;  // the file's byte order is not this machine's
};

struct ArraySource {
  static constexpr std::uint64_t kUnknown = static_cast<std::uint64_t>(-1);
  const MappedFile* file = nullptr;  // outlives the reader
  std::string label;                 // for messages: point array "Density" of piece 2
  Payload payload;
  BinaryLayout layout;
  ValueType type = ValueType::kFloat32;
  std::uint64_t values = kUnknown;                          // what the rest of the file says
  std::shared_ptr<const ComputedArray> computed = nullptr;  // instead of a payload
};

// The most values that a payload of this length can hold.
std::uint64_t max_values(const Payload& payload, const BinaryLayout& layout, ValueType type);

// Some values, in native byte order but not aligned: load them with memcpy.
struct Chunk {
  std::uint64_t first = 0;  // index of the first value
  std::uint64_t count = 0;
  const std::byte* data = nullptr;  // in the file or in the scratch memory
};

// The constructor reads the array's header and compares it with the number of values expected;
// nothing is allocated that the file is too short for. Everything throws Error(kBadInput) with path
// and label. Safe to use from several threads.
//
// Reading takes the pages of the file that it has mapped out of the process again, but for arrays
// of less than 64 KiB. What stays with the reader: 8 bytes for each compressed block, 16 for each
// 256 KiB of text, 8 for each 64 KiB of base64 that has line breaks; while it reads, each thread
// has one chunk of it and what that is decoded from.
class ArrayReader {
 public:
  explicit ArrayReader(ArraySource source);

  ValueType type() const { return source_.type; }
  std::uint64_t values() const { return source_.values; }
  // Of the largest part that is decoded as one, decoded; 256 KiB or less, unless the array is in
  // compressed blocks that are larger, or text of which a word is.
  std::uint64_t chunk_bytes() const;
  // What the threads have in hand while a compressed array is read, beside what is made of it: the
  // largest of such parts, its bytes in the file, and those out of base64. 0 of other arrays.
  std::uint64_t decoding_bytes() const;

  // Calls f(chunk) for all values, or for those from `first` on, from several threads: each value
  // is in one chunk. Chunks ascend with the values, and the lowest one's exception comes out. The
  // values are there.
  template <class F>
  void for_each_chunk(F f) const {
    for_each_chunk(0, values(), f);
  }
  template <class F>
  void for_each_chunk(std::uint64_t first, std::uint64_t count, F f) const;

  // These values into `out`, which has room for them.
  void read(std::uint64_t first, std::uint64_t count, std::byte* out) const;
  void read_all(std::byte* out) const { read(0, values(), out); }

  // A checksum of the array's bytes as they lie in the file, and of what says how they are to be
  // read: arrays that have the same one from the same `seed` have the same values. Not for computed
  // ones. Calls `check`, which may throw, now and then.
  std::uint64_t checksum_in_file(std::uint64_t seed, const std::function<void()>& check) const;

  std::string message(const std::string& what) const;  // FILE: LABEL: what
  // Throws Error(kBadInput) with that message.
  [[noreturn]] void fail(const std::string& what) const;
  // " (byte N)" for a value that lies in the file as it is, else "".
  std::string where(std::uint64_t value) const;

 private:
  void open_plain(const ByteStream& stream);
  void open_compressed(const ByteStream& stream);
  void read_block_table(const std::byte* sizes, std::uint64_t full_blocks, std::uint64_t partial);
  void open_ascii();
  void open_computed();
  std::span<const std::byte> bytes(std::uint64_t begin, std::uint64_t end) const {
    return source_.file->bytes().subspan(begin, end - begin);
  }
  void expect_bytes(std::uint64_t bytes);
  bool is_compressed() const {
    return source_.layout.compressor != Compressor::kNone &&
           source_.payload.coding != Coding::kAscii;
  }

  std::size_t chunk_of(std::uint64_t value) const;
  // Those values of a chunk that lie in [first, last): there is one at least.
  Chunk chunk(std::size_t index, std::uint64_t first, std::uint64_t last,
              DecodeScratch* scratch) const;
  Chunk plain_chunk(std::uint64_t first, std::uint64_t last, DecodeScratch* scratch) const;
  Chunk compressed_chunk(std::size_t index, DecodeScratch* scratch) const;
  Chunk ascii_chunk(std::size_t index, DecodeScratch* scratch) const;
  Chunk computed_chunk(std::size_t index, DecodeScratch* scratch) const;
  // Takes their pages out of the process, and what lies `around` them.
  void release_chunks(std::size_t begin, std::size_t end, bool around) const;
  ByteStream::FileRange place_of_chunks(std::size_t begin, std::size_t end) const;

  ArraySource source_;
  std::size_t value_bytes_ = 1;
  std::size_t chunks_ = 0;
  ByteStream data_;

  std::uint64_t block_bytes_ = 0;      // of a full block, decompressed
  Vector<std::uint64_t> block_begin_;  // in the compressed bytes; one entry more
  std::size_t blocks_per_chunk_ = 1;

  Vector<std::uint64_t> text_begin_;  // of each chunk of text, in the file; one entry more
  Vector<std::uint64_t> first_word_;  // of each chunk, of computed ones too; one entry more
};

template <class F>
void ArrayReader::for_each_chunk(std::uint64_t first, std::uint64_t count, F f) const {
  if (count == 0) return;
  const std::uint64_t last = first + count;
  const std::size_t first_chunk = chunk_of(first);
  const std::size_t last_chunk = chunk_of(last - 1) + 1;
  // A few chunks in a row share one scratch, and one system call.
  constexpr std::size_t kRun = 8;
  for_each_block(last_chunk - first_chunk, kRun,
                 [&](std::size_t, std::size_t begin, std::size_t end) {
                   DecodeScratch scratch;
                   for (std::size_t i = first_chunk + begin; i < first_chunk + end; ++i) {
                     f(chunk(i, first, last, &scratch));
                   }
                   release_chunks(first_chunk + begin, first_chunk + end, false);
                 });
  release_chunks(first_chunk, last_chunk, true);
}

}  // namespace tetfusion
