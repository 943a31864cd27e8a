#include "io/vtk/encode.h"

#include <isa-l/igzip_lib.h>
#include <lz4.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <exception>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/resources.h"

namespace tetfusion {

namespace {

constexpr std::string_view kAlphabet =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

// The two characters of each 12-bit number: half as many look-ups as one character a time.
constexpr std::array<std::array<char, 2>, 4096> make_pairs() {
  std::array<std::array<char, 2>, 4096> pairs{};
  for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i] = {kAlphabet[i >> 6], kAlphabet[i & 63]};
  return pairs;
}
constexpr auto kPairs = make_pairs();

void encode_triples(const std::uint8_t* in, std::int64_t triples, char* out) {
#pragma omp parallel for schedule(static) if (triples > 16384)
  for (std::int64_t i = 0; i < triples; ++i) {
    const std::uint8_t* p = in + 3 * i;
    const std::uint32_t bits = std::uint32_t{p[0]} << 16 | std::uint32_t{p[1]} << 8 | p[2];
    std::memcpy(out + 4 * i, kPairs[bits >> 12].data(), 2);
    std::memcpy(out + 4 * i + 2, kPairs[bits & 0xFFF].data(), 2);
  }
}

}  // namespace

void base64_encode(std::span<const std::byte> bytes, Vector<char>* out) {
  out->resize(base64_size(bytes.size()));
  const auto* in = reinterpret_cast<const std::uint8_t*>(bytes.data());
  const std::size_t triples = bytes.size() / 3;
  encode_triples(in, static_cast<std::int64_t>(triples), out->data());
  const std::size_t rest = bytes.size() % 3;
  if (rest == 0) return;
  const std::array<std::uint8_t, 3> last{in[3 * triples],
                                         rest == 2 ? in[3 * triples + 1] : std::uint8_t{0}, 0};
  char* tail = out->data() + 4 * triples;
  encode_triples(last.data(), 1, tail);
  tail[3] = '=';
  if (rest == 1) tail[2] = '=';
}

namespace {

constexpr std::uint64_t kValuesPerLine = 12;
constexpr std::size_t kValuesPerTextBlock = 8192;
// The longest shortest form is that of a double: -2.2250738585072014e-308; and a separator.
constexpr std::size_t kLongestValue = 25;

template <class T>
char* put_value(T value, char* out, char* end) {
  if constexpr (std::is_floating_point_v<T>) {
    // The sign of a NaN is not a number's; "-nan" would stop some readers.
    if (std::isnan(value)) value = std::abs(value);
    return std::to_chars(out, end, value).ptr;
  } else {
    return std::to_chars(out, end, static_cast<std::int64_t>(value)).ptr;
  }
}
template <>
char* put_value(std::uint64_t value, char* out, char* end) {
  return std::to_chars(out, end, value).ptr;
}

template <class T>
void encode_block(const std::byte* values, std::size_t count, std::uint64_t column,
                  std::uint64_t line, Vector<char>* out) {
  out->resize(count * kLongestValue);
  char* p = out->data();
  char* const end = p + out->size();
  for (std::size_t i = 0; i < count; ++i) {
    T value;
    std::memcpy(&value, values + i * sizeof(T), sizeof(T));
    p = put_value(value, p, end);
    if (++column == line) column = 0;
    *p++ = column == 0 ? '\n' : ' ';
  }
  out->resize(static_cast<std::size_t>(p - out->data()));
}

}  // namespace

void text_encode(ValueType type, std::span<const std::byte> values, TextPosition position,
                 Vector<char>* out) {
  const std::uint64_t components = std::max(position.components, 1u);
  const std::uint64_t line = std::max<std::uint64_t>(kValuesPerLine / components, 1) * components;
  const std::size_t width = size_of(type);
  const std::size_t count = values.size() / width;
  const auto blocks =
      static_cast<std::int64_t>((count + kValuesPerTextBlock - 1) / kValuesPerTextBlock);
  std::vector<Vector<char>> texts(static_cast<std::size_t>(blocks));
  // Reserved outside the parallel loop, where nothing may throw.
  for (auto& text : texts) text.reserve(std::min(count, kValuesPerTextBlock) * kLongestValue);
  visit_type(type, [&](auto zero) {
    using T = decltype(zero);
#pragma omp parallel for schedule(static)
    for (std::int64_t b = 0; b < blocks; ++b) {
      const auto first = static_cast<std::size_t>(b) * kValuesPerTextBlock;
      encode_block<T>(
          values.data() + first * sizeof(T), std::min(kValuesPerTextBlock, count - first),
          (position.first_value + first) % line, line, &texts[static_cast<std::size_t>(b)]);
    }
  });
  out->clear();
  for (const auto& text : texts) out->insert(out->end(), text.begin(), text.end());
}

