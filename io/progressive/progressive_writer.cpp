#include <algorithm>
#include <utility>

#include "base/resources.h"
#include "base/serialize.h"
#include "base/tasks.h"
#include "io/files/checksum.h"
#include "io/progressive/progressive_file.h"
#include "io/progressive/progressive_layout.h"

namespace tetfusion {

using namespace progressive;

namespace {

// Rows a section, and records a block: some hundred kilobytes; and wide rows not much more.
constexpr std::size_t kRowsPerSection = std::size_t{1} << 16;
constexpr std::size_t kSectionBytes = std::size_t{4} << 20;
constexpr std::size_t kRecordsPerBlock = std::size_t{1} << 13;

void put_text(const std::string& text, ByteWriter* out) { out->put_all(text); }

// The lowest that has a place for what is in the file.
std::uint32_t version_for(const ProgressiveDescription& description) {
  const auto has_units = [](const ArrayInfo& info) { return !info.units.empty(); };
  const auto any = [&](const AttributeSet& set) {
    return std::any_of(set.arrays.begin(), set.arrays.end(), has_units);
  };
  const std::vector<DataArray>& fields = description.field_data;
  const bool units = any(description.point_data) || any(description.cell_data) ||
                     std::any_of(fields.begin(), fields.end(),
                                 [&](const DataArray& array) { return has_units(array.info); });
  return units ? kVersion : kVersionWithoutUnits;
}

void put_info(const ArrayInfo& info, std::uint32_t version, ByteWriter* out) {
  put_text(info.name, out);
  out->put(static_cast<std::uint64_t>(info.type));
  out->put(std::uint64_t{info.components});
  out->put(info.tuples);
  out->put(std::uint64_t{info.component_names.size()});
  for (const std::string& name : info.component_names) put_text(name, out);
  if (version != kVersionWithoutUnits) put_text(info.units, out);
}

void put_set(const AttributeSet& set, std::uint32_t version, ByteWriter* out) {
  out->put(std::uint64_t{set.arrays.size()});
  for (ArrayInfo info : set.arrays) {
    info.tuples = 0;
    put_info(info, version, out);
  }
  out->put(std::uint64_t{set.active.size()});
  for (const auto& [marker, name] : set.active) {
    put_text(marker, out);
    put_text(name, out);
  }
}

template <class T>
std::span<const T> part_of(const Vector<T>& all, std::size_t begin, std::size_t count) {
  return std::span(all).subspan(begin, count);
}

template <class Part, class T>
void join(const Part& part, Vector<T>* all) {
  all->insert(all->end(), part.begin(), part.end());
}

std::size_t rows_in_section(std::size_t row_bytes) {
  const std::size_t rows = kSectionBytes / std::max<std::size_t>(row_bytes, 1);
  return std::clamp<std::size_t>(rows, 1, kRowsPerSection);
}

// How many of so many rows the section has room for.
template <class T>
std::size_t room_for(std::size_t rows, const Vector<T>& section, std::size_t row_bytes) {
  return std::min(rows, rows_in_section(row_bytes) - section.size());
}

}  // namespace

ProgressiveWriter::ProgressiveWriter(OutputFile* file, const ProgressiveDescription& description)
    : file_(file),
      version_(version_for(description)),
      point_row_(description.point_row_bytes()),
      cell_row_(description.cell_row_bytes()) {
  const Header none;
  file_->append(&none, sizeof none);
  ByteWriter text;
  text.put(static_cast<std::uint64_t>(description.point_type));
  put_set(description.point_data, version_, &text);
  put_set(description.cell_data, version_, &text);
  text.put(std::uint64_t{description.field_data.size()});
  for (const DataArray& array : description.field_data) {
    put_info(array.info, version_, &text);
    text.put_all(array.bytes);
  }
  text.put(static_cast<std::uint64_t>(description.errors));
  ColumnPacker columns;
  columns.put(text.take(), 1);
  add(std::move(columns), kDescription, 0);
}

void ProgressiveWriter::put_rows(const PointRows& points, std::uint32_t kind) {
  if (kind != points_kind_) end_points();
  points_kind_ = kind;
  counts_.points += points.numbers.size();
  for (std::size_t i = 0; i < points.numbers.size();) {
    const std::size_t count = room_for(points.numbers.size() - i, points_.numbers, point_row_);
    join(part_of(points.numbers, i, count), &points_.numbers);
    join(part_of(points.rows, i * point_row_, count * point_row_), &points_.rows);
    i += count;
    if (points_.numbers.size() == rows_in_section(point_row_)) end_points();
  }
}

void ProgressiveWriter::end_points() {
  const std::size_t count = points_.numbers.size();
  if (count == 0) return;
  ColumnPacker columns;
  columns.put_all(points_.numbers);
  columns.put(points_.rows, point_row_);
  add(std::move(columns), points_kind_, count);
  points_ = {};
}

void ProgressiveWriter::put_points(const PointRows& points) {
  counts_.base_points += points.numbers.size();
  put_rows(points, kPoints);
}

void ProgressiveWriter::put_spare(const PointRows& points) {
  end_tets();
  put_rows(points, kSpare);
}

void ProgressiveWriter::put_tets(const TetRows& tets) {
  end_points();
  counts_.base_tets += tets.numbers.size();
  counts_.tets += tets.numbers.size();
  counts_.cells += tets.numbers.size();
  for (std::size_t i = 0; i < tets.numbers.size();) {
    const std::size_t count = room_for(tets.numbers.size() - i, tets_.numbers, cell_row_);
    join(part_of(tets.numbers, i, count), &tets_.numbers);
    join(part_of(tets.corners, i, count), &tets_.corners);
    join(part_of(tets.rows, i * cell_row_, count * cell_row_), &tets_.rows);
    i += count;
    if (tets_.numbers.size() == rows_in_section(cell_row_)) end_tets();
  }
}

void ProgressiveWriter::end_tets() {
  const std::size_t count = tets_.numbers.size();
  if (count == 0) return;
  ColumnPacker columns;
  columns.put_all(tets_.numbers);
  columns.put_all(tets_.corners);
  columns.put(tets_.rows, cell_row_);
  add(std::move(columns), kTets, count);
  tets_ = {};
}

void ProgressiveWriter::put_lower(const LowerRows& lower) {
  const std::uint64_t count = lower.cells.size();
  if (count == 0) return;
  end_tets();
  counts_.cells += count;
  ColumnPacker columns;
  columns.put_all(lower.numbers);
  columns.put_all(lower.cells.types);
  columns.put_all(lower.cells.offsets);
  columns.put_all(lower.cells.connectivity);
  columns.put(lower.rows, cell_row_);
  add(std::move(columns), kLower, count);
}

void ProgressiveWriter::put_rewound(std::span<const TetId> numbers) {
  end_tets();
  end_points();
  while (!numbers.empty()) {
    const std::size_t count = room_for(numbers.size(), rewound_, 0);
    join(numbers.first(count), &rewound_);
    numbers = numbers.subspan(count);
    if (rewound_.size() == kRowsPerSection) end_rewound();
  }
}

void ProgressiveWriter::end_rewound() {
  if (rewound_.empty()) return;
  ColumnPacker columns;
  columns.put_all(rewound_);
  add(std::move(columns), kRewound, rewound_.size());
  rewound_ = {};
}

void ProgressiveWriter::put(const FusionRecord& record, std::uint32_t round, std::uint32_t chunk) {
  if (round != round_) end_block();
  round_ = round;
  chunks_.push_back(chunk);
  if (block_.size() == 0) {
    end_tets();
    end_points();
    end_rewound();
  }
  block_.append(record);
  counts_.points += record.points.size();
  counts_.cells += record.tets.size();
  counts_.tets += record.tets.size();
  ++counts_.fusions;
  if (block_.size() == kRecordsPerBlock || block_.row_bytes() >= kSectionBytes) end_block();
}

void ProgressiveWriter::end_block() {
  if (block_.size() == 0) return;
  Vector<VertexId> kept, points, elsewhere;
  Vector<float> errors;
  Vector<std::array<std::uint32_t, 4>> heads;
  Vector<std::byte> rows, tet_rows;
  Vector<std::uint8_t> star;
  Vector<TetId> tets;
  Vector<std::array<CornerCode, 4>> corners;
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < block_.size(); ++i) {
    const FusionRecord r = block_[i];
    kept.push_back(r.kept);
    errors.push_back(r.error);
    const std::uint32_t changed = r.row_changed(point_row_) ? 1 : 0;
    const auto count = [](const auto& part) { return static_cast<std::uint32_t>(part.size()); };
    heads.push_back({r.gone | changed << 8, count(r.points), count(r.star), count(r.tets)});
    for (const VertexId v : r.points) points.push_back(v - r.kept);
    join(r.rows, &rows);
    const std::uint32_t width = star_bits(r.gone);
    for (const std::uint8_t whose : r.star) {
      for (std::uint32_t b = 0; b < width; ++b, ++bits) {
        if (bits % 8 == 0) star.push_back(0);
        star.back() = static_cast<std::uint8_t>(star.back() | (whose >> b & 1) << bits % 8);
      }
    }
    TetId before = 0;
    for (const TetId t : r.tets) tets.push_back(t - std::exchange(before, t));
    join(r.corners, &corners);
    join(r.elsewhere, &elsewhere);
    join(r.tet_rows, &tet_rows);
  }
  ColumnPacker columns;
  columns.put_all(kept);
  columns.put_all(errors);
  columns.put_all(chunks_);
  columns.put_all(heads);
  columns.put_all(points);
  columns.put(rows, point_row_);
  columns.put_all(star);
  columns.put_all(tets);
  columns.put_all(corners);
  columns.put_all(elsewhere);
  columns.put(tet_rows, cell_row_);
  add(std::move(columns), kFusions, block_.size());
  block_ = {};
  chunks_.clear();
  rounds_.push_back(round_);
  errors_.push_back(*std::max_element(errors.begin(), errors.end()));
}

