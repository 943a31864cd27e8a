#include "io/store/section_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>
#include <type_traits>

#include "io/files/checksum.h"
#include "io/files/file_system.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kSectionAlignment = 4096;
constexpr std::uint32_t kByteOrder = 0x01020304;
constexpr std::uint32_t kVersion = 1;
constexpr std::array<char, 8> kMagic = {'T', 'F', 'P', 'I', 'E', 'C', 'E', 'S'};
constexpr std::array<std::byte, kSectionAlignment> kZeros{};

struct FileHeader {
  std::array<char, 8> magic = kMagic;
  std::uint32_t byte_order = kByteOrder;
  std::uint32_t version = kVersion;
  std::uint64_t file_bytes = 0;
  std::uint64_t generation = 0;
  std::uint32_t source = 0;
  std::uint32_t sections = 0;
  std::array<std::uint64_t, 3> zero{};
};
static_assert(sizeof(FileHeader) == 64 && std::has_unique_object_representations_v<FileHeader>);

struct FileSection {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
  std::uint64_t checksum = 0;
  std::uint32_t bucket = 0;
  std::uint32_t zero = 0;
};
static_assert(sizeof(FileSection) == 32 && std::has_unique_object_representations_v<FileSection>);

constexpr std::uint64_t round_up(std::uint64_t bytes) {
  return (bytes + kSectionAlignment - 1) / kSectionAlignment * kSectionAlignment;
}

// Header, table and their checksum.
constexpr std::uint64_t head_bytes(std::uint64_t sections) {
  return sizeof(FileHeader) + sections * sizeof(FileSection) + sizeof(std::uint64_t);
}

std::vector<std::byte> encode_head(const SectionTable& table) {
  std::vector<std::byte> head(head_bytes(table.sections.size()));
  FileHeader header;
  header.file_bytes = table.file_bytes;
  header.generation = table.generation;
  header.source = table.source;
  header.sections = static_cast<std::uint32_t>(table.sections.size());
  std::memcpy(head.data(), &header, sizeof(header));
  std::byte* at = head.data() + sizeof(header);
  for (const Section& section : table.sections) {
    const FileSection entry = {section.offset, section.bytes, section.checksum, section.bucket, 0};
    std::memcpy(at, &entry, sizeof(entry));
    at += sizeof(entry);
  }
  const std::uint64_t sum = checksum({head.data(), head.size() - sizeof(std::uint64_t)});
  std::memcpy(at, &sum, sizeof(sum));
  return head;
}

std::uint64_t file_size(int fd, const std::string& path) {
  struct stat status {};
  if (file_system().fstat(fd, &status) != 0) {
    throw Error(ErrorCode::kIo, fmt::format("{}: cannot look at it: {}", path, strerror(errno)));
  }
  return static_cast<std::uint64_t>(status.st_size);
}

void read_part(int fd, const std::string& path, std::uint64_t offset, void* data,
               std::size_t bytes) {
  const int error = pread_all(fd, data, bytes, offset);
  if (error == 0) return;
  if (error == kEndOfFile) {
    throw_damaged(path, fmt::format("ends before byte {}", offset + bytes));
  }
  throw Error(ErrorCode::kIo,
              fmt::format("{}: cannot read {} bytes at byte {}: {}; see whether its disk fails",
                          path, bytes, offset, std::strerror(error)));
}

FileHeader read_header(int fd, const std::string& path, std::uint64_t size) {
  FileHeader header;
  if (size < head_bytes(0)) {
    throw_damaged(path, fmt::format("has {} bytes, at least {} expected", size, head_bytes(0)));
  }
  read_part(fd, path, 0, &header, sizeof(header));
  if (header.magic != kMagic) throw_damaged(path, "does not begin with TFPIECES");
  if (header.byte_order != kByteOrder) {
    throw_damaged(path,
                  fmt::format("byte 8: byte order {:#010x}, {:#010x} expected (was it written "
                              "on another kind of machine?)",
                              header.byte_order, kByteOrder));
  }
  if (header.version != kVersion) {
    throw_damaged(path, fmt::format("byte 12: version {} of the format, {} expected",
                                    header.version, kVersion));
  }
  if (header.file_bytes != size) {
    throw_damaged(path, fmt::format("has {} bytes, {} expected", size, header.file_bytes));
  }
  if (header.sections > (size - head_bytes(0)) / sizeof(FileSection)) {
    throw_damaged(path, fmt::format("byte 36: a table of {} sections does not fit into {} bytes",
                                    header.sections, size));
  }
  return header;
}

}  // namespace

std::uint64_t generation_id(std::string_view name) {
  return checksum(std::as_bytes(std::span(name)));
}

