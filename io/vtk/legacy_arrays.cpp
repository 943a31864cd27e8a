#include "io/vtk/legacy_arrays.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace tetfusion {

namespace {

constexpr std::uint64_t kValuesPerChunk = 65536;

Vector<std::uint64_t> even_chunks(std::uint64_t values) {
  Vector<std::uint64_t> begins(block_count(values, kValuesPerChunk) + 1);
  for (std::size_t c = 0; c < begins.size(); ++c) begins[c] = std::min(c * kValuesPerChunk, values);
  return begins;
}

class Bits final : public ComputedArray {
 public:
  Bits(const MappedFile& file, std::uint64_t begin, std::uint64_t bits)
      : file_(file), begin_(begin), bits_(bits) {}

  Vector<std::uint64_t> chunk_begins() const override { return even_chunks(bits_); }

  void compute(std::size_t chunk, std::byte* out) const override {
    const std::uint64_t first = chunk * kValuesPerChunk;
    const std::uint64_t last = std::min(first + kValuesPerChunk, bits_);
    const std::byte* const from = file_.bytes().data() + begin_;
    for (std::uint64_t bit = first; bit < last; ++bit) {
      *out++ = from[bit / 8] >> (7 - bit % 8) & std::byte{1};
    }
    file_.dont_need_around(begin_ + first / 8, kValuesPerChunk / 8);
  }

 private:
  const MappedFile& file_;
  std::uint64_t begin_;
  std::uint64_t bits_;
};

class Colours final : public ComputedArray {
 public:
  explicit Colours(ArrayReader shares) : shares_(std::move(shares)) {}

  Vector<std::uint64_t> chunk_begins() const override { return even_chunks(shares_.values()); }

  void compute(std::size_t chunk, std::byte* out) const override {
    const std::uint64_t first = chunk * kValuesPerChunk;
    Vector<float> values(std::min(kValuesPerChunk, shares_.values() - first));
    shares_.read(first, values.size(), reinterpret_cast<std::byte*>(values.data()));
    for (const float share : values) {
      // What is no number is black.
      const double value = share > 0 ? std::min(255.0 * share + 0.5, 255.0) : 0;
      *out++ = static_cast<std::byte>(value);
    }
  }

 private:
  ArrayReader shares_;
};

class KeptBytes final : public ComputedArray {
 public:
  explicit KeptBytes(Vector<std::byte> bytes) : bytes_(std::move(bytes)) {}

  Vector<std::uint64_t> chunk_begins() const override { return {0, bytes_.size()}; }

  void compute(std::size_t, std::byte* out) const override {
    std::copy(bytes_.begin(), bytes_.end(), out);
  }

 private:
  Vector<std::byte> bytes_;
};

}  // namespace

std::shared_ptr<const ComputedArray> bits_of(const MappedFile& file, std::uint64_t begin,
                                             std::uint64_t bits) {
  return std::make_shared<Bits>(file, begin, bits);
}

std::shared_ptr<const ComputedArray> colours_of(ArrayReader shares) {
  return std::make_shared<Colours>(std::move(shares));
}

std::shared_ptr<const ComputedArray> kept_bytes(Vector<std::byte> bytes) {
  return std::make_shared<KeptBytes>(std::move(bytes));
}

}  // namespace tetfusion
