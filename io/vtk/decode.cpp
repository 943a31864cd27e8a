#include "io/vtk/decode.h"

#include <libdeflate.h>
#include <lz4.h>
#include <lzma.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <string>
#include <type_traits>

#include "base/numbers.h"

namespace tetfusion {

std::uint64_t max_decompressed_bytes(Compressor compressor, std::uint64_t bytes) {
  // Deflate's longest match, 258 bytes, costs two bits; LZ4 adds at most 255 bytes with each byte;
  // LZMA's longest match, 273 bytes, costs about eight well predicted bits of a fiftieth of a bit
  // each.
  std::uint64_t ratio = 1;
  if (compressor == Compressor::kZlib) ratio = 1032;
  if (compressor == Compressor::kLz4) ratio = 255;
  if (compressor == Compressor::kLzma) ratio = 16384;
  constexpr std::uint64_t kMax = std::numeric_limits<std::uint64_t>::max();
  return bytes > kMax / ratio ? kMax : bytes * ratio;
}

DecodeScratch::DecodeScratch() = default;
DecodeScratch::~DecodeScratch() = default;

void DecodeScratch::FreeInflater::operator()(libdeflate_decompressor* p) const {
  libdeflate_free_decompressor(p);
}

namespace {

bool decompress_zlib(std::span<const std::byte> block, std::span<std::byte> out,
                     DecodeScratch* scratch) {
  if (!scratch->inflater) {
    scratch->inflater.reset(libdeflate_alloc_decompressor());
    if (!scratch->inflater) throw std::bad_alloc();
  }
  // Without a place for the number of bytes made, fewer bytes than `out` has are a failure.
  return libdeflate_zlib_decompress(scratch->inflater.get(), block.data(), block.size(), out.data(),
                                    out.size(), nullptr) == LIBDEFLATE_SUCCESS;
}

bool decompress_lz4(std::span<const std::byte> block, std::span<std::byte> out) {
  constexpr std::size_t kMax = std::numeric_limits<int>::max();
  if (block.size() > kMax || out.size() > kMax) return false;
  const int made = LZ4_decompress_safe(
      reinterpret_cast<const char*>(block.data()), reinterpret_cast<char*>(out.data()),
      static_cast<int>(block.size()), static_cast<int>(out.size()));
  return made >= 0 && static_cast<std::size_t>(made) == out.size();
}

bool decompress_lzma(std::span<const std::byte> block, std::span<std::byte> out) {
  std::uint64_t memory_limit = std::uint64_t{72} << 20;  // the strongest preset needs 65 MiB
  std::size_t in_at = 0;
  std::size_t out_at = 0;
  const lzma_ret result = lzma_stream_buffer_decode(
      &memory_limit, 0, nullptr, reinterpret_cast<const std::uint8_t*>(block.data()), &in_at,
      block.size(), reinterpret_cast<std::uint8_t*>(out.data()), &out_at, out.size());
  return result == LZMA_OK && out_at == out.size();
}

}  // namespace

bool decompress(Compressor compressor, std::span<const std::byte> block, std::span<std::byte> out,
                DecodeScratch* scratch) {
  switch (compressor) {
    case Compressor::kNone:
      break;
    case Compressor::kZlib:
      return decompress_zlib(block, out, scratch);
    case Compressor::kLz4:
      return decompress_lz4(block, out);
    case Compressor::kLzma:
      return decompress_lzma(block, out);
  }
  if (block.size() != out.size()) return false;
  std::copy(block.begin(), block.end(), out.begin());
  return true;
}

namespace {

// The six bits of each character; the top bit says that it is no base64 character.
constexpr std::uint8_t kNotBase64 = 0x80;
constexpr std::array<std::uint8_t, 256> make_base64_table() {
  std::array<std::uint8_t, 256> table{};
  table.fill(kNotBase64);
  constexpr std::string_view kAlphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < kAlphabet.size(); ++i) {
    table[static_cast<unsigned char>(kAlphabet[i])] = static_cast<std::uint8_t>(i);
  }
  return table;
}
constexpr std::array<std::uint8_t, 256> kBase64Table = make_base64_table();

// Returns the bits of all characters joined by "or", to be tested for kNotBase64.
inline std::uint8_t decode_group(const char* in, std::byte* out) {
  const std::uint8_t a = kBase64Table[static_cast<unsigned char>(in[0])];
  const std::uint8_t b = kBase64Table[static_cast<unsigned char>(in[1])];
  const std::uint8_t c = kBase64Table[static_cast<unsigned char>(in[2])];
  const std::uint8_t d = kBase64Table[static_cast<unsigned char>(in[3])];
  const std::uint32_t word = (std::uint32_t{a} << 18) | (std::uint32_t{b} << 12) |
                             (std::uint32_t{c} << 6) | std::uint32_t{d};
  out[0] = static_cast<std::byte>(word >> 16);
  out[1] = static_cast<std::byte>(word >> 8);
  out[2] = static_cast<std::byte>(word);
  return static_cast<std::uint8_t>(a | b | c | d);
}

}  // namespace

