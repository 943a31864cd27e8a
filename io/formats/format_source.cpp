#include "io/formats/format_source.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

#include "base/blocks.h"
#include "base/error.h"
#include "io/formats/format_stream.h"
#include "io/source/cell_kinds.h"
#include "io/source/file_cells.h"
#include "io/source/merge_pieces.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

class FormatSource final : public MeshSource {
 public:
  FormatSource(std::unique_ptr<FormatReader> reader, const OpenOptions& options)
      : reader_(std::move(reader)), options_(options) {}

  const MeshDescription& description() const override { return reader_->description(); }

  Geometry read_geometry() override {
    Geometry mesh;
    if (description().point_type == ValueType::kFloat32) {
      mesh.points = read_points<float>();
    } else {
      mesh.points = read_points<double>();
    }
    FileCells cells = take_list(reader_->read_cells(0, description().cells));
    Vector<std::uint8_t> used;
    used.assign(point_count(mesh.points), 0);
    mark(cells, &used);
    check_finite(mesh.points, used);
    Vector<VertexId> new_ids;
    if (std::find(used.begin(), used.end(), 0) != used.end()) {
      new_ids = compact_points(used, {}, &mesh);
    }
    take_cells(description().path, std::move(cells), new_ids, &mesh);
    return mesh;
  }

  DataArray read_array(Association association, std::size_t index) override {
    if (association == Association::kField) return reader_->read_field(index);
    const bool of_points = association == Association::kPoint;
    DataArray array;
    array.info = (of_points ? description().point_data : description().cell_data).arrays.at(index);
    array.bytes.resize(array.info.bytes());
    reader_->read_rows(association, index, 0, array.info.tuples, array.bytes.data());
    return array;
  }

  std::unique_ptr<MeshStream> stream() override { return open_format_stream(*reader_, options_); }

  std::uint64_t memory_to_read() override {
    return tetfusion::memory_to_read(description(), reader_->cell_types()) + reader_->bytes();
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kBadInput, description().path + ": " + what);
  }

  template <class Real>
  Points read_points() const {
    Vector<Vec3<Real>> points(description().points);
    reader_->read_points(0, points.size(), reinterpret_cast<std::byte*>(points.data()));
    return points;
  }

  FileCells take_list(ListedCells list) const {
    FileCells cells;
    cells.tets_only = std::all_of(list.types.begin(), list.types.end(),
                                  [](std::uint8_t type) { return type == kVtkTetra; });
    cells.types = std::move(list.types);
    if (cells.tets_only) {
      cells.tets.resize(cells.types.size());
      if (!cells.tets.empty()) {
        std::memcpy(cells.tets.data(), list.ids.data(), cells.tets.size() * sizeof(Tet));
      }
      return cells;
    }
    cells.offsets.resize(cells.types.size() + 1);
    cells.offsets[0] = 0;
    for (std::size_t c = 0; c < cells.types.size(); ++c) {
      if (kept_vertices(cells.types[c], options_) < 0) {
        fail("cell " + std::to_string(c) + " " + refusal(cells.types[c], options_));
      }
      cells.offsets[c + 1] = cells.offsets[c] + corners_of(cells.types[c]);
    }
    leave_out_patches(options_, cells.types);
    cells.connectivity = std::move(list.ids);
    return cells;
  }

  // Sets a byte for each point that stays in a cell.
  void mark(const FileCells& cells, Vector<std::uint8_t>* used) const {
    for_each_block(
        cells.types.size(), kCellsPerBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
          for (std::size_t c = begin; c < end; ++c) {
            const VertexId* const ids =
                cells.tets_only ? cells.tets[c].data() : &cells.connectivity[cells.offsets[c]];
            const int kept = kept_vertices(cells.types[c], options_);
            for (int k = 0; k < kept; ++k) mark_used(used->data(), ids[k]);
          }
        });
  }

  void check_finite(const Points& points, const Vector<std::uint8_t>& used) const {
    std::visit(
        [&](const auto& xyz) {
          for (std::size_t v = 0; v < used.size(); ++v) {
            const double p[3] = {xyz[v].x, xyz[v].y, xyz[v].z};
            for (std::size_t axis = 0; axis < 3; ++axis) {
              if (used[v] == 0 || std::isfinite(p[axis])) continue;
              fail_not_finite(description(), v, axis, p[axis]);
            }
          }
        },
        points);
  }

  std::unique_ptr<FormatReader> reader_;
  OpenOptions options_;
};

}  // namespace

DataArray FormatReader::read_field(std::size_t) const {
  throw std::out_of_range("the format has no field data");
}

std::unique_ptr<MeshSource> make_source(std::unique_ptr<FormatReader> reader,
                                        const OpenOptions& options) {
  return std::make_unique<FormatSource>(std::move(reader), options);
}

}  // namespace tetfusion
