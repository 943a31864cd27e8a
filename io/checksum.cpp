#include "io/checksum.h"

#define XXH_INLINE_ALL  // twice as fast as the library on Debian
#include <xxhash.h>

namespace tetfusion {

std::uint64_t checksum(std::span<const std::byte> bytes, std::uint64_t seed) {
  return XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

}  // namespace tetfusion
