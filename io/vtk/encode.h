// How the values of a .vtu array become bytes: base64, text, compressed blocks. Each works on many
// values at once, in parallel, and gives the same bytes for any number of threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "base/vector.h"
#include "mesh/data_array.h"

namespace tetfusion {

// Characters that base64 needs for that many bytes, padding included.
constexpr std::uint64_t base64_size(std::uint64_t bytes) { return (bytes + 2) / 3 * 4; }

// Replaces *out by the base64 text (RFC 4648, padded) of the bytes. Texts of parts whose sizes are
// multiples of three may be joined.
void base64_encode(std::span<const std::byte> bytes, Vector<char>* out);

// Where in an array a run of values lies: line breaks follow from it.
struct TextPosition {
  std::uint64_t first_value;  // index in the array of the run's first value
  std::uint32_t components;
};

// Replaces *out by the values as text: the shortest form that reads back to the same bits, and
// "nan", "inf", "-inf"; whole tuples a line, about 12 values. `values` holds native values of
// `type`; kString counts as UInt8.
void text_encode(ValueType type, std::span<const std::byte> values, TextPosition position,
                 Vector<char>* out);

enum class Compression { kZlib, kLz4 };

// Keeps its buffer from one call to the next. Not thread-safe; parallel inside. What zlib blocks
// consist of depends on the processor as little as ISA-L does: on x86-64 it is the same wherever
// there is SSE 4.2, on other processors it may be another, which inflates to the same values.
class BlockCompressor {
 public:
  explicit BlockCompressor(Compression compression);

  std::size_t block_bytes() const { return block_bytes_; }
  // So much is worked on at a time: enough for all threads. A multiple of block_bytes().
  std::size_t batch_bytes() const { return batch_blocks_ * block_bytes_; }

  // Compresses each run of block_bytes() of the input on its own (the last one may be shorter), as
  // vtkZLibDataCompressor and vtkLZ4DataCompressor do, and hands the results to `sink` in order,
  // one at a time, from any thread. Throws what sink() has thrown first, after which it is not
  // called again, and Error(kMemory) when a compressor cannot be set up.
  using Sink = std::function<void(std::span<const std::byte> block)>;
  void compress(std::span<const std::byte> bytes, const Sink& sink);

 private:
  void compress_batch(std::span<const std::byte> bytes, const Sink& sink);

  Compression compression_;
  std::size_t block_bytes_;
  std::size_t batch_blocks_;
  std::size_t bound_;  // no block's result is larger
  Vector<std::byte> results_;
};

}  // namespace tetfusion
