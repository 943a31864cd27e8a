#include "io/vtk/vtu_reader.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "base/error.h"
#include "io/source/cell_kinds.h"
#include "io/source/differing_copies.h"
#include "io/source/merge_pieces.h"
#include "io/source/reading_memory.h"
#include "io/vtk/legacy_head.h"
#include "io/vtk/pieces_stream.h"
#include "io/vtk/vtu_cell_arrays.h"
#include "io/vtk/vtu_cells.h"
#include "io/vtk/vtu_input.h"
#include "io/vtk/vtu_points.h"
#include "io/vtk/vtu_stream.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

class VtuSource final : public MeshSource {
 public:
  VtuSource(MappedFile file, const OpenOptions& options, VtuHead (*parse)(const MappedFile&))
      : input_{std::move(file), {}}, options_(options) {
    input_.guarded([&] {
      input_.head = parse(input_.file);
      describe();
    });
  }

  const MeshDescription& description() const override { return description_; }

  // Cells that are to be split and that VTK alone reads, by their name; empty: there are none.
  std::string cells_for_vtk() const {
    if (!options_.tetrahedralize) return {};
    const auto& pieces = input_.head.pieces;
    if (std::any_of(pieces.begin(), pieces.end(), [](const auto& p) { return p.has_faces; })) {
      return "polyhedra";
    }
    if (options_.drop_patches) return {};
    CellTypeCounts cells{};
    input_.guarded([&] { cells = count_types(input_); });
    return cells[kVtkPolygon] > 0 ? "polygons" : "";
  }

  Geometry read_geometry() override {
    Geometry mesh;
    input_.guarded([&] { read_geometry_into(&mesh); });
    return mesh;
  }

  std::unique_ptr<MeshStream> stream() override {
    const std::size_t count = input_.head.pieces.size();
    if (is_one_mesh()) return open_vtu_stream(input_, description_, options_);
    std::vector<StreamPiece> pieces;
    for (std::size_t p = 0; p < count; ++p) pieces.push_back({&input_, p});
    return open_pieces_stream(pieces, description_, options_);
  }

  std::unique_ptr<MeshStream> stream_of_rows() override {
    return is_one_mesh() ? open_vtu_rows(input_, description_, options_) : stream();
  }

  std::uint64_t memory_to_read() override {
    CellTypeCounts cells{};
    std::uint64_t ids = 0, decoding = 0;
    input_.guarded([&] {
      cells = count_types(input_);
      ids = count_ids(input_);
      decoding = decoding_bytes();
    });
    return tetfusion::memory_to_read(description_, cells, ids) + decoding;
  }

  std::optional<std::uint64_t> mesh_checksum(const RunContext& context) override {
    std::optional<std::uint64_t> sum;
    if (input_.head.pieces.size() == 1) input_.guarded([&] { sum = sum_of_arrays(context); });
    return sum;
  }

  DataArray read_array(Association association, std::size_t index) override {
    DataArray array;
    input_.guarded([&] {
      array = association == Association::kField ? read_field(index)
                                                 : read_attribute(association, index);
    });
    return array;
  }

 private:
  // Points are those of the file.
  bool is_one_mesh() const { return input_.head.pieces.size() == 1 && !options_.merge_points; }

  [[noreturn]] void fail(ErrorCode code, const std::string& what) const { input_.fail(code, what); }

  void describe() {
    MeshDescription& d = description_;
    const VtuHead& head = input_.head;
    d.path = input_.file.path();
    d.format = head.format;
    d.pieces = head.pieces.size();
    d.joins_points = !is_one_mesh();
    d.file_bytes = input_.file.size();
    d.spooled_checksum = input_.file.spooled_checksum();
    piece_begin_.push_back(0);
    bool found_points = false;
    for (const VtuPiece& piece : head.pieces) {
      d.points += piece.points;
      d.cells += piece.cells;
      piece_begin_.push_back(d.points);
      if (!piece.coordinates.present || found_points) continue;
      found_points = true;
      d.point_type = point_type_for(piece.coordinates.info.type);
    }
    d.point_data = head.point_data;
    d.cell_data = head.cell_data;
    unmark_global_ids(options_, &d.cell_data);
    d.unread = head.unread;
    for (std::size_t i = 0; i < head.field_data.size(); ++i) {
      d.field_data.arrays.push_back(head.field_data[i].info);
      if (!head.field_data[i].counted) count_field(i);
    }
    if (d.cells == 0) fail(ErrorCode::kBadInput, "the mesh has no cells");
  }

  // ---- arrays ----

  // Of the array that takes most.
  std::uint64_t decoding_bytes() const {
    std::uint64_t most = 0;
    if (input_.head.layout.compressor == Compressor::kNone) return most;
    const auto look_at = [&](const VtuArray& array) {
      if (array.present && !array.computed && array.payload.coding != Coding::kAscii) {
        most = std::max(most,
                        input_.open(array, "array \"" + array.info.name + "\"").decoding_bytes());
      }
    };
    for (const VtuPiece& piece : input_.head.pieces) {
      for (const VtuArray* array :
           {&piece.coordinates, &piece.connectivity, &piece.offsets, &piece.types}) {
        look_at(*array);
      }
      for (const auto* arrays : {&piece.point_data, &piece.cell_data}) {
        std::for_each(arrays->begin(), arrays->end(), look_at);
      }
    }
    return most;
  }

