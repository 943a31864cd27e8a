// What a compressed block may ask for.
#include "io/vtk/decode.h"

#include <gtest/gtest.h>
#include <lzma.h>

#include <cstring>
#include <string>
#include <string_view>

namespace tetfusion {
namespace {

// A block of LZMA that asks for a dictionary of 2^exponent bytes, whatever it needs. In the header
// of an .xz block the filter's number, 0x21, stands before the size of its one property.
std::string with_dictionary(const std::string& text, unsigned exponent) {
  std::string block(1024, '\0');
  std::size_t size = 0;
  EXPECT_EQ(lzma_easy_buffer_encode(
                0, LZMA_CHECK_CRC32, nullptr, reinterpret_cast<const std::uint8_t*>(text.data()),
                text.size(), reinterpret_cast<std::uint8_t*>(block.data()), &size, block.size()),
            LZMA_OK);
  block.resize(size);
  constexpr std::size_t kHeader = LZMA_STREAM_HEADER_SIZE;
  const std::size_t bytes = 4 * (static_cast<std::size_t>(block[kHeader]) + 1);
  const std::size_t property = block.find(std::string_view("\x21\x01", 2), kHeader);
  block[property + 2] = static_cast<char>(2 * (exponent - 12));
  const std::uint32_t sum = lzma_crc32(
      reinterpret_cast<const std::uint8_t*>(block.data()) + kHeader, bytes - sizeof sum, 0);
  std::memcpy(block.data() + kHeader + bytes - sizeof sum, &sum, sizeof sum);
  return block;
}

TEST(Decompress, LzmaTakesTheMemoryOfItsStrongestPresetAndNoMore) {
  const std::string text = "a few bytes";
  DecodeScratch scratch;
  for (const unsigned exponent : {12u, 26u, 27u, 29u}) {
    std::string out(text.size(), '\0');
    const std::string block = with_dictionary(text, exponent);
    const bool taken = decompress(Compressor::kLzma, std::as_bytes(std::span(block)),
                                  std::as_writable_bytes(std::span(out)), &scratch);
    EXPECT_EQ(taken, exponent <= 26) << exponent;
    if (taken) {
      EXPECT_EQ(out, text);
    }
  }
}

}  // namespace
}  // namespace tetfusion
