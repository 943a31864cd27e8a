// XXH3, 64 bits: tells damage by accident, not by intent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tetfusion {

std::uint64_t checksum(std::span<const std::byte> bytes, std::uint64_t seed = 0);

}  // namespace tetfusion
