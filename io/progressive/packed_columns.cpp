#include "io/progressive/packed_columns.h"

#include <libdeflate.h>

#include <cstring>
#include <memory>
#include <utility>

#include "base/error.h"
#include "io/vtk/decode.h"

namespace tetfusion {

namespace {

constexpr int kLevel = 6;

struct FreeDeflate {
  void operator()(libdeflate_compressor* c) const { libdeflate_free_compressor(c); }
};

}  // namespace

void ColumnPacker::put(std::span<const std::byte> rows, std::size_t stride) {
  const std::uint64_t bytes = rows.size();
  const std::size_t begin = raw_.size();
  raw_.resize(begin + sizeof bytes + bytes);
  std::byte* to = raw_.data() + begin;
  std::memcpy(to, &bytes, sizeof bytes);
  to += sizeof bytes;
  for (std::size_t b = 0; b < stride; ++b) {
    for (std::size_t i = b; i < rows.size(); i += stride) *to++ = rows[i];
  }
}

Vector<std::byte> deflated(std::span<const std::byte> bytes) {
  const std::unique_ptr<libdeflate_compressor, FreeDeflate> deflater(
      libdeflate_alloc_compressor(kLevel));
  if (!deflater) throw Error(ErrorCode::kMemory, "out of memory while compressing the output");
  Vector<std::byte> packed(libdeflate_zlib_compress_bound(deflater.get(), bytes.size()));
  packed.resize(libdeflate_zlib_compress(deflater.get(), bytes.data(), bytes.size(), packed.data(),
                                         packed.size()));
  return packed;
}

Vector<std::byte> inflated(std::span<const std::byte> bytes, std::uint64_t expected) {
  Vector<std::byte> out;
  if (expected > max_decompressed_bytes(Compressor::kZlib, bytes.size())) return out;
  out.resize(expected);
  DecodeScratch scratch;
  if (!decompress(Compressor::kZlib, bytes, out, &scratch)) out.clear();
  return out;
}

ColumnReader::ColumnReader(std::span<const std::byte> packed, std::uint64_t raw_bytes, Fail fail)
    : fail_(std::move(fail)) {
  raw_ = inflated(packed, raw_bytes);
  if (raw_.size() != raw_bytes) fail_("cannot be inflated");
  left_ = raw_;
}

std::span<const std::byte> ColumnReader::next(std::size_t stride) {
  std::uint64_t bytes = 0;
  if (left_.size() < sizeof bytes) fail_("lacks a column");
  std::memcpy(&bytes, left_.data(), sizeof bytes);
  left_ = left_.subspan(sizeof bytes);
  if (bytes > left_.size() || (stride == 0 ? bytes != 0 : bytes % stride != 0)) {
    fail_("has a column of the wrong length");
  }
  const std::span<const std::byte> planes = left_.first(bytes);
  left_ = left_.subspan(bytes);
  return planes;
}

void ColumnReader::join_planes(std::span<const std::byte> planes, std::size_t stride,
                               std::byte* rows) {
  const std::byte* from = planes.data();
  for (std::size_t b = 0; b < stride; ++b) {
    for (std::size_t i = b; i < planes.size(); i += stride) rows[i] = *from++;
  }
}

void ColumnReader::take(std::size_t stride, Vector<std::byte>* rows) {
  const std::span<const std::byte> planes = next(stride);
  rows->resize(planes.size());
  join_planes(planes, stride, rows->data());
}

void ColumnReader::end() const {
  if (!left_.empty()) fail_("is longer than what it says to hold");
}

}  // namespace tetfusion