std::size_t decode_base64(std::string_view groups, std::byte* out) {
  const std::size_t count = groups.size() / 4;
  if (count == 0) return 0;
  std::uint8_t bad = 0;
  for (std::size_t i = 0; i + 1 < count; ++i) {
    bad |= decode_group(groups.data() + 4 * i, out + 3 * i);
  }
  std::array<char, 4> last{};
  std::copy_n(groups.data() + 4 * (count - 1), 4, last.begin());
  std::size_t padding = 0;
  while (padding < 2 && last[3 - padding] == '=')
    last[3 - padding++] = 'A';  // 'A' is six zero bits
  bad |= decode_group(last.data(), out + 3 * (count - 1));
  return (bad & kNotBase64) != 0 ? kBadBase64 : 3 * count - padding;
}

namespace {

template <class Word>
void swap_words(std::span<std::byte> values) {
  for (std::size_t i = 0; i + sizeof(Word) <= values.size(); i += sizeof(Word)) {
    Word word;
    std::memcpy(&word, values.data() + i, sizeof(Word));
    if constexpr (sizeof(Word) == 2) word = __builtin_bswap16(word);
    if constexpr (sizeof(Word) == 4) word = __builtin_bswap32(word);
    if constexpr (sizeof(Word) == 8) word = __builtin_bswap64(word);
    std::memcpy(values.data() + i, &word, sizeof(Word));
  }
}

}  // namespace

void swap_bytes(std::span<std::byte> values, std::size_t size) {
  if (size == 2) swap_words<std::uint16_t>(values);
  if (size == 4) swap_words<std::uint32_t>(values);
  if (size == 8) swap_words<std::uint64_t>(values);
}

std::uint64_t load_unsigned(const std::byte* bytes, std::size_t size, bool swap) {
  if (size == 4) {
    std::uint32_t word;
    std::memcpy(&word, bytes, sizeof(word));
    return swap ? __builtin_bswap32(word) : word;
  }
  std::uint64_t word;
  std::memcpy(&word, bytes, sizeof(word));
  return swap ? __builtin_bswap64(word) : word;
}

namespace {

// XML's blanks are all at or below the space, and no other character there may occur in XML.
inline bool is_white(char c) { return static_cast<unsigned char>(c) <= ' '; }

template <class T>
bool parse_word(std::string_view word, T* value) {
  word = without_plus(word);
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, *value);
  if (stop != end) return false;
  if (error == std::errc()) return true;
  if constexpr (std::is_floating_point_v<T>) {
    if (error != std::errc::result_out_of_range) return false;
    // Too large or too small is the same error; the value tells which.
    *value = out_of_range_number<T>(word);
    return std::isfinite(*value);
  }
  return false;
}

// Keeps the low bytes of a T, where a Stored has fewer.
template <class T, class Stored = T>
std::string_view parse_words_as(std::string_view text, std::byte* out) {
  const char* p = text.data();
  const char* const end = p + text.size();
  for (;;) {
    while (p != end && is_white(*p)) ++p;
    if (p == end) return {};
    const char* const begin = p;
    while (p != end && !is_white(*p)) ++p;
    const std::string_view word(begin, static_cast<std::size_t>(p - begin));
    T value{};
    if (!parse_word(word, &value)) return word;
    const auto stored = static_cast<Stored>(value);
    if constexpr (!std::is_same_v<T, Stored>) {
      if (value < -128 || value > 255) return word;
    }
    std::memcpy(out, &stored, sizeof stored);
    out += sizeof stored;
  }
}

}  // namespace

std::size_t count_words(std::string_view text) {
  std::size_t count = 0;
  bool blank = true;
  for (const char c : text) {
    const bool now = is_white(c);
    count += blank && !now ? 1 : 0;
    blank = now;
  }
  return count;
}

std::string_view parse_words(std::string_view text, ValueType type, std::byte* out) {
  // VTK writes what is beyond ASCII as signed numbers.
  if (type == ValueType::kString) return parse_words_as<std::int16_t, std::uint8_t>(text, out);
  return visit_type(type, [&](auto zero) { return parse_words_as<decltype(zero)>(text, out); });
}

}  // namespace tetfusion
