#include "io/progressive/progressive_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "base/error.h"
#include "base/serialize.h"
#include "io/files/checksum.h"
#include "io/progressive/progressive_layout.h"
#include "io/vtk/decode.h"

namespace tetfusion {

using namespace progressive;

namespace {

std::uint64_t get_number(ByteReader* in) {
  std::uint64_t value = 0;
  in->get(&value);
  return value;
}

// `fail` throws.
template <class Fail>
ArrayInfo get_info(bool of_field, std::uint32_t version, ByteReader* in, const Fail& fail) {
  ArrayInfo info;
  in->get_all(&info.name);
  const std::uint64_t type = get_number(in);
  const auto last = static_cast<std::uint64_t>(of_field ? ValueType::kString : ValueType::kFloat64);
  if (type > last) fail("names a type that there is not");
  info.type = static_cast<ValueType>(type);
  const std::uint64_t components = get_number(in);
  if (components == 0 || components > (std::uint64_t{1} << 24)) {
    fail("has an array with a wrong number of components");
  }
  info.components = static_cast<std::uint32_t>(components);
  info.tuples = get_number(in);
  const std::uint64_t names = get_number(in);
  if (names != 0 && names != components) fail("has an array with a wrong number of components");
  for (std::uint64_t i = 0; i < names; ++i) in->get_all(&info.component_names.emplace_back());
  if (version != kVersionWithoutUnits) in->get_all(&info.units);
  return info;
}

template <class Fail>
AttributeSet get_set(std::uint32_t version, ByteReader* in, const Fail& fail) {
  AttributeSet set;
  const std::uint64_t arrays = get_number(in);
  for (std::uint64_t i = 0; i < arrays; ++i) {
    set.arrays.push_back(get_info(false, version, in, fail));
  }
  const std::uint64_t active = get_number(in);
  for (std::uint64_t i = 0; i < active; ++i) {
    std::string marker, name;
    in->get_all(&marker);
    in->get_all(&name);
    set.active[marker] = name;
  }
  return set;
}

template <class T>
std::span<const T> part_of(const Vector<T>& all, std::size_t begin, std::size_t count) {
  return std::span(all).subspan(begin, count);
}

// Corners that are named elsewhere.
std::size_t count_elsewhere(std::span<const std::array<CornerCode, 4>> corners) {
  std::size_t count = 0;
  for (const auto& codes : corners) {
    count += static_cast<std::size_t>(std::count(codes.begin(), codes.end(), kNoCode));
  }
  return count;
}

}  // namespace

std::size_t ProgressiveDescription::point_row_bytes() const {
  return 3 * size_of(point_type) + point_data.row_bytes();
}

std::size_t ProgressiveDescription::cell_row_bytes() const { return cell_data.row_bytes(); }

FusionRecord FusionBlock::next() {
  const std::size_t i = at_.record++;
  const auto take = [](const auto& all, std::size_t* at, std::size_t count) {
    return part_of(all, std::exchange(*at, *at + count), count);
  };
  const auto& [head, points, star, tets] = heads_[i];
  FusionRecord r;
  r.kept = kept_[i];
  r.error = errors_[i];
  r.gone = head & 0xFF;
  r.points = take(points_, &at_.point, points);
  r.rows = take(rows_, &at_.row, (points + (head >> 8)) * point_row_);
  r.star = take(star_, &at_.star, star);
  r.tet_rows = part_of(tet_rows_, at_.tet * cell_row_, tets * cell_row_);
  r.corners = part_of(corners_, at_.tet, tets);
  r.tets = take(tets_, &at_.tet, tets);
  r.elsewhere = take(elsewhere_, &at_.elsewhere, count_elsewhere(r.corners));
  return r;
}

bool FusionBlock::agrees(std::uint64_t fusions, std::size_t packed_bytes) const {
  if (heads_.size() != fusions || kept_.size() != fusions || errors_.size() != fusions ||
      chunks_.size() != fusions) {
    return false;
  }
  std::uint64_t rows = 0, points = 0, bits = 0, tets = 0;
  for (const auto& [head, own_points, own_star, own_tets] : heads_) {
    const std::uint32_t gone = head & 0xFF, own_row = head >> 8;
    if (own_row > 1 || gone < 1 || gone > kMaxGone || gone > own_points) return false;
    rows += std::uint64_t{own_points} + own_row;
    points += own_points;
    bits += std::uint64_t{own_star} * star_bits(gone);
    tets += own_tets;
  }
  return rows_.size() / point_row_ == rows && points_.size() == points &&
         packed_bytes == (bits + 7) / 8 && tets_.size() == tets && corners_.size() == tets &&
         tet_rows_.size() == tets * cell_row_ && elsewhere_.size() == count_elsewhere(corners_);
}

void FusionBlock::undo_differences() {
  std::size_t point = 0, tet = 0;
  for (std::size_t i = 0; i < size(); ++i) {
    const auto& [head, own_points, own_star, own_tets] = heads_[i];
    for (std::uint32_t k = 0; k < own_points; ++k) points_[point++] += kept_[i];
    TetId before = 0;
    for (std::uint32_t k = 0; k < own_tets; ++k) before = tets_[tet++] += before;
  }
}

bool FusionBlock::unpack_star(std::span<const std::uint8_t> packed) {
  std::size_t count = 0, bit = 0;
  for (const auto& head : heads_) count += head[2];
  star_.reserve(count);
  for (const auto& head : heads_) {
    const std::uint32_t gone = head[0] & 0xFF, width = star_bits(gone);
    for (std::uint32_t k = 0; k < head[2]; ++k) {
      std::uint32_t whose = 0;
      for (std::uint32_t b = 0; b < width; ++b, ++bit) {
        whose |= (packed[bit / 8] >> bit % 8 & 1U) << b;
      }
      if (whose > gone) return false;
      star_.push_back(static_cast<std::uint8_t>(whose));
    }
  }
  return true;
}

ProgressiveFile::ProgressiveFile(MappedFile file) : file_(std::move(file)) {}

ProgressiveFile ProgressiveFile::open(const std::string& path) {
  ProgressiveFile file(MappedFile::open(path));
  file.read_head();
  file.read_description();
  file.check_rows();
  file.check();
  return file;
}

void ProgressiveFile::fail(const std::string& what) const {
  file_.check();
  throw Error(ErrorCode::kBadInput, fmt::format("{}: {}: write it again with 'tetfusion simplify "
                                                "--progressive'",
                                                path(), what));
}

void ProgressiveFile::read_head() {
  Header header;
  const std::span<const std::byte> bytes = file_.bytes();
  if (bytes.size() < sizeof header || std::memcmp(bytes.data(), kMagic.data(), 8) != 0) {
    fail("this is no progressive file");
  }
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.byte_order != kByteOrder) fail("the file is of a machine with another byte order");
  if (header.version != kVersion && header.version != kVersionWithoutUnits) {
    fail(fmt::format("the file is of version {}, and this program reads {} and {}", header.version,
                     kVersionWithoutUnits, kVersion));
  }
  version_ = header.version;
  if (header.sum != header_sum(header)) fail("the head of the file is damaged");
  if (header.file_bytes != file_.size()) {
    fail(fmt::format("the file has {} bytes, where {} were written", file_.size(),
                     header.file_bytes));
  }
  counts_ = header.counts;
  read_table(header.table, header.sections, header.table_sum);
}

