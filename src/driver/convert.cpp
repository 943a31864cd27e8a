#include "driver/convert.h"

#include <algorithm>
#include <cstring>
#include <functional>

#include "driver/arrays/carried_arrays.h"
#include "io/files/output_file.h"
#include "io/mesh_format.h"
#include "io/source/mesh_stream.h"
#include "io/vtk/cell_order.h"
#include "io/vtk/vtu_writer.h"
#include "mesh/array_names.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kCopiedWindow = std::uint64_t{1} << 19;

// Rows of an array in a window: fewer where they are wide.
std::uint64_t copied_window(const ArrayInfo& info) {
  constexpr std::uint64_t kCopiedBytes = std::uint64_t{8} << 20, kLeastCopied = 1024;
  return std::clamp(kCopiedBytes / info.row_bytes(), kLeastCopied, kCopiedWindow);
}

InputFacts facts_of(const MeshStream& stream) {
  InputFacts facts;
  facts.merged_points = stream.merged_points();
  facts.differing_points = stream.differing_points();
  facts.largest_difference = stream.largest_difference();
  facts.ghost_cells = stream.ghost_cells();
  return facts;
}

class Converter {
 public:
  explicit Converter(MeshSource* source)
      : source_(source), stream_(open_stream(source)), carried_(source->description()) {}

  InputFacts run(const std::string& path, const WriteOptions& options) {
    InputFacts facts = facts_of(*stream_);
    count_cells(options.progress);
    facts.tets = tets_;
    OutputFile file(path, VtuWriter::access(options.encoding));
    VtuWriter writer(&file, layout(options.encoding), options.progress);
    for (std::size_t i = 0; i < carried_.point_indices.size(); ++i) put_point_array(i, &writer);
    for (std::size_t i = 0; i < carried_.cell_indices.size(); ++i) put_cell_array(i, &writer);
    put_points(&writer);
    put_cells(&writer);
    writer.finish();
    file.commit();
    return facts;
  }

 private:
  // Calls f(first, count) for the windows of [0, all).
  template <class F>
  static void for_each_window(std::uint64_t all, F f, std::uint64_t window = kCopiedWindow) {
    for (std::uint64_t first = 0; first < all; first += window) {
      f(first, std::min(window, all - first));
    }
  }
  template <class F>
  void for_each_cell_window(F f, std::uint64_t rows = kCopiedWindow) {
    CellWindow window;
    const auto read = [&](std::uint64_t first, std::uint64_t count) {
      stream_->read_cells(first, count, &window);
      f(first, count, window);
    };
    for_each_window(stream_->cells(), read, rows);
  }

  void count_cells(const std::function<void(double)>& progress) {
    for_each_cell_window([&](std::uint64_t, std::uint64_t, const CellWindow& window) {
      if (progress) progress(0);  // who asks to stop does so there
      tets_ += window.tets.size();
      lower_cells_ += window.lower.size();
      lower_corners_ += window.lower.connectivity.size();
    });
  }

  VtuLayout layout(Encoding encoding) {
    VtuLayout file;
    file.points = stream_->points();
    file.cells = tets_ + lower_cells_;
    file.corners = 4 * tets_ + lower_corners_;
    file.point_type = source_->description().point_type;
    file.point_data = carried_.point_data;
    file.cell_data = carried_.cell_data;
    file.field_data = source_->read_field_data();
    file.encoding = encoding;
    return file;
  }

  void put_point_array(std::size_t i, VtuWriter* writer) {
    const ArrayInfo& info = carried_.point_data.arrays[i];
    Vector<std::byte> rows;
    const auto put = [&](std::uint64_t first, std::uint64_t count) {
      rows.resize(count * info.row_bytes());
      stream_->read_rows(Association::kPoint, carried_.point_indices[i], first, count, rows);
      writer->put(rows);
    };
    for_each_window(stream_->points(), put, copied_window(info));
  }

  void put_cell_array(std::size_t i, VtuWriter* writer) {
    const ArrayInfo& info = carried_.cell_data.arrays[i];
    const std::size_t stride = info.row_bytes();
    Vector<std::byte> rows, chosen, lower;
    const auto put = [&](std::uint64_t first, std::uint64_t count, const CellWindow& window) {
      rows.resize(count * stride);
      stream_->read_rows(Association::kCell, carried_.cell_indices[i], first, count, rows);
      chosen.resize(window.tets.size() * stride);
      for (std::size_t t = 0; t < window.tets.size(); ++t) {
        const std::uint64_t row = window.tet_rows.empty() ? t : window.tet_rows[t] - first;
        std::memcpy(chosen.data() + t * stride, rows.data() + row * stride, stride);
      }
      for (const std::uint64_t row : window.lower_rows) {
        const std::byte* begin = rows.data() + (row - first) * stride;
        lower.insert(lower.end(), begin, begin + stride);
      }
      writer->put(chosen);
    };
    for_each_cell_window(put, copied_window(info));
    if (!lower.empty()) writer->put(lower);
  }

  void put_points(VtuWriter* writer) {
    Vector<std::byte> values;
    for_each_window(stream_->points(), [&](std::uint64_t first, std::uint64_t count) {
      values.resize(count * 3 * size_of(source_->description().point_type));
      stream_->read_points(first, count, values);
      writer->put(values);
    });
  }

  void put_cells(VtuWriter* writer) {
    Vector<std::int64_t> corners, lower_corners;
    LowerCells lower;
    for_each_cell_window([&](std::uint64_t, std::uint64_t, const CellWindow& window) {
      corners.clear();
      for (const Tet& t : window.tets) corners.insert(corners.end(), t.begin(), t.end());
      writer->put(std::as_bytes(std::span(corners)));
      const LowerCells& cells = window.lower;
      if (lower.offsets.empty()) lower.offsets.push_back(0);
      for (std::size_t c = 0; c < cells.size(); ++c) {
        lower.offsets.push_back(lower_corners.size() + cells.offsets[c + 1]);
        lower.types.push_back(cells.types[c]);
      }
      lower_corners.insert(lower_corners.end(), cells.connectivity.begin(),
                           cells.connectivity.end());
    });
    if (!lower_corners.empty()) writer->put(std::as_bytes(std::span(lower_corners)));
    put_ends_and_types({tets_, &lower}, writer);
  }

  MeshSource* source_;
  std::unique_ptr<MeshStream> stream_;
  CarriedArrays carried_;
  std::uint64_t tets_ = 0;
  std::uint64_t lower_cells_ = 0;
  std::uint64_t lower_corners_ = 0;
};

}  // namespace

InputFacts convert_mesh(MeshSource* source, const std::string& path, const WriteOptions& options) {
  check_mesh_output(path, options.encoding);
  if (output_format(path) == MeshFormat::kVtu) {
    return Converter(source).run(path, options);
  }
  const MeshDescription& mesh = source->description();
  const auto& arrays = mesh.cell_data.arrays;
  const bool may_have_ghosts = std::any_of(
      arrays.begin(), arrays.end(), [](const ArrayInfo& info) { return is_ghost_mark(info.name); });
  InputFacts facts;
  if (may_have_ghosts || mesh.joins_points) facts = facts_of(*open_stream(source));
  facts.tets = write_mesh(source, path, options);
  return facts;
}

}  // namespace tetfusion
