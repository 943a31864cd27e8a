#include "series/result_mesh.h"

#include <cstdint>
#include <cstring>
#include <utility>

#include "driver/request/options.h"
#include "io/open_mesh.h"
#include "series/other_arrays.h"

namespace tetfusion {

ResultMesh::ResultMesh(const std::string& path, const MapFile& map) : map_(map), cells_(map) {
  const auto source = open_mesh(path);
  const std::size_t ids = source->description().point_data.find(kOriginalIds);
  if (ids == AttributeSet::npos) return;
  const Geometry mesh = source->read_geometry();
  DataArray points = source->read_array(Association::kPoint, ids);
  if (!mesh.point_source.empty()) {
    const DataArray all = points;
    points.info.tuples = mesh.point_source.size();
    points.bytes.resize(points.info.tuples * sizeof(std::int64_t));
    for (std::size_t p = 0; p < mesh.point_source.size(); ++p) {
      points.as<std::int64_t>()[p] = all.as<std::int64_t>()[mesh.point_source[p]];
    }
  }
  point_arrays_.push_back(std::move(points));
}

std::vector<DataArray> ResultMesh::cell_arrays(MeshSource* step, const RunContext& context) const {
  std::vector<DataArray> arrays;
  for (MovedCells& moved :
       cells_.move(step, cell_arrays_to_move(step->description().cell_data), context)) {
    arrays.push_back(std::move(moved.array));
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
      const std::uint64_t stride = array.info.row_bytes();
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
