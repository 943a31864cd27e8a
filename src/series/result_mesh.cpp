#include "series/result_mesh.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "driver/options.h"
#include "io/stream_windows.h"
#include "mesh/array_names.h"
#include "series/other_arrays.h"

namespace tetfusion {

namespace {

// Rows of an array as the mesh is read.
template <class T>
Vector<T> take_rows(const DataArray& array, const Vector<std::uint64_t>& source,
                    std::uint64_t count, std::uint64_t before) {
  Vector<T> rows(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    rows[i] = array.as<T>()[source.empty() ? before + i : source[i]];
  }
  return rows;
}

}  // namespace

ArrayInfo cell_numbers_info(const MeshDescription& mesh) {
  std::string name = "cell number";
  while (mesh.cell_data.find(name) != AttributeSet::npos) name += "'";
  return {name, ValueType::kInt64, 1, {}, mesh.cells};
}

ResultMesh::ResultMesh(const std::string& path, const MapFile& map) : map_(map) {
  const auto source = open_mesh(path);
  const Geometry mesh = source->read_geometry();
  const MeshDescription& description = source->description();
  const DataArray cells =
      source->read_array(Association::kCell, description.cell_data.arrays.size() - 1);
  const auto tets = take_rows<std::int64_t>(cells, mesh.tet_source, mesh.tets.size(), 0);
  const auto lower =
      take_rows<std::int64_t>(cells, mesh.lower_source, mesh.lower.size(), mesh.tets.size());
  numbers_.assign(tets.begin(), tets.end());
  numbers_.insert(numbers_.end(), lower.begin(), lower.end());
  order_ = count_up<std::uint32_t>(numbers_.size());
  std::sort(order_.begin(), order_.end(),
            [&](std::uint32_t a, std::uint32_t b) { return numbers_[a] < numbers_[b]; });
  const std::size_t ids = description.point_data.find(kOriginalIds);
  if (ids == AttributeSet::npos) return;
  DataArray points = source->read_array(Association::kPoint, ids);
  const auto rows = take_rows<std::int64_t>(points, mesh.point_source, point_count(mesh.points), 0);
  points.info.tuples = rows.size();
  points.bytes.resize(rows.size() * sizeof rows[0]);
  std::memcpy(points.bytes.data(), rows.data(), points.bytes.size());
  point_arrays_.push_back(std::move(points));
}

std::vector<DataArray> ResultMesh::cell_arrays(MeshSource* step, const RunContext& context) const {
  const AttributeSet& all = step->description().cell_data;
  const auto stream = open_rows(step);
  std::vector<DataArray> arrays;
  Vector<std::byte> rows;
  for (std::size_t i = 0; i < all.arrays.size(); ++i) {
    if (is_ghost_mark(all.arrays[i].name)) continue;
    DataArray array;
    array.info = all.arrays[i];
    array.info.tuples = numbers_.size();
    const std::size_t stride = array.info.components * size_of(array.info.type);
    array.bytes.resize(numbers_.size() * stride);
    for (std::size_t next = 0; next < order_.size();) {
      context.check();
      const std::uint64_t first = numbers_[order_[next]];
      const std::uint64_t count = std::min(kStreamWindow, stream->cells() - first);
      rows.resize(count * stride);
      stream->read_rows(Association::kCell, i, first, count, rows);
      for (; next < order_.size() && numbers_[order_[next]] < first + count; ++next) {
        std::memcpy(array.bytes.data() + order_[next] * stride,
                    rows.data() + (numbers_[order_[next]] - first) * stride, stride);
      }
    }
    arrays.push_back(std::move(array));
  }
  return arrays;
}

std::unique_ptr<MeshSource> ResultMesh::with(StepArrays arrays, const MeshDescription& step) const {
  for (const DataArray& own : point_arrays_) arrays.points.push_back(own);
  OtherArrays others;
  others.path = step.path;
  const auto add = [](std::vector<DataArray> from, const AttributeSet& set,
                      std::vector<ArrayFrom>* to, std::map<std::string, std::string>* markers) {
    for (DataArray& array : from) {
      for (const auto& [marker, name] : set.active) {
        if (name == array.info.name) (*markers)[marker] = name;
      }
      const std::uint64_t stride = array.info.components * size_of(array.info.type);
      const ArrayInfo info = array.info;
      to->push_back({info, [stride, values = std::make_shared<DataArray>(std::move(array))](
                               const MeshStream&, std::uint64_t first, std::span<std::byte> out) {
                       std::memcpy(out.data(), values->bytes.data() + first * stride, out.size());
                     }});
    }
  };
  add(std::move(arrays.points), step.point_data, &others.points, &others.point_markers);
  add(std::move(arrays.cells), step.cell_data, &others.cells, &others.cell_markers);
  others.field_data = std::move(arrays.field_data);
  MeshView view = map_.mesh();
  return with_arrays(open_view(std::move(view)), std::move(others));
}

}  // namespace tetfusion
