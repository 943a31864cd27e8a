// The file of one source's pieces, or of a generation's state: sections behind a table (FORMAT.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "io/store/piece_store.h"

namespace tetfusion {

inline constexpr std::uint32_t kStateSource = 0xffffffff;

struct Section {
  std::uint64_t offset = 0;  // in the file; a multiple of 4096
  std::uint64_t bytes = 0;
  std::uint64_t checksum = 0;
  std::uint32_t bucket = 0;
};

struct SectionTable {
  std::uint64_t generation = 0;  // checksum of its name
  std::uint32_t source = 0;
  std::uint64_t file_bytes = 0;
  std::uint64_t checksum = 0;  // of header and table
  std::vector<Section> sections;
};

std::uint64_t generation_id(std::string_view name);

// Where the pieces will lie, and their checksums. Throws std::logic_error if the buckets do not
// ascend or a piece is empty.
SectionTable plan_sections(std::uint64_t generation, std::uint32_t source,
                           std::span<const PieceRef> pieces);

// Makes `fd` hold just this file, whatever it held before. Returns 0 or errno.
int write_sections(int fd, const SectionTable& table, std::span<const PieceRef> pieces);

// Reads header and table. What it returns lies within the file and agrees with the checksum. Throws
// DamagedFile, or Error(kIo) when it cannot be read; `path` is what messages call the file.
SectionTable read_sections(int fd, const std::string& path);

// Throws DamagedFile if these are not the bytes that were written as this section.
void check_section(const std::string& path, const Section& section,
                   std::span<const std::byte> bytes);

// A file is missing, or is not what was written.
class DamagedFile : public Error {
 public:
  explicit DamagedFile(const std::string& message) : Error(ErrorCode::kIo, message) {}
};
[[noreturn]] void throw_damaged(const std::string& path, const std::string& what);

}  // namespace tetfusion