// Sections follow one another without gaps.
void ProgressiveFile::read_table(std::uint64_t offset, std::uint64_t sections, std::uint64_t sum) {
  const std::uint64_t size = file_.size();
  if (offset < sizeof(Header) || offset > size || (size - offset) / sizeof(TableRow) != sections ||
      (size - offset) % sizeof(TableRow) != 0) {
    fail("the table of the file does not end where the file does");
  }
  const std::span<const std::byte> table = file_.bytes().subspan(offset);
  if (checksum(table) != sum) fail("the table of the file is damaged");
  std::uint64_t end = sizeof(Header);
  std::uint64_t raw = 0;
  for (std::uint64_t i = 0; i < sections; ++i) {
    TableRow row;
    std::memcpy(row.data(), table.data() + i * sizeof row, sizeof row);
    const Section section{row[0], row[1], row[2], row[3], row[4], row[5]};
    if (section.offset != end || section.bytes > offset - end || section.kind >= kKinds) {
      fail(fmt::format("section {} of the file is not where it should be", i));
    }
    if (section.raw_bytes > max_decompressed_bytes(Compressor::kZlib, section.bytes)) {
      fail(fmt::format("section {} of the file is shorter than what it says to hold", i));
    }
    end += section.bytes;
    raw += section.raw_bytes;
    parts_[section.kind].push_back(section);
  }
  if (end != offset || parts_[kDescription].size() != 1) {
    fail("the table of the file does not name all of it");
  }
  raw_bytes_ = raw;
  // Each has its number in a section.
  const std::uint64_t most = raw / sizeof(VertexId);
  const bool fits = counts_.points <= std::min(most, kMaxPoints) &&
                    counts_.cells <= std::min(most, kMaxPoints) && counts_.tets <= counts_.cells &&
                    counts_.tets <= kMaxTets && counts_.base_tets <= counts_.tets &&
                    counts_.base_points <= counts_.points && counts_.fusions <= most;
  if (!fits) fail("the file is shorter than what it says to hold");
}