  ArrayReader open_field(std::size_t index) const {
    const VtuArray& array = input_.head.field_data[index];
    return input_.open(array, "field array \"" + array.info.name + "\"");
  }

  // The number of tuples of a field array whose head does not tell it.
  void count_field(std::size_t index) {
    ArrayInfo& info = description_.field_data.arrays[index];
    std::uint64_t values = 0;
    if (info.type == ValueType::kString) {
      const DataArray array = read_field(index);
      values = static_cast<std::uint64_t>(
          std::count(array.bytes.begin(), array.bytes.end(), std::byte{0}));
    } else {
      values = open_field(index).values();
    }
    if (values % info.components != 0) {
      fail(ErrorCode::kBadInput, "field array \"" + info.name + "\": " + std::to_string(values) +
                                     " values are no whole number of tuples of " +
                                     std::to_string(info.components));
    }
    info.tuples = values / info.components;
  }

  DataArray read_field(std::size_t index) const {
    const ArrayReader reader = open_field(index);
    DataArray array;
    array.info = description_.field_data.arrays.at(index);
    array.bytes.resize(reader.values() * size_of(reader.type()));
    reader.read_all(array.bytes.data());
    const bool text = array.info.type == ValueType::kString;
    if (text && !array.bytes.empty() && array.bytes.back() != std::byte{0}) {
      array.bytes.push_back(std::byte{0});
    }
    return array;
  }

  DataArray read_attribute(Association association, std::size_t index) const {
    const bool of_points = association == Association::kPoint;
    const AttributeSet& set = of_points ? description_.point_data : description_.cell_data;
    DataArray array;
    array.info = set.arrays.at(index);
    const std::size_t value_bytes = size_of(array.info.type);
    array.bytes.resize(array.info.values() * value_bytes);
    const std::string label =
        std::string(of_points ? "point" : "cell") + " array \"" + array.info.name + "\"";
    std::uint64_t at = 0;
    for (std::size_t p = 0; p < input_.head.pieces.size(); ++p) {
      const VtuPiece& piece = input_.head.pieces[p];
      const std::vector<VtuArray>& arrays = of_points ? piece.point_data : piece.cell_data;
      if (arrays.empty()) continue;
      const ArrayReader reader = input_.open(arrays[index], label + input_.of_piece(p));
      reader.read_all(array.bytes.data() + at);
      at += reader.values() * value_bytes;
    }
    forget_ghosts(association, array.info, array.bytes);
    return array;
  }

  // ---- geometry ----

  std::optional<std::uint64_t> sum_of_arrays(const RunContext& context) const {
    const VtuPiece& piece = input_.head.pieces[0];
    for (const VtuArray* array :
         {&piece.coordinates, &piece.connectivity, &piece.offsets, &piece.types}) {
      if (!array->present || array->computed) return std::nullopt;
    }
    const VtuCellArrays cells(input_, 0);
    std::uint64_t sum = 0;
    const auto add = [&](const ArrayReader& array) {
      sum = array.checksum_in_file(sum, [&] { context.check(); });
    };
    add(open_coordinates(input_, 0));
    add(cells.open_connectivity());
    add(cells.open_offsets());
    add(cells.open_types().reader);
    for (const VtuCellArrays::GhostArray& ghosts : cells.open_ghosts()) {
      sum += ghosts.levels ? 2 : 1;
      add(ghosts.reader);
    }
    return sum;
  }

  void read_geometry_into(Geometry* mesh) const {
    const std::uint64_t points = description_.points;
    check_point_count(input_, points);
    const bool finite = description_.point_type == ValueType::kFloat32
                            ? read_points<float>(&mesh->points)
                            : read_points<double>(&mesh->points);
    Vector<std::uint8_t> used;
    used.assign(points, 0);
    FileCells cells = read_cells(input_, options_, &used);
    if (!finite) check_finite(mesh->points, used);
    Vector<VertexId> new_ids;
    if (!is_one_mesh()) {
      const bool merges = options_.merge_points;  // whatever their ids
      const auto ids = merges ? Vector<std::int64_t>() : read_global_ids();
      const auto copy_of = match_points({&mesh->points, piece_begin_, ids, merges}, used);
      find_what_differs(copy_of, used, mesh);
      new_ids = compact_points(used, copy_of, mesh);
    } else if (std::find(used.begin(), used.end(), 0) != used.end()) {
      new_ids = compact_points(used, {}, mesh);
    }
    take_cells(input_.file.path(), std::move(cells), new_ids, mesh);
  }

