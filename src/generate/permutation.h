// A permutation of 0 .. n - 1 that needs no table.
#pragma once

#include <array>
#include <cstdint>

namespace tetfusion {

// forward() and inverse() undo each other. Immutable, so thread-safe.
class Permutation {
 public:
  static constexpr std::uint64_t kMaxSize = std::uint64_t{1} << 48;

  // Of 0 .. size - 1; 1 <= size <= kMaxSize. Different seeds give different permutations.
  Permutation(std::uint64_t size, std::uint64_t seed);
  std::uint64_t forward(std::uint64_t i) const;
  std::uint64_t inverse(std::uint64_t i) const;

 private:
  static constexpr int kRounds = 6;
  std::uint64_t round_value(int round, std::uint64_t half, std::uint64_t range) const;
  std::uint64_t scramble(std::uint64_t i) const;
  std::uint64_t unscramble(std::uint64_t i) const;

  std::uint64_t size_;
  std::uint64_t rows_, columns_;  // rows_ * columns_ >= size_, just so
  std::array<std::uint64_t, kRounds> keys_;
};

}  // namespace tetfusion
