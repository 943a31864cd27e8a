#include "generate/permutation.h"
#include "base/mix.h"

#include <cmath>

namespace tetfusion {

// A Feistel network on (row, column) pairs (Black & Rogaway 2002, "Ciphers with arbitrary finite
// domains"): each round adds to one half a hash of the other one, modulo that half's range. The
// pairs are a few more than the numbers; what falls outside goes round again until it is inside
// (cycle walking), so that the whole stays a bijection.
Permutation::Permutation(std::uint64_t size, std::uint64_t seed) : size_(size) {
  rows_ = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(size)));
  if (rows_ == 0) rows_ = 1;
  columns_ = (size + rows_ - 1) / rows_;
  std::uint64_t key = mix(seed);
  for (auto& k : keys_) k = key = mix(key);
}

// Ranges stay below 2^25, so 32 bits of hash are spread over them evenly enough.
std::uint64_t Permutation::round_value(int round, std::uint64_t half, std::uint64_t range) const {
  const std::uint64_t hash = mix(half ^ keys_[static_cast<std::size_t>(round)]) >> 32;
  return (hash * range) >> 32;
}

std::uint64_t Permutation::scramble(std::uint64_t i) const {
  std::uint64_t row = i / columns_;
  std::uint64_t column = i % columns_;
  for (int round = 0; round < kRounds; round += 2) {
    row += round_value(round, column, rows_);
    if (row >= rows_) row -= rows_;
    column += round_value(round + 1, row, columns_);
    if (column >= columns_) column -= columns_;
  }
  return row * columns_ + column;
}

std::uint64_t Permutation::unscramble(std::uint64_t i) const {
  std::uint64_t row = i / columns_;
  std::uint64_t column = i % columns_;
  for (int round = kRounds - 2; round >= 0; round -= 2) {
    column += columns_ - round_value(round + 1, row, columns_);
    if (column >= columns_) column -= columns_;
    row += rows_ - round_value(round, column, rows_);
    if (row >= rows_) row -= rows_;
  }
  return row * columns_ + column;
}

std::uint64_t Permutation::forward(std::uint64_t i) const {
  do {
    i = scramble(i);
  } while (i >= size_);
  return i;
}

std::uint64_t Permutation::inverse(std::uint64_t i) const {
  do {
    i = unscramble(i);
  } while (i >= size_);
  return i;
}

}  // namespace tetfusion
