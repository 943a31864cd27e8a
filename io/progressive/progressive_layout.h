// What ProgressiveWriter and ProgressiveFile agree on (FORMAT.md).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "io/files/checksum.h"
#include "io/progressive/progressive_file.h"

namespace tetfusion::progressive {

inline constexpr std::array<char, 8> kMagic{'T', 'F', 'P', 'R', 'O', 'G', 'R', 'S'};
inline constexpr std::uint32_t kByteOrder = 0x01020304;
inline constexpr std::uint32_t kVersion = 3;
// What is written where no array has units, so that older programs read it: they are not in it.
inline constexpr std::uint32_t kVersionWithoutUnits = 2;

enum Kind : std::uint32_t {
  kDescription,
  kPoints,
  kTets,
  kLower,
  kSpare,
  kFusions,
  kRewound,
  kErrors
};

struct Header {
  std::array<char, 8> magic = kMagic;
  std::uint32_t byte_order = kByteOrder;
  std::uint32_t version = kVersion;
  std::uint64_t file_bytes = 0;
  std::uint64_t table = 0;
  std::uint64_t sections = 0;
  std::uint64_t table_sum = 0;
  ProgressiveCounts counts;
  std::uint32_t point_row = 0;
  std::uint32_t cell_row = 0;
  std::uint64_t sum = 0;
};
static_assert(sizeof(Header) == 112 && std::has_unique_object_representations_v<Header>);

// Bits that say of a tetrahedron of the star whose it was, where so many were fused into the kept
// point.
inline std::uint32_t star_bits(std::uint32_t gone) { return gone > 1 ? 2 : 1; }

using TableRow = std::array<std::uint64_t, 6>;

inline std::uint64_t header_sum(const Header& header) {
  return checksum(std::as_bytes(std::span(&header, 1)).first(offsetof(Header, sum)));
}

}  // namespace tetfusion::progressive
