// Writes a VTK XML unstructured grid of one piece as a stream: what the file will hold is declared
// first, the values follow in the order of the file, in runs of any size. Memory does not grow with
// the mesh.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/resources.h"
#include "base/vector.h"
#include "io/files/output_file.h"
#include "io/vtk/encode.h"
#include "io/vtk/encoding.h"
#include "mesh/data_array.h"

namespace tetfusion {

struct VtuLayout {
  std::uint64_t points = 0;
  std::uint64_t cells = 0;
  std::uint64_t corners = 0;  // entries of the connectivity: the corners of all cells
  ValueType point_type = ValueType::kFloat32;
  AttributeSet point_data;  // tuples are ignored: they follow from the counts above
  AttributeSet cell_data;
  std::vector<DataArray> field_data;  // with values; the only arrays that may be of kString
  Encoding encoding = Encoding::kRaw;
};

// Not thread-safe; parallel inside. Passes on what OutputFile and the progress callback throw.
class VtuWriter {
 public:
  // What the OutputFile must allow for that encoding.
  static OutputFile::Access access(Encoding encoding);

  // Writes the head and the field data. `file` must outlive this object. `progress` is called now
  // and then with the share of the values written, 0..1.
  VtuWriter(OutputFile* file, const VtuLayout& layout, std::function<void(double)> progress = {});

  // The array whose values come next: point arrays, cell arrays, "Points" (three components), and
  // then "connectivity" and "offsets" (Int64), "types" (UInt8). Arrays without values are passed
  // over. Null when all are written.
  const ArrayInfo* current() const { return next_ < slots_.size() ? &slots_[next_].info : nullptr; }

  // Appends values to the current array, in native byte order; at most to its end.
  void put(std::span<const std::byte> values);

  // Writes all of the current array, whose values are of type T: fill(first, count, out) computes
  // the tuples first .. first + count - 1 into `out`. It is called from several threads and must
  // not throw.
  template <class T, class Fill>
  void put_computed(const Fill& fill);

  // Instead of putting the current array's values: leaves room for them in the file, and returns
  // where it begins; they are written as they are with OutputFile::place(). Only raw values in a
  // regular file.
  bool can_leave_room() const { return encoding_ == Encoding::kRaw && file_->can_leave_room(); }
  std::uint64_t leave_room();

  // Ends the file. All arrays must be complete; the OutputFile still has to be committed.
  void finish();

 private:
  struct Slot {
    ArrayInfo info;
    std::uint64_t bytes = 0;       // of all its values
    std::string before, after;     // the markup round it
    std::size_t offset_field = 0;  // appended: where in `before` the offset stands
  };

  enum class Place { kPiece, kFieldData };
  void add_slot(const ArrayInfo& info, std::uint64_t bytes, Place place);
  void add_section(const char* element, const AttributeSet& set, std::uint64_t tuples);
  void declare(const VtuLayout& layout);
  void expect_size();
  bool appended() const;
  bool compressed() const { return compressor_.has_value(); }
  void begin_arrays();
  void begin_array();
  void end_array();
  void stage(std::span<const std::byte> values);
  void encode_staged();
  void compress(std::span<const std::byte> values);
  void begin_blocks();
  void end_blocks();
  void check_current(ValueType type) const;
  std::uint32_t current_components() const { return slots_[next_].info.components; }
  std::uint64_t current_tuples() const { return slots_[next_].info.tuples; }

  OutputFile* file_;
  Encoding encoding_;
  std::function<void(double)> progress_;
  std::vector<Slot> slots_;
  std::string pending_;        // markup that goes before the next slot
  std::uint64_t payload_ = 0;  // uncompressed bytes of the appended data declared so far
  std::optional<BlockCompressor> compressor_;
  std::uint64_t total_bytes_ = 0;
  std::uint64_t done_bytes_ = 0;

  std::size_t next_ = 0;           // the current slot
  std::uint64_t slot_bytes_ = 0;   // of its values, those put so far
  std::uint64_t text_values_ = 0;  // kAscii: values of the slot encoded so far
  std::size_t stage_bytes_ = 0;    // values encoded at a time
  Vector<std::byte> stage_;        // values not yet encoded
  Vector<char> text_;
  Vector<std::uint64_t> offset_fields_;  // compressed: of each slot, in the file
  std::uint64_t data_start_ = 0;         // offsets count from here
  std::uint64_t header_offset_ = 0;      // compressed: of the current slot's block header
  Vector<std::uint64_t> header_;         // compressed: that header
};

template <class T, class Fill>
void VtuWriter::put_computed(const Fill& fill) {
  // One thread's run is still in its cache when it is encoded.
  const std::uint64_t run_bytes = std::uint64_t{thread_count() > 1 ? 4096U : 512U} << 10;
  constexpr std::uint64_t kTuplesPerTask = 4096;
  if (current() == nullptr) return;
  check_current(value_type_of<T>());
  const std::uint64_t width = current_components();
  const std::uint64_t tuples = current_tuples();
  const std::uint64_t run =
      std::max<std::uint64_t>(run_bytes / (width * sizeof(T)) / kTuplesPerTask, 1) * kTuplesPerTask;
  Vector<T> values(std::min(run, tuples) * width);
  for (std::uint64_t first = 0; first < tuples; first += run) {
    const std::uint64_t count = std::min(run, tuples - first);
    const auto tasks = static_cast<std::int64_t>((count + kTuplesPerTask - 1) / kTuplesPerTask);
#pragma omp parallel for schedule(static)
    for (std::int64_t task = 0; task < tasks; ++task) {
      const std::uint64_t begin = static_cast<std::uint64_t>(task) * kTuplesPerTask;
      fill(first + begin, std::min(kTuplesPerTask, count - begin), values.data() + begin * width);
    }
    put(std::as_bytes(std::span<const T>(values.data(), count * width)));
  }
}

}  // namespace tetfusion
