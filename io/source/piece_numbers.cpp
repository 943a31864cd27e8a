#include "io/source/piece_numbers.h"

#include <algorithm>
#include <atomic>
#include <bit>

#include "base/blocks.h"
#include "io/source/merge_pieces.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kRange = std::uint64_t{1} << 16;  // points whose keys are read at once

struct NumberRecord {
  PointKey key;
  VertexId point;
};

std::uint64_t bucket_of(const PointKey& key, std::uint64_t buckets) {
  return buckets == 1 ? 0 : hash_of(key) % buckets;
}

}  // namespace

PointKey key_of_coordinates(double x, double y, double z) {
  const auto bits = [](double v) { return std::bit_cast<std::uint64_t>(v + 0.0); };
  return {bits(x), bits(y), bits(z)};
}

PieceNumbers::PieceNumbers(std::uint64_t points) : points_(points) {
  bits_.assign(block_count(points, 64), 0);
  ranks_.push_back(0);
}

void PieceNumbers::use(VertexId point) {
  std::atomic_ref word(bits_[point / 64]);
  const std::uint64_t bit = std::uint64_t{1} << (point % 64);
  // Most points are marked again and again.
  if ((word.load(std::memory_order_relaxed) & bit) == 0) {
    word.fetch_or(bit, std::memory_order_relaxed);
  }
}

void PieceNumbers::find_copies(std::span<const std::uint64_t> piece_begin, const ReadKeys& keys,
                               std::uint64_t memory, bool also_within) {
  const std::uint64_t passes = std::max<std::uint64_t>(
      1, block_count(points_ * sizeof(NumberRecord), std::max<std::uint64_t>(memory, 1)));
  for (std::uint64_t pass = 0; pass < passes; ++pass)
    match(piece_begin, keys, also_within, passes, pass);
  std::sort(copies_.begin(), copies_.end(),
            [](const PointCopy& a, const PointCopy& b) { return a.point < b.point; });
  // Only now: all passes have to see them.
  for (const PointCopy& copy : copies_)
    bits_[copy.point / 64] &= ~(std::uint64_t{1} << (copy.point % 64));
  rank();
}

void PieceNumbers::forget_copies() {
  for (const PointCopy& copy : copies_) {
    bits_[copy.point / 64] |= std::uint64_t{1} << (copy.point % 64);
  }
  copies_ = {};
}

// One pass: the points whose keys fall into one bucket of `passes`.
void PieceNumbers::match(std::span<const std::uint64_t> piece_begin, const ReadKeys& keys,
                         bool also_within, std::uint64_t passes, std::uint64_t pass) {
  Vector<NumberRecord> records;
  Vector<PointKey> range(kRange);
  for (std::size_t p = 0; p + 1 < piece_begin.size(); ++p) {
    for (std::uint64_t first = piece_begin[p]; first < piece_begin[p + 1]; first += kRange) {
      const std::uint64_t count = std::min(kRange, piece_begin[p + 1] - first);
      keys(first, count, range.data());
      for (std::uint64_t i = 0; i < count; ++i) {
        if (!stays(first + i) || bucket_of(range[i], passes) != pass) continue;
        records.push_back({range[i], static_cast<VertexId>(first + i)});
      }
    }
  }
  std::sort(records.begin(), records.end(), [](const NumberRecord& a, const NumberRecord& b) {
    return a.key != b.key ? a.key < b.key : a.point < b.point;
  });
  std::vector<VertexId> firsts;
  for (std::size_t begin = 0; begin < records.size();) {
    std::size_t end = begin + 1;
    while (end < records.size() && records[end].key == records[begin].key) ++end;
    match_run(std::span<const NumberRecord>(records).subspan(begin, end - begin), piece_begin,
              also_within, &firsts, [&](VertexId point, VertexId original) {
                if (point != original) copies_.push_back({point, original});
              });
    begin = end;
  }
}

void PieceNumbers::rank() {
  ranks_.clear();
  std::uint64_t sum = 0;
  for (std::size_t w = 0; w < bits_.size(); ++w) {
    if (w % kWords == 0) ranks_.push_back(sum);
    sum += static_cast<std::uint64_t>(std::popcount(bits_[w]));
  }
  ranks_.push_back(sum);
}

std::uint64_t PieceNumbers::bytes() const {
  return 8 * (bits_.size() + ranks_.size()) + sizeof(PointCopy) * copies_.size();
}

VertexId PieceNumbers::rank_of(VertexId point) const {
  const std::uint64_t last = point / 64;
  std::uint64_t rank = ranks_[last / kWords];
  for (std::uint64_t w = last / kWords * kWords; w < last; ++w) {
    rank += static_cast<std::uint64_t>(std::popcount(bits_[w]));
  }
  const std::uint64_t below = bits_[last] & ((std::uint64_t{1} << (point % 64)) - 1);
  return static_cast<VertexId>(rank + static_cast<std::uint64_t>(std::popcount(below)));
}

VertexId PieceNumbers::number(VertexId point) const {
  if (stays(point)) return rank_of(point);
  const auto copy = std::lower_bound(copies_.begin(), copies_.end(), point,
                                     [](const PointCopy& c, VertexId p) { return c.point < p; });
  return rank_of(copy->original);
}

std::uint64_t PieceNumbers::point_of(std::uint64_t number) const {
  if (number >= points()) return points_;
  const auto after = std::upper_bound(ranks_.begin(), ranks_.end() - 1, number);
  const auto block = static_cast<std::uint64_t>(after - ranks_.begin()) - 1;
  std::uint64_t left = number - ranks_[block];
  for (std::uint64_t w = block * kWords;; ++w) {
    std::uint64_t word = bits_[w];
    const auto ones = static_cast<std::uint64_t>(std::popcount(word));
    if (left >= ones) {
      left -= ones;
      continue;
    }
    for (; left > 0; --left) word &= word - 1;
    return 64 * w + static_cast<std::uint64_t>(std::countr_zero(word));
  }
}

}  // namespace tetfusion
