// Numbers that are near one another, told apart in all of their bits.
#pragma once

#include <cstdint>

namespace tetfusion {

// One to one: the finaliser of splitmix64 (Steele, Lea and Flood, Fast Splittable Pseudorandom
// Number Generators, 2014).
constexpr std::uint64_t mix(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15u;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

}  // namespace tetfusion