std::uint64_t ProgressiveFile::largest_block() const {
  std::uint64_t largest = 0;
  for (const Section& block : parts_[5]) largest = std::max(largest, block.raw_bytes);
  return largest;
}

std::span<const std::byte> ProgressiveFile::bytes_of(const Section& section) const {
  const std::span<const std::byte> bytes = file_.bytes().subspan(section.offset, section.bytes);
  if (checksum(bytes) != section.checksum) {
    fail(fmt::format("the section from byte {} on is damaged: it does not agree with its checksum",
                     section.offset));
  }
  return bytes;
}

ColumnReader ProgressiveFile::columns_of(const Section& section) const {
  return {bytes_of(section), section.raw_bytes, [this, at = section.offset](const std::string& w) {
            fail(fmt::format("the section from byte {} on {}", at, w));
          }};
}

void ProgressiveFile::read_description() {
  const Section& section = parts_[kDescription].front();
  ColumnReader columns = columns_of(section);
  Vector<std::byte> text;
  columns.take(1, &text);
  columns.end();
  const auto bad = [this](const char* what) { fail(fmt::format("the file {}", what)); };
  ByteReader in(text);
  try {
    const std::uint64_t type = get_number(&in);
    description_.point_type = static_cast<ValueType>(std::min<std::uint64_t>(type, 255));
    if (!is_float(description_.point_type)) bad("has coordinates of a wrong type");
    description_.point_data = get_set(version_, &in, bad);
    description_.cell_data = get_set(version_, &in, bad);
    const std::uint64_t fields = get_number(&in);
    for (std::uint64_t i = 0; i < fields; ++i) {
      DataArray& array = description_.field_data.emplace_back();
      array.info = get_info(true, version_, &in, bad);
      in.get_all(&array.bytes);
      const std::uint64_t values = array.bytes.size() / size_of(array.info.type);
      const bool is_text = array.info.type == ValueType::kString;
      const std::uint64_t held = is_text
                                     ? static_cast<std::uint64_t>(std::count(
                                           array.bytes.begin(), array.bytes.end(), std::byte{0}))
                                     : values;
      const bool ends = !is_text || array.bytes.empty() || array.bytes.back() == std::byte{0};
      if (held % array.info.components != 0 || held / array.info.components != array.info.tuples ||
          array.bytes.size() % size_of(array.info.type) != 0 || !ends) {
        bad("has an array of field data of the wrong length");
      }
    }
    const std::uint64_t errors = get_number(&in);
    if (errors > static_cast<std::uint64_t>(FusionErrors::kLargest)) {
      bad("tells of errors of a kind that there is not");
    }
    description_.errors = static_cast<FusionErrors>(errors);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kIo) throw;
    bad("does not say what it holds");
  }
}

