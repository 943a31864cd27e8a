#include "io/vtk/array_reader.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <utility>

#include "base/error.h"
#include "base/numbers.h"
#include "base/resources.h"
#include "io/files/checksum.h"

namespace tetfusion {

namespace {

// Of an array that is not compressed: small enough for a core's cache, a multiple of every value
// size.
constexpr std::uint64_t kChunkBytes = std::uint64_t{256} << 10;

// A file may have a million of these: they are not worth system calls.
constexpr std::uint64_t kSmallArray = std::uint64_t{64} << 10;

}  // namespace

std::uint64_t max_values(const Payload& payload, const BinaryLayout& layout, ValueType type) {
  const std::uint64_t length = payload.end - payload.begin;
  if (payload.coding == Coding::kAscii) return length;
  const std::uint64_t bytes = payload.coding == Coding::kRaw ? length : length / 4 * 3;
  return max_decompressed_bytes(layout.compressor, bytes) / size_of(type);
}

// ---- Opening: headers ----

ArrayReader::ArrayReader(ArraySource source)
    : source_(std::move(source)), value_bytes_(size_of(source_.type)) {
  if (source_.computed) {
    open_computed();
    return;
  }
  const Payload& payload = source_.payload;
  if (payload.begin > payload.end || payload.end > source_.file->size()) {
    fail("the array lies outside of the file");
  }
  // Some writers leave even the header of an empty array out.
  if (payload.begin == payload.end && source_.values == ArraySource::kUnknown) source_.values = 0;
  if (source_.values == 0) return;
  if (payload.coding == Coding::kAscii) {
    open_ascii();
    return;
  }
  const ByteStream stream(*source_.file, payload);
  if (source_.layout.compressor == Compressor::kNone) {
    open_plain(stream);
  } else {
    open_compressed(stream);
  }
}

// `bytes` is what the array's own header says.
void ArrayReader::expect_bytes(std::uint64_t bytes) {
  if (bytes % value_bytes_ != 0) {
    fail("its header says " + std::to_string(bytes) + " bytes, which is not a whole number of " +
         std::string(vtk_name(source_.type)) + " values");
  }
  const std::uint64_t values = bytes / value_bytes_;
  if (source_.values != ArraySource::kUnknown && source_.values != values) {
    fail("expected " + format_count(source_.values, "value") + " of type " +
         std::string(vtk_name(source_.type)) + ", its header says " + std::to_string(bytes) +
         " bytes" + " (byte " + std::to_string(source_.payload.begin) + ")");
  }
  source_.values = values;
}

void ArrayReader::open_plain(const ByteStream& stream) {
  const std::size_t header_bytes = source_.layout.header_bytes;
  std::uint64_t bytes = 0;
  if (header_bytes == 0) {
    bytes = values() * value_bytes_;
    data_ = stream;
  } else {
    Vector<std::byte> scratch;
    const std::byte* header = stream.view(0, header_bytes, &scratch);
    if (header == nullptr) fail("the file ends in its header, or it is not base64");
    bytes = load_unsigned(header, header_bytes, source_.layout.swap);
    expect_bytes(bytes);
    data_ = stream.after(header_bytes, stream.padded_within(header_bytes));
  }
  if (bytes > data_.max_bytes()) {
    fail("it is said to have " + std::to_string(bytes) + " bytes, but only " +
         std::to_string(data_.max_bytes()) + " are left: the file is cut off or damaged");
  }
  chunks_ = block_count(bytes, kChunkBytes);
}

void ArrayReader::open_compressed(const ByteStream& stream) {
  const std::size_t word = source_.layout.header_bytes;
  const bool swap = source_.layout.swap;
  const std::string cut_off = "the file ends in its header, or it is not base64";
  Vector<std::byte> scratch;
  const std::byte* header = stream.view(0, 3 * word, &scratch);
  if (header == nullptr) fail(cut_off);
  const std::uint64_t blocks = load_unsigned(header, word, swap);
  block_bytes_ = load_unsigned(header + word, word, swap);
  const std::uint64_t partial = load_unsigned(header + 2 * word, word, swap);
  if (blocks > stream.max_bytes() / word) {
    fail("its header says " + std::to_string(blocks) +
         " compressed blocks, more than the file holds");
  }
  const std::uint64_t full_blocks = blocks > 0 && partial > 0 ? blocks - 1 : blocks;
  std::uint64_t bytes = 0;
  if (__builtin_mul_overflow(full_blocks, block_bytes_, &bytes) ||
      (blocks > 0 && __builtin_add_overflow(bytes, partial, &bytes)) || partial > block_bytes_) {
    fail("the block sizes in its header make no sense");
  }
  expect_bytes(bytes);
  if (bytes == 0) return;
  const std::uint64_t header_bytes = (3 + blocks) * word;
  header = stream.view(0, header_bytes, &scratch);
  if (header == nullptr) fail(cut_off);
  data_ = stream.after(header_bytes, true);
  block_begin_.resize(blocks + 1);
  read_block_table(header + 3 * word, full_blocks, partial);
  if (bytes >= kSmallArray) {
    const auto [offset, count] = stream.place(0, header_bytes);
    source_.file->dont_need_around(offset, count);
  }
  // Where values span blocks, a chunk is as many blocks as make whole values.
  blocks_per_chunk_ = std::min<std::uint64_t>(
      value_bytes_ / std::gcd<std::uint64_t>(block_bytes_, value_bytes_), blocks);
  chunks_ = block_count(blocks, blocks_per_chunk_);
}

void ArrayReader::read_block_table(const std::byte* sizes, std::uint64_t full_blocks,
                                   std::uint64_t partial) {
  const std::size_t word = source_.layout.header_bytes;
  const std::uint64_t blocks = block_begin_.size() - 1;
  const std::uint64_t limit = data_.max_bytes();
  block_begin_[0] = 0;
  for (std::uint64_t b = 0; b < blocks; ++b) {
    const std::uint64_t size = load_unsigned(sizes + b * word, word, source_.layout.swap);
    if (size > limit - block_begin_[b]) {
      fail("compressed block " + std::to_string(b) + " of " + std::to_string(blocks) +
           " goes past the end of the data: the file is cut off or damaged");
    }
    const std::uint64_t full = b < full_blocks ? block_bytes_ : partial;
    if (full > max_decompressed_bytes(source_.layout.compressor, size)) {
      fail("compressed block " + std::to_string(b) + " cannot hold the " + std::to_string(full) +
           " bytes that its header says");
    }
    block_begin_[b + 1] = block_begin_[b] + size;
  }
}

void ArrayReader::open_ascii() {
  const std::uint64_t begin = source_.payload.begin;
  const std::string_view text = as_text(bytes(begin, source_.payload.end));
  text_begin_.push_back(begin);
  for (std::size_t at = 0; at < text.size();) {
    at = std::min<std::size_t>(at + kChunkBytes, text.size());
    while (at < text.size() && static_cast<unsigned char>(text[at]) > ' ') ++at;
    text_begin_.push_back(begin + at);
    if (at < text.size()) source_.file->dont_need_around(begin + at, 1);
  }
  chunks_ = text_begin_.size() - 1;
  first_word_.resize(chunks_ + 1);
  const bool small = text.size() < kSmallArray;
  for_each_block(chunks_, 1, [&](std::size_t c, std::size_t, std::size_t) {
    first_word_[c + 1] = count_words(as_text(bytes(text_begin_[c], text_begin_[c + 1])));
    if (!small) source_.file->dont_need(text_begin_[c], text_begin_[c + 1] - text_begin_[c]);
  });
  if (!small) source_.file->dont_need_around(begin, text.size());
  first_word_[0] = 0;
  for (std::size_t c = 0; c < chunks_; ++c) first_word_[c + 1] += first_word_[c];
  const std::uint64_t words = first_word_[chunks_];
  if (source_.values != ArraySource::kUnknown && source_.values != words) {
    fail("expected " + format_count(source_.values, "value") + ", found " + format_count(words));
  }
  source_.values = words;
}

void ArrayReader::open_computed() {
  first_word_ = source_.computed->chunk_begins();
  chunks_ = first_word_.size() - 1;
  source_.values = first_word_.back();
}

// ---- Reading ----

std::uint64_t ArrayReader::chunk_bytes() const {
  if (!is_compressed()) return kChunkBytes;
  return std::min(blocks_per_chunk_ * block_bytes_, values() * value_bytes_);
}

std::uint64_t ArrayReader::decoding_bytes() const {
  if (!is_compressed() || chunks_ == 0) return 0;
  std::uint64_t encoded = 0;
  for (std::size_t c = 0; c < chunks_; ++c) {
    encoded = std::max(encoded, place_of_chunks(c, c + 1).count);
  }
  if (source_.payload.coding == Coding::kBase64) encoded += encoded / 4 * 3;
  const auto at_once = std::min<std::uint64_t>(chunks_, static_cast<unsigned>(thread_count()));
  return at_once * (chunk_bytes() + encoded);
}

std::size_t ArrayReader::chunk_of(std::uint64_t value) const {
  if (!first_word_.empty()) {
    // The last one that begins there: those without words have none of its values.
    const auto next = std::upper_bound(first_word_.begin(), first_word_.end(), value);
    return static_cast<std::size_t>(next - first_word_.begin()) - 1;
  }
  const bool compressed = source_.layout.compressor != Compressor::kNone;
  return value * value_bytes_ / (compressed ? blocks_per_chunk_ * block_bytes_ : kChunkBytes);
}

Chunk ArrayReader::chunk(std::size_t index, std::uint64_t first, std::uint64_t last,
                         DecodeScratch* scratch) const {
  if (first_word_.empty() && source_.layout.compressor == Compressor::kNone) {
    const std::uint64_t begin = index * (kChunkBytes / value_bytes_);
    const std::uint64_t end = begin + kChunkBytes / value_bytes_;
    return plain_chunk(std::max(begin, first), std::min(end, last), scratch);
  }
  Chunk all = source_.computed      ? computed_chunk(index, scratch)
              : first_word_.empty() ? compressed_chunk(index, scratch)
                                    : ascii_chunk(index, scratch);
  const std::uint64_t begin = std::max(all.first, first);
  all.data += (begin - all.first) * value_bytes_;
  all.count = std::max(begin, std::min(all.first + all.count, last)) - begin;
  all.first = begin;
  return all;
}

Chunk ArrayReader::plain_chunk(std::uint64_t first, std::uint64_t last,
                               DecodeScratch* scratch) const {
  const std::uint64_t count = (last - first) * value_bytes_;
  const std::byte* data = data_.view(first * value_bytes_, count, &scratch->encoded);
  if (data == nullptr) fail("its data is not base64, or ends too early");
  if (source_.payload.coding == Coding::kRaw) {
    // One call for the whole chunk costs less than a page fault for every few pages.
    source_.file->populate(static_cast<std::uint64_t>(data - source_.file->bytes().data()), count);
  }
  if (source_.layout.swap && value_bytes_ > 1) {
    scratch->values.assign(data, data + count);
    swap_bytes(scratch->values, value_bytes_);
    data = scratch->values.data();
  }
  return {first, last - first, data};
}

Chunk ArrayReader::compressed_chunk(std::size_t index, DecodeScratch* scratch) const {
  const std::size_t blocks = block_begin_.size() - 1;
  const std::size_t first_block = index * blocks_per_chunk_;
  const std::size_t last_block = std::min(first_block + blocks_per_chunk_, blocks);
  const std::uint64_t begin = first_block * block_bytes_;
  const std::uint64_t end = std::min(last_block * block_bytes_, values() * value_bytes_);
  scratch->values.resize(end - begin);
  const std::span<std::byte> out(scratch->values);
  for (std::size_t b = first_block; b < last_block; ++b) {
    const std::uint64_t size = block_begin_[b + 1] - block_begin_[b];
    const std::byte* block = data_.view(block_begin_[b], size, &scratch->encoded);
    const std::uint64_t at = b * block_bytes_ - begin;
    const std::uint64_t full = std::min<std::uint64_t>(block_bytes_, out.size() - at);
    if (block == nullptr ||
        !decompress(source_.layout.compressor, {block, size}, out.subspan(at, full), scratch)) {
      fail("compressed block " + std::to_string(b) + " of " + std::to_string(blocks) +
           " is damaged");
    }
  }
  if (source_.layout.swap) swap_bytes(out, value_bytes_);
  return {begin / value_bytes_, out.size() / value_bytes_, out.data()};
}

Chunk ArrayReader::ascii_chunk(std::size_t index, DecodeScratch* scratch) const {
  const std::uint64_t count = first_word_[index + 1] - first_word_[index];
  scratch->values.resize(count * value_bytes_);
  const std::string_view text = as_text(bytes(text_begin_[index], text_begin_[index + 1]));
  const std::string_view bad = parse_words(text, source_.type, scratch->values.data());
  if (!bad.empty()) {
    constexpr std::size_t kShown = 40;
    const std::string_view file = as_text(source_.file->bytes());
    fail("\"" + std::string(bad.substr(0, kShown)) + "\" is not a number of type " +
         std::string(vtk_name(source_.type)) + " (byte " +
         std::to_string(bad.data() - file.data()) + ")");
  }
  return {first_word_[index], count, scratch->values.data()};
}

Chunk ArrayReader::computed_chunk(std::size_t index, DecodeScratch* scratch) const {
  const std::uint64_t count = first_word_[index + 1] - first_word_[index];
  scratch->values.resize(count * value_bytes_);
  source_.computed->compute(index, scratch->values.data());
  return {first_word_[index], count, scratch->values.data()};
}

void ArrayReader::release_chunks(std::size_t begin, std::size_t end, bool around) const {
  if (source_.computed || values() * value_bytes_ < kSmallArray) return;
  const auto [offset, count] = place_of_chunks(begin, end);
  if (around) {
    source_.file->dont_need_around(offset, count);
  } else {
    source_.file->dont_need(offset, count);
  }
}

ByteStream::FileRange ArrayReader::place_of_chunks(std::size_t begin, std::size_t end) const {
  if (source_.payload.coding == Coding::kAscii) {
    return {text_begin_[begin], text_begin_[end] - text_begin_[begin]};
  }
  if (source_.layout.compressor == Compressor::kNone) {
    const std::uint64_t first = begin * kChunkBytes;
    return data_.place(first, std::min(end * kChunkBytes, values() * value_bytes_) - first);
  }
  const std::size_t blocks = block_begin_.size() - 1;
  const std::uint64_t first = block_begin_[begin * blocks_per_chunk_];
  return data_.place(first, block_begin_[std::min(end * blocks_per_chunk_, blocks)] - first);
}

void ArrayReader::read(std::uint64_t first, std::uint64_t count, std::byte* out) const {
  for_each_chunk(first, count, [&](const Chunk& c) {
    std::memcpy(out + (c.first - first) * value_bytes_, c.data, c.count * value_bytes_);
  });
}

std::uint64_t ArrayReader::checksum_in_file(std::uint64_t seed,
                                            const std::function<void()>& check) const {
  const Payload& payload = source_.payload;
  const BinaryLayout& layout = source_.layout;
  const std::array<std::uint64_t, 7> how = {static_cast<std::uint64_t>(source_.type),
                                            static_cast<std::uint64_t>(payload.coding),
                                            static_cast<std::uint64_t>(payload.appended),
                                            static_cast<std::uint64_t>(layout.compressor),
                                            layout.header_bytes,
                                            layout.swap ? 1u : 0u,
                                            values()};
  std::uint64_t sum = checksum(std::as_bytes(std::span(how)), seed);
  if (chunks_ == 0) return sum;
  const auto [offset, count] = place_of_chunks(chunks_ - 1, chunks_);
  const std::uint64_t last = offset + count;
  constexpr std::uint64_t kPart = std::uint64_t{1} << 20;
  for (std::uint64_t begin = payload.begin; begin < last; begin += kPart) {
    check();
    const std::uint64_t end = std::min(begin + kPart, last);
    source_.file->populate(begin, end - begin);
    sum = checksum(bytes(begin, end), sum);
    source_.file->dont_need(begin, end - begin);
  }
  source_.file->dont_need_around(payload.begin, last - payload.begin);
  return sum;
}

std::string ArrayReader::message(const std::string& what) const {
  return source_.file->path() + ": " + source_.label + ": " + what;
}

void ArrayReader::fail(const std::string& what) const {
  throw Error(ErrorCode::kBadInput, message(what));
}

std::string ArrayReader::where(std::uint64_t value) const {
  if (source_.computed || source_.payload.coding != Coding::kRaw ||
      source_.layout.compressor != Compressor::kNone) {
    return "";
  }
  const std::uint64_t at =
      source_.payload.begin + source_.layout.header_bytes + value * value_bytes_;
  return " (byte " + std::to_string(at) + ")";
}

}  // namespace tetfusion
