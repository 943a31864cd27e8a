#include "support/mesh_file.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "io/open_mesh.h"
#include "support/write_mesh.h"

namespace tetfusion::testing {

namespace {

DataArray read_named(MeshSource* source, Association association, const AttributeSet& set,
                     const std::string& name) {
  const std::size_t i = set.find(name);
  if (i == AttributeSet::npos) throw std::runtime_error("there is no array " + name);
  return source->read_array(association, i);
}

}  // namespace

void MeshFile::write(const std::string& path) const {
  OutputMesh mesh;
  mesh.points = &geometry.points;
  mesh.tets = &geometry.tets;
  mesh.lower = &geometry.lower;
  for (const DataArray& a : point_arrays) mesh.point_data.arrays.push_back(a.info);
  for (const DataArray& a : cell_arrays) mesh.cell_data.arrays.push_back(a.info);
  for (const DataArray& a : field_arrays) mesh.field_data.arrays.push_back(a.info);
  mesh.point_data.active = point_markers;
  mesh.read_array = [&](Association association, std::size_t i) {
    switch (association) {
      case Association::kPoint:
        return point_arrays[i];
      case Association::kCell:
        return cell_arrays[i];
      case Association::kField:
        break;
    }
    return field_arrays[i];
  };
  write_mesh(mesh, path);
}

MeshFile rich_box(std::uint32_t n) {
  MeshFile file;
  file.geometry = five_split_cube(n, 0.15, 4);
  auto& points = std::get<Vector<Point>>(file.geometry.points);
  for (std::size_t i = 0; i < 7; ++i) points.push_back({-1, static_cast<double>(i), 0});
  const auto at = [&](VertexId x, VertexId y, VertexId z) {
    return (z * (n + 1) + y) * (n + 1) + x;
  };
  LowerCells& lower = file.geometry.lower;
  lower.offsets = {0};
  const auto add_lower = [&](std::uint8_t type, std::initializer_list<VertexId> corners) {
    lower.types.push_back(type);
    lower.connectivity.insert(lower.connectivity.end(), corners);
    lower.offsets.push_back(lower.connectivity.size());
  };
  for (VertexId x = 2; x + 2 < n; ++x) add_lower(5, {at(x, 3, 3), at(x + 1, 3, 3), at(x, 4, 3)});
  add_lower(3, {at(2, 2, 2), at(2, 2, 3)});
  const auto loose = static_cast<VertexId>(points.size() - 2);
  add_lower(1, {loose});
  add_lower(3, {loose - 2, at(n, 0, 0)});

  file.point_arrays = {
      point_array<float>(file, "f", [](const Point& p) { return std::sin(p.x / 2) * p.y; }),
      make_array<std::int64_t>("ids", file.points(), 1, [](auto i, auto) { return 3 * i; }),
      make_array<std::uint8_t>("rgb", file.points(), 3, [](auto i, auto k) { return i * 7 + k; }),
      make_array<double>("tensor", file.points(), 6,
                         [](auto i, auto k) { return static_cast<double>(i) + 0.1 * k; })};
  file.point_markers = {{"Scalars", "f"}, {"GlobalIds", "ids"}};
  const std::size_t half = file.geometry.tets.size() / 2;
  file.cell_arrays = {
      make_array<std::int32_t>("material", file.cells(), 1,
                               [&](auto i, auto) { return i < half ? 1 : 2; }),
      make_array<double>("stress", file.cells(), 3,
                         [](auto i, auto k) { return static_cast<double>(i) / (k + 1); }),
      make_array<std::int16_t>("number", file.cells(), 1, [](auto i, auto) { return i; })};
  file.field_arrays = {make_array<double>("TimeValue", 1, 1, [](auto, auto) { return 2.5; })};
  return file;
}

MeshFile read_mesh_file(const std::string& path) {
  const auto source = open_mesh(path);
  const MeshDescription& description = source->description();
  MeshFile file;
  file.geometry = source->read_geometry();
  const auto read_all = [&](Association association, const AttributeSet& set) {
    std::vector<DataArray> arrays;
    for (std::size_t i = 0; i < set.arrays.size(); ++i) {
      arrays.push_back(source->read_array(association, i));
    }
    return arrays;
  };
  file.point_arrays = read_all(Association::kPoint, description.point_data);
  file.cell_arrays = read_all(Association::kCell, description.cell_data);
  file.field_arrays = read_all(Association::kField, description.field_data);
  file.point_markers = description.point_data.active;
  return file;
}

DataArray read_point_array(MeshSource* source, const std::string& name) {
  return read_named(source, Association::kPoint, source->description().point_data, name);
}

DataArray read_cell_array(MeshSource* source, const std::string& name) {
  return read_named(source, Association::kCell, source->description().cell_data, name);
}

std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error("cannot read " + path);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace tetfusion::testing
