// From the bytes of a VTK XML file to values: base64, byte order, compressed blocks, decimal text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "base/vector.h"
#include "mesh/data_array.h"

struct libdeflate_decompressor;

namespace tetfusion {

enum class Compressor : std::uint8_t { kNone, kZlib, kLz4, kLzma };

// No block of `bytes` compressed bytes can hold more than this many bytes: what bounds the sizes
// that a damaged file may claim. Zero only for zero bytes.
std::uint64_t max_decompressed_bytes(Compressor compressor, std::uint64_t bytes);

// Working memory of one thread; reused from block to block.
struct DecodeScratch {
  DecodeScratch();
  ~DecodeScratch();
  DecodeScratch(const DecodeScratch&) = delete;
  DecodeScratch& operator=(const DecodeScratch&) = delete;

  Vector<std::byte> encoded;  // bytes out of base64
  Vector<std::byte> values;
  struct FreeInflater {
    void operator()(libdeflate_decompressor* p) const;
  };
  std::unique_ptr<libdeflate_decompressor, FreeInflater> inflater;  // made when first needed
};

// Decompresses one block, which must fill `out` exactly. False when it is damaged.
bool decompress(Compressor compressor, std::span<const std::byte> block, std::span<std::byte> out,
                DecodeScratch* scratch);

// Decodes whole groups of four characters into `out`, three bytes a group. Only the last group may
// be padded with '='; the bytes it lacks are set to zero. Returns the number of bytes that are
// there, or npos when a character is not base64.
inline constexpr std::size_t kBadBase64 = static_cast<std::size_t>(-1);
std::size_t decode_base64(std::string_view groups, std::byte* out);

// Reverses the bytes of each value of `size` (1, 2, 4 or 8) bytes in place.
void swap_bytes(std::span<std::byte> values, std::size_t size);

// The number of words between blanks.
std::size_t count_words(std::string_view text);

// Parses as many numbers of `type` as `text` has words into `out`. Returns the word that is not a
// number of that type (a view into `text`), or an empty view when all are. Real numbers too small
// for the type become zero or denormal; too large ones are not numbers.
std::string_view parse_words(std::string_view text, ValueType type, std::byte* out);

// An unsigned number of `size` (4 or 8) bytes.
std::uint64_t load_unsigned(const std::byte* bytes, std::size_t size, bool swap);

}  // namespace tetfusion
