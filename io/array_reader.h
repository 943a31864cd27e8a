// One array of a VTK XML file, read in chunks that are independent of one another.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "base/error.h"
#include "base/vector.h"
#include "io/decode.h"
#include "io/mapped_file.h"
#include "mesh/blocks.h"
#include "mesh/data_array.h"

namespace tetfusion {

enum class Coding : std::uint8_t { kRaw, kBase64, kAscii };

// Where an array's bytes lie in the file. In appended data `end` is the end of all arrays.
struct Payload {
  Coding coding = Coding::kRaw;
  bool appended = false;
  std::uint64_t begin = 0;
  std::uint64_t end = 0;
};

// What all binary arrays of a file have in common.
struct BinaryLayout {
  Compressor compressor = Compressor::kNone;
  std::size_t header_bytes = 4;  // of one number of an array's header: 4 or 8
  bool swap = false;             // the file's byte order is not this machine's
};

struct ArraySource {
  static constexpr std::uint64_t kUnknown = static_cast<std::uint64_t>(-1);
  const MappedFile* file = nullptr;  // outlives the reader
  std::string label;                 // for messages: point array "Density" of piece 2
  Payload payload;
  BinaryLayout layout;
  ValueType type = ValueType::kFloat32;
  std::uint64_t values = kUnknown;  // what the rest of the file says
};

// The most values that a payload of this length can hold.
std::uint64_t max_values(const Payload& payload, const BinaryLayout& layout, ValueType type);

// A run of bytes in the file, as they are or as base64 text.
class ByteStream {
 public:
  ByteStream() = default;
  ByteStream(std::span<const std::byte> encoded, Coding coding, std::uint64_t first = 0)
      : encoded_(encoded), coding_(coding), first_(first) {}

  std::uint64_t max_bytes() const;

  // `count` bytes from `offset` on, which live as long as `scratch` is left alone; nullptr when the
  // stream is shorter or not base64.
  const std::byte* view(std::uint64_t offset, std::uint64_t count,
                        Vector<std::byte>* scratch) const;

  // What follows `bytes` bytes from the start. Base64 goes on in the same group of four characters,
  // unless the bytes were encoded for themselves (`own_groups`).
  ByteStream after(std::uint64_t bytes, bool own_groups) const;
  bool padded_within(std::uint64_t bytes) const;  // base64 that ends within the first `bytes` bytes

 private:
  std::span<const std::byte> encoded_;
  Coding coding_ = Coding::kRaw;
  std::uint64_t first_ = 0;  // bytes of the first group that belong to something else
};

// Values of one chunk, in native byte order but not aligned: load them with memcpy.
struct Chunk {
  std::uint64_t first = 0;  // index of the first value
  std::uint64_t count = 0;
  const std::byte* data = nullptr;  // in the file or in the scratch memory
};

// The constructor reads the array's header and compares it with the number of values expected;
// nothing is allocated that the file is too short for. Everything throws Error(kBadInput) with path
// and label. Safe to use from several threads, each with a scratch of its own.
class ArrayReader {
 public:
  explicit ArrayReader(ArraySource source);

  ValueType type() const { return source_.type; }
  std::uint64_t values() const { return source_.values; }
  std::size_t chunks() const { return chunks_; }
  Chunk chunk(std::size_t index, DecodeScratch* scratch) const;

  // Calls f(chunk) for all chunks from several threads. The lowest chunk's exception comes out.
  template <class F>
  void for_each_chunk(F f) const;

  // All values into `out`, which has room for them.
  void read_all(std::byte* out) const;

  std::string message(const std::string& what) const;  // FILE: LABEL: what
  // Throws Error(kBadInput) with that message.
  [[noreturn]] void fail(const std::string& what) const;
  // " (byte N)" for a value that lies in the file as it is, else "".
  std::string where(std::uint64_t value) const;

 private:
  void open_plain(ByteStream stream);
  void open_compressed(ByteStream stream);
  void open_ascii();
  std::span<const std::byte> bytes(std::uint64_t begin, std::uint64_t end) const {
    return source_.file->bytes().subspan(begin, end - begin);
  }
  std::span<const std::byte> without_blanks(std::span<const std::byte> encoded);
  void expect_bytes(std::uint64_t bytes);
  Chunk plain_chunk(std::size_t index, DecodeScratch* scratch) const;
  Chunk compressed_chunk(std::size_t index, DecodeScratch* scratch) const;
  Chunk ascii_chunk(std::size_t index, DecodeScratch* scratch) const;

  ArraySource source_;
  std::size_t value_bytes_ = 1;
  std::size_t chunks_ = 0;
  ByteStream data_;
  Vector<std::byte> stripped_;  // base64 text without line breaks, where it had some

  std::uint64_t block_bytes_ = 0;      // of a full block, decompressed
  Vector<std::uint64_t> block_begin_;  // in the compressed bytes; one entry more
  std::size_t blocks_per_chunk_ = 1;

  Vector<std::uint64_t> text_begin_;  // of each chunk of text, in the file; one entry more
  Vector<std::uint64_t> first_word_;  // of each chunk; one entry more
};

template <class F>
void ArrayReader::for_each_chunk(F f) const {
  // A few chunks in a row share one scratch.
  constexpr std::size_t kRun = 4;
  for_each_block(chunks_, kRun, [&](std::size_t, std::size_t begin, std::size_t end) {
    DecodeScratch scratch;
    for (std::size_t i = begin; i < end; ++i) f(chunk(i, &scratch));
  });
}

}  // namespace tetfusion
