// A mesh file in the making: a geometry and its arrays.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "io/source/mesh_source.h"
#include "mesh/data_array.h"
#include "support/meshes.h"

namespace tetfusion::testing {

struct MeshFile {
  Geometry geometry;
  std::vector<DataArray> point_arrays, cell_arrays, field_arrays;
  std::map<std::string, std::string> point_markers;

  std::size_t points() const { return point_count(geometry.points); }
  std::size_t cells() const { return geometry.tets.size() + geometry.lower.size(); }
  void write(const std::string& path) const;
};

// value(tuple, component) of each.
template <class T, class F>
DataArray make_array(const std::string& name, std::size_t tuples, std::uint32_t components,
                     F&& value) {
  DataArray array;
  array.info = {name, value_type_of<T>(), components, {}, tuples};
  array.bytes.resize(tuples * components * sizeof(T));
  for (std::size_t i = 0; i < tuples * components; ++i) {
    array.as<T>()[i] = static_cast<T>(value(i / components, i % components));
  }
  return array;
}

// An array over the points, from their coordinates.
template <class T, class F>
DataArray point_array(const MeshFile& file, const std::string& name, F&& f) {
  return make_array<T>(name, file.points(), 1, [&](std::size_t i, std::size_t) {
    return f(point(file.geometry, static_cast<VertexId>(i)));
  });
}

// The jittered cube of n^3 cubes with all that a mesh can have: arrays of several types on points
// and cells ("material" is one of 1 and 2), a field array, a fault of triangles, a line, cells on
// two points that no tetrahedron uses, and points of no cell.
MeshFile rich_box(std::uint32_t n);

// All of a file of one piece, to be changed and written again.
MeshFile read_mesh_file(const std::string& path);

// Throw where there is none of that name.
DataArray read_point_array(MeshSource* source, const std::string& name);
DataArray read_cell_array(MeshSource* source, const std::string& name);

template <class T>
std::vector<T> values(const DataArray& array) {
  const auto span = array.as<T>();
  return {span.begin(), span.end()};
}

// Of the array of that name.
template <class T>
std::vector<T> point_values(MeshSource* source, const std::string& name) {
  return values<T>(read_point_array(source, name));
}
template <class T>
std::vector<T> cell_values(MeshSource* source, const std::string& name) {
  return values<T>(read_cell_array(source, name));
}

// Of a file. Throws where it cannot be read.
std::string bytes_of(const std::string& path);

}  // namespace tetfusion::testing
