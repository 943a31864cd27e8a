#include "driver/result.h"

#include <algorithm>
#include <cstring>
#include <vector>

namespace tetfusion {

namespace {

bool is_ghost_mark(const std::string& name) {
  return name == "vtkGhostType" || name == "vtkGhostLevels";
}

// The set without ghost marks, and each array's index in the source.
AttributeSet carried(const AttributeSet& set, std::vector<std::size_t>* indices) {
  AttributeSet kept;
  for (std::size_t i = 0; i < set.arrays.size(); ++i) {
    if (is_ghost_mark(set.arrays[i].name)) continue;
    kept.arrays.push_back(set.arrays[i]);
    indices->push_back(i);
  }
  kept.active = set.active;
  std::erase_if(kept.active, [](const auto& marker) { return is_ghost_mark(marker.second); });
  return kept;
}

std::uint64_t row_of(std::span<const std::uint64_t> rows, std::uint64_t id) {
  return rows.empty() ? id : rows[id];
}

class TupleCopier {
 public:
  TupleCopier(const DataArray& from, std::uint64_t tuples)
      : from_(from), stride_(from.info.components * size_of(from.info.type)) {
    to_.info = from.info;
    to_.info.tuples = tuples;
    to_.bytes.resize(tuples * stride_);
  }
  void copy(std::uint64_t from, std::uint64_t to) {
    std::memcpy(to_.bytes.data() + to * stride_, from_.bytes.data() + from * stride_, stride_);
  }
  DataArray take() { return std::move(to_); }

 private:
  const DataArray& from_;
  std::size_t stride_;
  DataArray to_;
};

DataArray point_array(const Result& result, const FuseLog& log, const InputRows& rows,
                      DataArray all) {
  carry_point_array(log, rows.points, &all);
  TupleCopier copier(all, result.point_ids.size());
  for (std::size_t p = 0; p < result.point_ids.size(); ++p) {
    copier.copy(row_of(rows.points, result.point_ids[p]), p);
  }
  return copier.take();
}

DataArray cell_array(const Result& result, const InputRows& rows, const DataArray& all) {
  const std::size_t tets = result.tet_ids.size();
  const std::size_t lower = result.mesh.lower.size();
  TupleCopier copier(all, tets + lower);
  for (std::size_t t = 0; t < tets; ++t) copier.copy(row_of(rows.tets, result.tet_ids[t]), t);
  for (std::size_t c = 0; c < lower; ++c) copier.copy(row_of(rows.lower, c), tets + c);
  return copier.take();
}

}  // namespace

void write_result(const Result& result, const FuseLog& log, const InputRows& rows,
                  const std::string& path, const WriteOptions& options, MeshSource* source) {
  const MeshDescription& input = source->description();
  std::vector<std::size_t> point_indices;
  std::vector<std::size_t> cell_indices;
  OutputMesh output;
  output.points = &result.mesh.points;
  output.tets = &result.mesh.tets;
  output.lower = &result.mesh.lower;
  output.point_data = carried(input.point_data, &point_indices);
  output.cell_data = carried(input.cell_data, &cell_indices);
  output.field_data = input.field_data;
  output.read_array = [&](Association association, std::size_t index) {
    switch (association) {
      case Association::kPoint:
        return point_array(result, log, rows,
                           source->read_array(association, point_indices[index]));
      case Association::kCell:
        return cell_array(result, rows, source->read_array(association, cell_indices[index]));
      case Association::kField:
        break;
    }
    return source->read_array(association, index);
  };
  write_mesh(output, path, options);
}

}  // namespace tetfusion