// Each point and cell has its row in a section.
void ProgressiveFile::check_rows() const {
  const auto fits = [this](std::uint64_t rows, std::uint64_t bytes) {
    return bytes == 0 || rows <= raw_bytes_ / bytes;
  };
  if (!fits(counts_.points, description_.point_row_bytes()) ||
      !fits(counts_.cells, description_.cell_row_bytes())) {
    fail("the file is shorter than what it says to hold");
  }
}

PointRows ProgressiveFile::read_points(const Section& section) const {
  ColumnReader columns = columns_of(section);
  PointRows points;
  columns.take_all(&points.numbers);
  columns.take(description_.point_row_bytes(), &points.rows);
  columns.end();
  if (points.rows.size() / description_.point_row_bytes() != points.numbers.size()) {
    fail("points have not as many rows as numbers");
  }
  return points;
}

TetRows ProgressiveFile::tets(std::size_t part) const {
  ColumnReader columns = columns_of(parts_[kTets][part]);
  TetRows tets;
  columns.take_all(&tets.numbers);
  columns.take_all(&tets.corners);
  columns.take(description_.cell_row_bytes(), &tets.rows);
  columns.end();
  const std::size_t count = tets.numbers.size();
  if (tets.corners.size() != count || tets.rows.size() != count * description_.cell_row_bytes()) {
    fail("tetrahedra have not as many rows as numbers");
  }
  return tets;
}

LowerRows ProgressiveFile::lower(std::size_t part) const {
  ColumnReader columns = columns_of(parts_[kLower][part]);
  LowerRows lower;
  columns.take_all(&lower.numbers);
  columns.take_all(&lower.cells.types);
  columns.take_all(&lower.cells.offsets);
  columns.take_all(&lower.cells.connectivity);
  columns.take(description_.cell_row_bytes(), &lower.rows);
  columns.end();
  const std::size_t count = lower.numbers.size();
  const Vector<std::uint64_t>& ends = lower.cells.offsets;
  if (lower.cells.types.size() != count ||
      lower.rows.size() != count * description_.cell_row_bytes() || ends.size() != count + 1 ||
      ends.front() != 0 || ends.back() != lower.cells.connectivity.size() ||
      !std::is_sorted(ends.begin(), ends.end())) {
    fail("cells of lower dimension have not as many rows as numbers");
  }
  return lower;
}

Vector<TetId> ProgressiveFile::rewound(std::size_t part) const {
  ColumnReader columns = columns_of(parts_[kRewound][part]);
  Vector<TetId> numbers;
  columns.take_all(&numbers);
  columns.end();
  return numbers;
}

auto ProgressiveFile::facts() const -> BlockFacts {
  BlockFacts facts;
  for (const Section& section : parts_[kErrors]) {
    ColumnReader columns = columns_of(section);
    columns.take_all(&facts.errors);
    columns.take_all(&facts.rounds);
    columns.end();
  }
  if (facts.errors.size() != blocks() || facts.rounds.size() != blocks()) {
    fail("the file does not tell of all blocks of fusions");
  }
  return facts;
}

FusionBlock ProgressiveFile::block(std::size_t part) const {
  ColumnReader columns = columns_of(parts_[kFusions][part]);
  FusionBlock block;
  block.point_row_ = description_.point_row_bytes();
  block.cell_row_ = description_.cell_row_bytes();
  Vector<std::uint8_t> packed;
  columns.take_all(&block.kept_);
  columns.take_all(&block.errors_);
  columns.take_all(&block.chunks_);
  columns.take_all(&block.heads_);
  columns.take_all(&block.points_);
  columns.take(block.point_row_, &block.rows_);
  columns.take_all(&packed);
  columns.take_all(&block.tets_);
  columns.take_all(&block.corners_);
  columns.take_all(&block.elsewhere_);
  columns.take(block.cell_row_, &block.tet_rows_);
  columns.end();
  if (!block.agrees(fusions_of(part), packed.size()) || !block.unpack_star(packed)) {
    fail("a block of fusions has not as many rows as it says to hold");
  }
  block.undo_differences();
  return block;
}

}  // namespace tetfusion
