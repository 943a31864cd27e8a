#include "io/source/mesh_stream.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <utility>
#include <variant>

#include "base/blocks.h"
#include "io/source/reading_memory.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

constexpr std::size_t kTuplesPerBlock = 65536;

// A mesh in memory. Tetrahedra come first, then the cells of lower dimension: a cell's number is
// its row.
class WholeMeshStream final : public MeshStream {
 public:
  explicit WholeMeshStream(MeshSource* source)
      : source_(source), mesh_(source->read_geometry()), points_(point_count(mesh_.points)) {}

  std::uint64_t points() const override { return points_; }
  std::uint64_t cells() const override { return mesh_.tets.size() + mesh_.lower.size(); }
  LowerCount lower_cells() const override {
    return {mesh_.lower.size(), mesh_.lower.connectivity.size()};
  }
  std::uint64_t ghost_cells() const override { return mesh_.ghost_cells; }
  std::uint64_t merged_points() const override { return mesh_.merged_points; }
  std::uint64_t differing_points() const override { return mesh_.differing_points; }
  LargestDifference largest_difference() const override { return mesh_.largest_difference; }
  std::uint64_t dropped_points() const override { return mesh_.unused_points; }
  bool streams_from_disk() const override { return false; }

  void read_points(std::uint64_t first, std::uint64_t count,
                   std::span<std::byte> out) const override {
    check_window(first, count, points_);
    std::visit(
        [&](const auto& points) {
          const std::size_t bytes = count * sizeof(points[0]);
          if (bytes > 0) std::memcpy(out.data(), points.data() + first, bytes);
        },
        mesh_.points);
  }

  void read_cells(std::uint64_t first, std::uint64_t count, CellWindow* out) const override {
    check_window(first, count, cells());
    *out = {};
    if (first == 0 && count > 0) out->ghost_cells = mesh_.ghost_cells;
    const std::uint64_t tets = mesh_.tets.size();
    const std::uint64_t last = first + count;
    if (first < tets) {
      const Tet* const from = mesh_.tets.data();
      out->tets.assign(from + first, from + std::min(last, tets));
    }
    for (std::uint64_t cell = std::max(first, tets); cell < last; ++cell) {
      out->lower.add(mesh_.lower.types[cell - tets], mesh_.lower.corners(cell - tets));
      out->lower_rows.push_back(cell);
    }
  }

  void read_rows(Association association, std::size_t index, std::uint64_t first,
                 std::uint64_t count, std::span<std::byte> out) const override {
    check_window(first, count, association == Association::kPoint ? points_ : cells());
    if (count == 0) return;
    const DataArray& array = array_at(association, index);
    const std::size_t tuple = array.info.row_bytes();
    for_each_block(count, kTuplesPerBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint64_t from =
            association == Association::kPoint ? point_in_file(first + i) : cell_in_file(first + i);
        std::memcpy(out.data() + i * tuple, array.bytes.data() + from * tuple, tuple);
      }
    });
  }

 private:
  static std::uint64_t look_up(const Vector<std::uint64_t>& source, std::uint64_t i) {
    return source.empty() ? i : source[i];
  }
  std::uint64_t point_in_file(std::uint64_t point) const {
    return look_up(mesh_.point_source, point);
  }
  std::uint64_t cell_in_file(std::uint64_t cell) const {
    const std::uint64_t tets = mesh_.tets.size();
    return cell < tets ? look_up(mesh_.tet_source, cell) : look_up(mesh_.lower_source, cell - tets);
  }

  // Read when it is first asked for; stays where it is.
  const DataArray& array_at(Association association, std::size_t index) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto key = std::make_pair(association, index);
    const auto found = arrays_.find(key);
    if (found != arrays_.end()) return found->second;
    return arrays_.emplace(key, source_->read_array(association, index)).first->second;
  }

  MeshSource* source_;
  Geometry mesh_;
  std::uint64_t points_;
  mutable std::mutex mutex_;
  mutable std::map<std::pair<Association, std::size_t>, DataArray> arrays_;
};

}  // namespace

void check_window(std::uint64_t first, std::uint64_t count, std::uint64_t size) {
  if (first > size || count > size - first) throw std::out_of_range("a window behind the mesh");
}

std::unique_ptr<MeshStream> MeshSource::stream() { return nullptr; }
std::vector<DataArray> MeshSource::read_field_data() {
  std::vector<DataArray> arrays;
  for (std::size_t i = 0; i < description().field_data.arrays.size(); ++i) {
    arrays.push_back(read_array(Association::kField, i));
  }
  return arrays;
}

std::unique_ptr<MeshStream> MeshSource::stream_of_rows() { return stream(); }

std::optional<std::uint64_t> MeshSource::mesh_checksum(const RunContext& /*context*/) {
  return std::nullopt;
}

std::uint64_t MeshSource::memory_to_read() {
  CellTypeCounts cells{};
  cells[kVtkTetra] = description().cells;
  return tetfusion::memory_to_read(description(), cells);
}

std::unique_ptr<MeshStream> open_stream(MeshSource* source,
                                        const std::function<void(std::uint64_t bytes)>& reserve) {
  std::unique_ptr<MeshStream> stream = source->stream();
  if (stream != nullptr) return stream;
  if (reserve) reserve(source->memory_to_read());
  return std::make_unique<WholeMeshStream>(source);
}

std::unique_ptr<MeshStream> open_rows(MeshSource* source) {
  std::unique_ptr<MeshStream> stream = source->stream_of_rows();
  return stream != nullptr ? std::move(stream) : std::make_unique<WholeMeshStream>(source);
}

}  // namespace tetfusion