namespace {

// Of ISA-L's 0 to 3. On real and generated meshes level 2 takes half the time of libdeflate's
// fastest and leaves at most 4 % more than VTK's writer does (bench/writing.py); level 1 is no
// faster on connectivity, which is most of a mesh, and level 3 takes twice as long for the same
// size.
constexpr std::uint32_t kZlibLevel = 2;
// As VTK's writer has it, for files of its size.
constexpr int kLz4Acceleration = 5;

// Each block is decompressed on its own: small enough for a core's cache. Of zlib blocks of 1 MiB
// came out at most 0.5 % smaller, of 32 KiB up to 3 % larger and slower to read. LZ4 has a better
// table for blocks up to this size, and they come out smaller than longer ones.
constexpr std::size_t kZlibBlock = std::size_t{256} << 10;
constexpr std::size_t kLz4Block = std::size_t{64} << 10;
constexpr std::size_t kZlibBatch = 48;
// LZ4 is fast enough for memory to matter: what one thread works on should stay in its cache.
// Several would wait too often for each other.
constexpr std::size_t kLz4BatchOfOne = 8;
constexpr std::size_t kLz4Batch = 64;

// What does not compress is stored, in runs of 64 KiB with five bytes each; six for zlib's frame.
constexpr std::size_t largest_zlib(std::size_t bytes) { return bytes + bytes / 1024 + 64; }

// How far beyond the end of what it compresses ISA-L looks: where bytes go on as they did before,
// its code for 64-bit ARM (seen in 2.30) compares them until a match has its full length, 258, and
// only then cuts it at the end.
#ifdef __aarch64__
constexpr std::size_t kReadBeyond = 258 + sizeof(std::uint64_t);
#else
constexpr std::size_t kReadBeyond = 0;
#endif

constexpr std::size_t kZlibLevelBytes = ISAL_DEF_LVL2_DEFAULT;
constexpr std::size_t kZlibWork =
    kZlibLevelBytes + (kReadBeyond == 0 ? 0 : kZlibBlock + kReadBeyond);

// Both return the compressed size, or 0 on failure. `work` holds kZlibWork bytes, of any value, or
// there was no memory for it; `readable` bytes are there behind the end of `in`.
std::size_t compress_zlib(std::span<const std::byte> in, std::size_t readable, std::uint8_t* work,
                          std::span<std::byte> out) {
  if (work == nullptr) return 0;
  if (readable < kReadBeyond) {
    std::uint8_t* copy = work + kZlibLevelBytes;
    std::memcpy(copy, in.data(), in.size());
    std::memset(copy + in.size(), 0, kReadBeyond);
    in = {reinterpret_cast<const std::byte*>(copy), in.size()};
  }
  isal_zstream stream{};  // isal_deflate_stateless_init() leaves hist_bits as they are
  isal_deflate_stateless_init(&stream);
  stream.level = kZlibLevel;
  stream.level_buf = work;
  stream.level_buf_size = kZlibLevelBytes;
  stream.gzip_flag = IGZIP_ZLIB;
  stream.end_of_stream = 1;
  // The library reads only, but its interface does not say so.
  stream.next_in = const_cast<std::uint8_t*>(reinterpret_cast<const std::uint8_t*>(in.data()));
  stream.avail_in = static_cast<std::uint32_t>(in.size());
  stream.next_out = reinterpret_cast<std::uint8_t*>(out.data());
  stream.avail_out = static_cast<std::uint32_t>(out.size());
  return isal_deflate_stateless(&stream) == COMP_OK ? stream.total_out : 0;
}

std::size_t compress_lz4(std::span<const std::byte> in, std::span<std::byte> out) {
  const int n = LZ4_compress_fast(reinterpret_cast<const char*>(in.data()),
                                  reinterpret_cast<char*>(out.data()), static_cast<int>(in.size()),
                                  static_cast<int>(out.size()), kLz4Acceleration);
  return static_cast<std::size_t>(std::max(n, 0));
}

}  // namespace

BlockCompressor::BlockCompressor(Compression compression)
    : compression_(compression),
      block_bytes_(compression == Compression::kZlib ? kZlibBlock : kLz4Block),
      batch_blocks_(compression == Compression::kZlib ? kZlibBatch
                    : thread_count() > 1              ? kLz4Batch
                                                      : kLz4BatchOfOne),
      bound_(compression == Compression::kZlib
                 ? largest_zlib(block_bytes_)
                 : static_cast<std::size_t>(LZ4_compressBound(static_cast<int>(block_bytes_)))) {}

void BlockCompressor::compress(std::span<const std::byte> bytes, const Sink& sink) {
  while (!bytes.empty()) {
    const auto batch = bytes.first(std::min(bytes.size(), batch_bytes()));
    compress_batch(batch, sink);
    bytes = bytes.subspan(batch.size());
  }
}

// A thread that has a block ready hands on what is ready of the next ones, too: so none waits for
// the block before its own, and writing goes on beside compressing.
void BlockCompressor::compress_batch(std::span<const std::byte> bytes, const Sink& sink) {
  const std::size_t blocks = (bytes.size() + block_bytes_ - 1) / block_bytes_;
  results_.resize(blocks * bound_);
  std::vector<std::optional<std::size_t>> sizes(blocks);
  std::mutex mutex;
  std::size_t next = 0;
  std::exception_ptr error;
  const auto hand_on = [&](std::size_t block, std::size_t size) {
    const std::lock_guard lock(mutex);
    sizes[block] = size;
    for (; next < blocks && sizes[next] && !error; ++next) {
      try {  // nothing may leave the parallel region
        if (*sizes[next] == 0) {
          throw Error(ErrorCode::kMemory, "out of memory while compressing the output");
        }
        sink({results_.data() + next * bound_, *sizes[next]});
      } catch (...) {
        error = std::current_exception();
      }
    }
  };
#pragma omp parallel if (blocks > 1)
  {
    const bool zlib = compression_ == Compression::kZlib;
    const std::unique_ptr<std::uint8_t[]> work(zlib ? new (std::nothrow) std::uint8_t[kZlibWork]
                                                    : nullptr);
#pragma omp for schedule(dynamic)
    for (std::size_t b = 0; b < blocks; ++b) {
      const auto rest = bytes.subspan(b * block_bytes_);
      const auto in = rest.first(std::min(block_bytes_, rest.size()));
      const std::span<std::byte> out(results_.data() + b * bound_, bound_);
      hand_on(b, zlib ? compress_zlib(in, rest.size() - in.size(), work.get(), out)
                      : compress_lz4(in, out));
    }
  }
  if (error) std::rethrow_exception(error);
}

}  // namespace tetfusion