void ProgressiveWriter::add(ColumnPacker columns, std::uint32_t kind, std::uint64_t rows) {
  waiting_.push_back({std::move(columns), kind, rows});
  if (waiting_.size() >= 2 * static_cast<std::size_t>(thread_count())) write_waiting();
}

// Packed side by side.
void ProgressiveWriter::write_waiting() {
  std::vector<Vector<std::byte>> packed(waiting_.size());
  run_tasks(waiting_.size(), thread_count(),
            [&](std::size_t i, std::size_t) { packed[i] = waiting_[i].columns.pack(); });
  for (std::size_t i = 0; i < packed.size(); ++i) {
    const Waiting& w = waiting_[i];
    table_.push_back({file_->size(), packed[i].size(), w.columns.raw_bytes(), checksum(packed[i]),
                      w.kind, w.rows});
    file_->append(packed[i].data(), packed[i].size());
  }
  waiting_.clear();
}

void ProgressiveWriter::finish() {
  end_tets();
  end_points();
  end_rewound();
  end_block();
  if (!errors_.empty()) {
    ColumnPacker columns;
    columns.put_all(errors_);
    columns.put_all(rounds_);
    add(std::move(columns), kErrors, errors_.size());
  }
  write_waiting();
  const std::span<const std::byte> table = std::as_bytes(std::span(table_));
  Header header;
  header.version = version_;
  header.table = file_->size();
  header.sections = table_.size();
  header.table_sum = checksum(table);
  header.counts = counts_;
  header.point_row = static_cast<std::uint32_t>(point_row_);
  header.cell_row = static_cast<std::uint32_t>(cell_row_);
  file_->append(table.data(), table.size());
  header.file_bytes = file_->size();
  header.sum = header_sum(header);
  file_->overwrite(0, &header, sizeof header);
}

}  // namespace tetfusion