SectionTable plan_sections(std::uint64_t generation, std::uint32_t source,
                           std::span<const PieceRef> pieces) {
  SectionTable table;
  table.generation = generation;
  table.source = source;
  table.sections.reserve(pieces.size());
  std::uint64_t end = head_bytes(pieces.size());
  for (const PieceRef& piece : pieces) {
    if (piece.bytes.empty()) throw std::logic_error("a piece has no bytes");
    if (!table.sections.empty() && piece.bucket <= table.sections.back().bucket) {
      throw std::logic_error("the buckets of a source's pieces do not ascend");
    }
    const std::uint64_t offset = round_up(end);
    table.sections.push_back({offset, piece.bytes.size(), checksum(piece.bytes), piece.bucket});
    end = offset + piece.bytes.size();
  }
  table.file_bytes = end;
  const std::vector<std::byte> head = encode_head(table);
  std::memcpy(&table.checksum, head.data() + head.size() - sizeof(table.checksum),
              sizeof(table.checksum));
  return table;
}

int write_sections(int fd, const SectionTable& table, std::span<const PieceRef> pieces) {
  FileSystem& system = file_system();
  const auto bytes = static_cast<off_t>(table.file_bytes);
  if (retry([&] { return system.ftruncate(fd, bytes); }) != 0) return errno;
  // A disk too small fails here, before the long write. Not every file system can set space aside.
  if (retry([&] { return system.fallocate(fd, 0, 0, bytes); }) != 0 && errno != EOPNOTSUPP &&
      errno != ENOSYS) {
    return errno;
  }
  std::vector<std::byte> head = encode_head(table);
  std::vector<struct iovec> parts;
  std::uint64_t end = 0;
  const auto append = [&](const void* data, std::size_t count) {
    parts.push_back({const_cast<void*>(data), count});
    end += count;
  };
  append(head.data(), head.size());
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    append(kZeros.data(), table.sections[i].offset - end);
    append(pieces[i].bytes.data(), pieces[i].bytes.size());
  }
  return pwritev_all(fd, parts, 0);
}

SectionTable read_sections(int fd, const std::string& path) {
  const std::uint64_t size = file_size(fd, path);
  const FileHeader header = read_header(fd, path, size);
  std::vector<std::byte> head(head_bytes(header.sections));
  read_part(fd, path, 0, head.data(), head.size());
  SectionTable table;
  std::memcpy(&table.checksum, head.data() + head.size() - sizeof(table.checksum),
              sizeof(table.checksum));
  const std::uint64_t sum = checksum({head.data(), head.size() - sizeof(std::uint64_t)});
  if (sum != table.checksum) {
    throw_damaged(path, fmt::format("bytes 0 to {}: the checksum of header and table is {:016x}, "
                                    "{:016x} expected",
                                    head.size() - 8, sum, table.checksum));
  }
  table.generation = header.generation;
  table.source = header.source;
  table.file_bytes = size;
  table.sections.reserve(header.sections);
  std::uint64_t end = head.size();
  for (std::uint32_t i = 0; i < header.sections; ++i) {
    const std::uint64_t at = sizeof(FileHeader) + i * sizeof(FileSection);
    FileSection entry;
    std::memcpy(&entry, head.data() + at, sizeof(entry));
    const bool ascends = i == 0 || entry.bucket > table.sections.back().bucket;
    if (entry.offset % kSectionAlignment != 0 || entry.offset < end || entry.offset > size ||
        entry.bytes == 0 || entry.bytes > size - entry.offset || !ascends) {
      throw_damaged(path,
                    fmt::format("byte {}: section {} (bucket {}) from byte {}, {} bytes long, "
                                "is out of order or does not lie in the file's {} bytes",
                                at, i, entry.bucket, entry.offset, entry.bytes, size));
    }
    table.sections.push_back({entry.offset, entry.bytes, entry.checksum, entry.bucket});
    end = entry.offset + entry.bytes;
  }
  return table;
}

void check_section(const std::string& path, const Section& section,
                   std::span<const std::byte> bytes) {
  const std::uint64_t sum = checksum(bytes);
  if (sum == section.checksum) return;
  throw_damaged(path,
                fmt::format("the section of bucket {}, {} bytes from byte {}: its checksum is "
                            "{:016x}, {:016x} expected",
                            section.bucket, section.bytes, section.offset, sum, section.checksum));
}

void throw_damaged(const std::string& path, const std::string& what) {
  throw DamagedFile(
      fmt::format("{}: {}; the file was changed, or its disk fails: remove the scratch folder and "
                  "start the run again",
                  path, what));
}

}  // namespace tetfusion
