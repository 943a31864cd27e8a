// A mesh of the corpus, as it is written to a file and read from one: with nothing of the program
// that it is for.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "exact.h"

namespace corpus {

using Tet = std::array<std::int64_t, 4>;

struct Array {
  std::string name;
  std::string type;  // VTK's: "Float32", "Int64", ...
  std::size_t components = 1;
  std::string bytes;

  std::size_t row_bytes() const;
  std::size_t rows() const { return row_bytes() == 0 ? 0 : bytes.size() / row_bytes(); }
  bool is_float() const { return type[0] == 'F'; }
  double value(std::size_t i) const;  // of all components of all rows
  std::string row(std::size_t i) const { return bytes.substr(i * row_bytes(), row_bytes()); }
};

std::size_t bytes_of_type(const std::string& type);

template <class T>
Array make_array(const std::string& name, const std::string& type, std::size_t components,
                 const std::vector<T>& values) {
  Array array{name, type, components, std::string(values.size() * sizeof(T), '\0')};
  if (!values.empty()) std::memcpy(array.bytes.data(), values.data(), array.bytes.size());
  return array;
}

struct LowerCell {
  int type = 1;  // VTK's: 1, 3, 5
  std::vector<std::int64_t> corners;

  friend bool operator==(const LowerCell&, const LowerCell&) = default;
};

struct Mesh {
  bool floats = false;  // coordinates are single precision
  std::vector<Point> points;
  std::vector<Tet> tets;
  std::vector<LowerCell> lower;  // after the tetrahedra, in the file too
  std::vector<Array> point_arrays, cell_arrays, field_arrays;

  std::size_t cells() const { return tets.size() + lower.size(); }
};

const Array* find(const std::vector<Array>& arrays, const std::string& name);

// Raw appended data. Throws std::runtime_error.
void write_vtu(const Mesh& mesh, const std::string& path);
// Reads what has been written so, of one piece, and checks that arrays and ids fit each other.
Mesh read_vtu(const std::string& path);

}  // namespace corpus