  // False when a coordinate is not finite.
  template <class Real>
  bool read_points(Points* out) const {
    Vector<Vec3<Real>> points(description_.points);
    bool finite = true;
    for (std::size_t p = 0; p < input_.head.pieces.size(); ++p) {
      const std::uint64_t count = input_.head.pieces[p].points;
      if (count == 0) continue;
      std::byte* const to = reinterpret_cast<std::byte*>(points.data() + piece_begin_[p]);
      if (!read_coordinates(open_coordinates(input_, p), value_type_of<Real>(), 0, count, to)) {
        finite = false;
      }
    }
    *out = std::move(points);
    return finite;
  }

  // Throws InvalidMesh for the first used point that is not finite.
  void check_finite(const Points& points, const Vector<std::uint8_t>& used) const {
    std::visit(
        [&](const auto& xyz) {
          std::size_t piece = 0;
          for (std::uint64_t v = 0; v < used.size(); ++v) {
            while (v >= piece_begin_[piece + 1]) ++piece;
            if (used[v] == 0) continue;
            if (std::isfinite(xyz[v].x) && std::isfinite(xyz[v].y) && std::isfinite(xyz[v].z)) {
              continue;
            }
            fail_not_finite(open_coordinates(input_, piece), v - piece_begin_[piece]);
          }
        },
        points);
  }

  void find_what_differs(const Vector<VertexId>& copy_of, const Vector<std::uint8_t>& used,
                         Geometry* mesh) const {
    const std::vector<ArrayInfo>& arrays = description_.point_data.arrays;
    std::vector<ArrayReader> readers;  // of the array that was last asked for
    std::size_t open = AttributeSet::npos;
    Vector<std::byte> rows;
    const auto read = [&](std::size_t array, std::uint64_t first,
                          std::uint64_t count) -> std::span<const std::byte> {
      if (array != open) readers = open_point_array(array);
      open = array;
      const std::size_t components = arrays[array].components;
      const std::size_t stride = components * size_of(arrays[array].type);
      rows.resize(count * stride);
      std::size_t next = 0;  // of the readers
      for (std::size_t p = 0; p < input_.head.pieces.size(); ++p) {
        if (input_.head.pieces[p].point_data.empty()) continue;
        const ArrayReader& reader = readers[next++];
        const std::uint64_t begin = std::max(first, piece_begin_[p]);
        const std::uint64_t end = std::min(first + count, piece_begin_[p + 1]);
        if (begin >= end) continue;
        reader.read((begin - piece_begin_[p]) * components, (end - begin) * components,
                    rows.data() + (begin - first) * stride);
      }
      return rows;
    };
    const CopyDifferences found = find_differences(copy_of, used, arrays, read);
    mesh->differing_points = found.points;
    mesh->largest_difference = found.largest;
  }

  // One reader for each piece that has arrays of points.
  std::vector<ArrayReader> open_point_array(std::size_t index) const {
    std::vector<ArrayReader> readers;
    for (std::size_t p = 0; p < input_.head.pieces.size(); ++p) {
      const std::vector<VtuArray>& arrays = input_.head.pieces[p].point_data;
      if (arrays.empty()) continue;
      readers.push_back(input_.open(
          arrays[index], "point array \"" + arrays[index].info.name + "\"" + input_.of_piece(p)));
    }
    return readers;
  }

  // Empty when the points have no such ids.
  Vector<std::int64_t> read_global_ids() const {
    const std::size_t index = find_global_ids(description_.point_data);
    if (index == AttributeSet::npos) return {};
    const DataArray array = read_attribute(Association::kPoint, index);
    Vector<std::int64_t> ids(array.info.tuples);
    visit_type(array.info.type, [&](auto zero) {
      const auto values = array.as<decltype(zero)>();
      for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = static_cast<std::int64_t>(values[i]);
    });
    return ids;
  }

  VtuInput input_;
  OpenOptions options_;
  MeshDescription description_;
  std::vector<std::uint64_t> piece_begin_;  // first point of each piece; one entry more
};

std::unique_ptr<MeshSource> unless_for_vtk(MappedFile file, const OpenOptions& options,
                                           VtuHead (*parse)(const MappedFile&),
                                           std::string* for_vtk) {
  auto source = std::make_unique<VtuSource>(std::move(file), options, parse);
  *for_vtk = source->cells_for_vtk();
  if (!for_vtk->empty()) return nullptr;
  return source;
}

}  // namespace

std::unique_ptr<MeshSource> open_vtu(MappedFile file, const OpenOptions& options) {
  return std::make_unique<VtuSource>(std::move(file), options, parse_vtu_head);
}

std::unique_ptr<MeshSource> open_vtu(MappedFile file, const OpenOptions& options,
                                     std::string* for_vtk) {
  return unless_for_vtk(std::move(file), options, parse_vtu_head, for_vtk);
}

std::unique_ptr<MeshSource> open_legacy_vtk(MappedFile file, const OpenOptions& options) {
  return std::make_unique<VtuSource>(std::move(file), options, parse_legacy_head);
}

std::unique_ptr<MeshSource> open_legacy_vtk(MappedFile file, const OpenOptions& options,
                                            std::string* for_vtk) {
  return unless_for_vtk(std::move(file), options, parse_legacy_head, for_vtk);
}

}  // namespace tetfusion
