// The file, in its two forms:
//
//   <VTKFile ...><UnstructuredGrid>            head: the arrays are declared here; in the inline
//     <FieldData>  <DataArray .../> ...        encodings their values lie between the tags
//     <Piece ...>
//       <PointData> <CellData> <Points> <Cells>
//   </UnstructuredGrid>
//   <AppendedData encoding="raw"> _            appended encodings: all values, in the same order,
//     size, values                             uncompressed: a UInt64 with the bytes that follow
//     blocks, block size, last size, sizes...  compressed: UInt64s, then the blocks
//   </AppendedData></VTKFile>
//
// Where compression makes the offsets known late, the head holds blanks, patched afterwards.
#include "io/vtk/vtu_writer.h"

#include <fmt/format.h>

#include <stdexcept>
#include <string_view>
#include <utility>

#include "io/vtk/vtu_markup.h"

namespace tetfusion {

namespace {

// Values encoded at a time as text: a multiple of three for base64.
constexpr std::size_t kTextStage = std::size_t{12} << 20;
static_assert(kTextStage % 3 == 0);
// offset="..." with as many digits as a UInt64 may have.
constexpr std::size_t kOffsetWidth = 29;

constexpr std::string_view kTail = "\n  </AppendedData>\n</VTKFile>\n";

std::string offset_attribute(std::uint64_t offset) {
  return fmt::format("{:<{}}", fmt::format("offset=\"{}\"", offset), kOffsetWidth);
}

std::string head(Encoding encoding) {
  const char* compressor = encoding == Encoding::kZlib  ? " compressor=\"vtkZLibDataCompressor\""
                           : encoding == Encoding::kLz4 ? " compressor=\"vtkLZ4DataCompressor\""
                                                        : "";
  return vtk_file_tag("UnstructuredGrid", compressor) + "  <UnstructuredGrid>\n";
}

}  // namespace

OutputFile::Access VtuWriter::access(Encoding encoding) {
  return encoding == Encoding::kZlib || encoding == Encoding::kLz4 ? OutputFile::Access::kPatch
                                                                   : OutputFile::Access::kAppend;
}

bool VtuWriter::appended() const {
  return encoding_ == Encoding::kRaw || encoding_ == Encoding::kZlib || encoding_ == Encoding::kLz4;
}

VtuWriter::VtuWriter(OutputFile* file, const VtuLayout& layout,
                     std::function<void(double)> progress)
    : file_(file), encoding_(layout.encoding), progress_(std::move(progress)) {
  if (encoding_ == Encoding::kZlib) compressor_.emplace(Compression::kZlib);
  if (encoding_ == Encoding::kLz4) compressor_.emplace(Compression::kLz4);
  stage_bytes_ = compressed() ? compressor_->batch_bytes() : kTextStage;
  declare(layout);
  expect_size();
  if (appended()) {
    for (const Slot& slot : slots_) {
      offset_fields_.push_back(file_->size() + slot.offset_field);
      file_->append(slot.before.data(), slot.before.size());
      file_->append(slot.after.data(), slot.after.size());
    }
    data_start_ = file_->size();
  }
  begin_arrays();
  for (const DataArray& array : layout.field_data) put(array.bytes);
}

void VtuWriter::declare(const VtuLayout& layout) {
  pending_ = head(encoding_);
  if (!layout.field_data.empty()) {
    pending_ += "    <FieldData>\n";
    for (const DataArray& array : layout.field_data) {
      add_slot(array.info, array.bytes.size(), Place::kFieldData);
    }
    pending_ += "    </FieldData>\n";
  }
  pending_ += fmt::format("    <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", layout.points,
                          layout.cells);
  add_section("PointData", layout.point_data, layout.points);
  add_section("CellData", layout.cell_data, layout.cells);
  AttributeSet points, cells;
  points.arrays = {{"Points", layout.point_type, 3, {}, 0}};
  add_section("Points", points, layout.points);
  // Newer VTK reads Int32 too, but Int64 is what every version reads.
  pending_ += "      <Cells>\n";
  const auto add = [&](const char* name, ValueType type, std::uint64_t values) {
    add_slot({name, type, 1, {}, values}, values * size_of(type), Place::kPiece);
  };
  add("connectivity", ValueType::kInt64, layout.corners);
  add("offsets", ValueType::kInt64, layout.cells);
  add("types", ValueType::kUInt8, layout.cells);
  slots_.back().after += "      </Cells>\n    </Piece>\n  </UnstructuredGrid>\n";
  slots_.back().after += appended() ? "  <AppendedData encoding=\"raw\">\n   _" : "</VTKFile>\n";
}

void VtuWriter::add_section(const char* element, const AttributeSet& set, std::uint64_t tuples) {
  pending_ += fmt::format("      <{}{}>\n", element, active_attributes(set));
  for (ArrayInfo info : set.arrays) {
    info.tuples = tuples;
    add_slot(info, info.bytes(), Place::kPiece);
  }
  pending_ += fmt::format("      </{}>\n", element);
}

void VtuWriter::add_slot(const ArrayInfo& info, std::uint64_t bytes, Place place) {
  const char* element = info.type == ValueType::kString ? "Array" : "DataArray";
  Slot slot;
  slot.info = info;
  slot.bytes = bytes;
  slot.before =
      fmt::format("{}        <{} {}", std::exchange(pending_, {}), element, array_attributes(info));
  const std::string units = units_element(info);
  const std::string end = fmt::format("</{}>\n", element);
  if (place == Place::kFieldData) slot.before += fmt::format(" NumberOfTuples=\"{}\"", info.tuples);
  if (appended()) {
    slot.before += " format=\"appended\" ";
    slot.offset_field = slot.before.size();
    slot.before += offset_attribute(payload_) + (units.empty() ? "/>\n" : ">" + units + end);
    payload_ += sizeof(std::uint64_t) + bytes;
  } else {
    slot.before +=
        encoding_ == Encoding::kInline ? " format=\"binary\">\n" : " format=\"ascii\">\n";
    slot.after = "\n        " + units + end;  // what reads text stops at a tag
  }
  total_bytes_ += bytes;
  slots_.push_back(std::move(slot));
}

// Tells the file how long it will be, where that is known.
void VtuWriter::expect_size() {
  if (compressed() || encoding_ == Encoding::kAscii) return;
  std::uint64_t bytes = file_->size() + kTail.size();
  for (const Slot& slot : slots_) {
    const std::uint64_t values = sizeof(std::uint64_t) + slot.bytes;
    bytes += slot.before.size() + slot.after.size() + (appended() ? values : base64_size(values));
  }
  file_->expect(bytes);
}

// Begins the next array that has values, ending those on the way that have none.
void VtuWriter::begin_arrays() {
  while (next_ < slots_.size()) {
    begin_array();
    if (slots_[next_].bytes > 0) return;
    end_array();
  }
}

void VtuWriter::begin_array() {
  const Slot& slot = slots_[next_];
  slot_bytes_ = 0;
  text_values_ = 0;
  if (!appended()) file_->append(slot.before.data(), slot.before.size());
  if (compressed()) {
    begin_blocks();
  } else if (encoding_ == Encoding::kRaw) {
    file_->append(&slot.bytes, sizeof(slot.bytes));
  } else if (encoding_ == Encoding::kInline) {
    stage(std::as_bytes(std::span(&slot.bytes, 1)));  // one base64 text with the values
  }
}

void VtuWriter::end_array() {
  encode_staged();
  if (compressed()) end_blocks();
  if (!appended()) file_->append(slots_[next_].after.data(), slots_[next_].after.size());
  ++next_;
}

void VtuWriter::put(std::span<const std::byte> values) {
  constexpr std::size_t kBytesBetweenReports = std::size_t{8} << 20;
  if (values.empty()) return;
  if (current() == nullptr || values.size() > slots_[next_].bytes - slot_bytes_) {
    throw std::logic_error("VtuWriter::put() past the end of an array");
  }
  while (!values.empty()) {
    const auto run = values.first(std::min(values.size(), kBytesBetweenReports));
    if (encoding_ == Encoding::kRaw) {
      file_->append(run.data(), run.size());
    } else {
      stage(run);
    }
    values = values.subspan(run.size());
    slot_bytes_ += run.size();
    done_bytes_ += run.size();
    if (progress_) progress_(static_cast<double>(done_bytes_) / static_cast<double>(total_bytes_));
  }
  if (slot_bytes_ < slots_[next_].bytes) return;
  end_array();
  begin_arrays();
}

std::uint64_t VtuWriter::leave_room() {
  if (current() == nullptr || slot_bytes_ > 0 || !can_leave_room()) {
    throw std::logic_error("VtuWriter::leave_room() where there is none");
  }
  const std::uint64_t offset = file_->leave_room(slots_[next_].bytes);
  done_bytes_ += slots_[next_].bytes;
  end_array();
  begin_arrays();
  return offset;
}

// What is much is compressed where it is.
void VtuWriter::stage(std::span<const std::byte> values) {
  while (!values.empty()) {
    if (compressed() && stage_.empty() && values.size() >= stage_bytes_) {
      const auto whole = values.first(values.size() / stage_bytes_ * stage_bytes_);
      compress(whole);
      values = values.subspan(whole.size());
      continue;
    }
    const auto part = values.first(std::min(values.size(), stage_bytes_ - stage_.size()));
    stage_.insert(stage_.end(), part.begin(), part.end());
    values = values.subspan(part.size());
    if (stage_.size() == stage_bytes_) encode_staged();
  }
}

void VtuWriter::compress(std::span<const std::byte> values) {
  compressor_->compress(values, [&](std::span<const std::byte> block) {
    header_.push_back(block.size());
    file_->append(block.data(), block.size());
  });
}

void VtuWriter::encode_staged() {
  if (stage_.empty()) return;
  if (compressed()) {
    compress(stage_);
  } else {
    if (encoding_ == Encoding::kInline) {
      base64_encode(stage_, &text_);
    } else {
      const ArrayInfo& info = slots_[next_].info;
      text_encode(info.type, stage_, {text_values_, info.components}, &text_);
      text_values_ += stage_.size() / size_of(info.type);
    }
    file_->append(text_.data(), text_.size());
  }
  stage_.clear();
}

// Leaves room for the block header and says where the array begins.
void VtuWriter::begin_blocks() {
  const std::uint64_t bytes = slots_[next_].bytes;
  const std::uint64_t block_bytes = compressor_->block_bytes();
  const std::uint64_t blocks = (bytes + block_bytes - 1) / block_bytes;
  header_offset_ = file_->size();
  header_ = {blocks, block_bytes, bytes % block_bytes};
  const Vector<std::uint64_t> room(3 + blocks, 0);
  file_->append(room.data(), room.size() * sizeof(std::uint64_t));
  const std::string offset = offset_attribute(header_offset_ - data_start_);
  file_->overwrite(offset_fields_[next_], offset.data(), offset.size());
}

void VtuWriter::end_blocks() {
  file_->overwrite(header_offset_, header_.data(), header_.size() * sizeof(std::uint64_t));
}

void VtuWriter::check_current(ValueType type) const {
  if (slots_[next_].info.type != type)
    throw std::logic_error("VtuWriter: another type was declared");
}

void VtuWriter::finish() {
  if (current() != nullptr) throw std::logic_error("VtuWriter::finish() before the end");
  if (appended()) file_->append(kTail.data(), kTail.size());
}

}  // namespace tetfusion
