// The bytes of one array in the file, as they are or as base64 text, from any place on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "base/vector.h"
#include "io/files/mapped_file.h"

namespace tetfusion {

inline std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

enum class Coding : std::uint8_t { kRaw, kBase64, kAscii };

// Where an array's bytes lie in the file. In appended data `end` is the end of all arrays.
struct Payload {
  Coding coding = Coding::kRaw;
  bool appended = false;
  std::uint64_t begin = 0;
  std::uint64_t end = 0;
};

// Safe to use from several threads. Of base64 text with line breaks in it, it keeps 8 bytes for
// each 64 KiB, and nothing of anything else.
class ByteStream {
 public:
  ByteStream() = default;
  // Raw or base64; `file` outlives the stream, and `payload` lies within it. Walks over inline
  // base64 once, to find line breaks.
  ByteStream(const MappedFile& file, const Payload& payload);

  std::uint64_t max_bytes() const;

  // `count` bytes from `offset` on, which live as long as `scratch` is left alone; nullptr when the
  // stream is shorter or not base64.
  const std::byte* view(std::uint64_t offset, std::uint64_t count,
                        Vector<std::byte>* scratch) const;

  // Where in the file the bytes of this range are, for MappedFile::dont_need(): a little more,
  // where there are line breaks.
  struct FileRange {
    std::uint64_t offset = 0;
    std::uint64_t count = 0;
  };
  FileRange place(std::uint64_t offset, std::uint64_t count) const;

  // What follows `bytes` bytes from the start. Base64 goes on in the same group of four characters,
  // unless the bytes were encoded for themselves (`own_groups`).
  ByteStream after(std::uint64_t bytes, bool own_groups) const;
  bool padded_within(std::uint64_t bytes) const;  // base64 that ends within the first `bytes` bytes

 private:
  // Characters that are no blanks, from the first group on.
  std::uint64_t letters() const { return all_letters_ - first_letter_; }
  std::string_view read_letters(std::uint64_t first, std::uint64_t count, char* scratch) const;
  std::uint64_t place_of_letter(std::uint64_t letter) const;  // or a little before, in text_
  void find_blanks();

  const MappedFile* file_ = nullptr;
  std::span<const std::byte> text_;
  Coding coding_ = Coding::kRaw;
  std::uint64_t all_letters_ = 0;
  std::uint64_t first_letter_ = 0;
  std::uint64_t first_ = 0;  // bytes of the first group that belong to something else
  // Of each block of text, the letters before it; none when there are no blanks.
  std::shared_ptr<const Vector<std::uint64_t>> letters_before_;
};

}  // namespace tetfusion
