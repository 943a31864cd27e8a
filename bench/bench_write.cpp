// Writes a mesh that is in memory, with all its arrays, several times, and prints wall seconds,
// processor seconds and bytes of each writing, a line each.
// Usage: bench_write MESH OUT.vtu ENCODING [TIMES [THREADS]], ENCODING is raw, zlib or lz4
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "base/resources.h"
#include "io/files/output_file.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "io/vtk/cell_order.h"
#include "io/vtk/vtu_writer.h"

namespace {

using namespace tetfusion;

struct Mesh {
  MeshDescription description;
  Geometry geometry;
  std::vector<DataArray> point_arrays, cell_arrays;
};

Mesh read(const std::string& path) {
  const auto source = open_mesh(path);
  Mesh mesh{source->description(), source->read_geometry(), {}, {}};
  for (std::size_t i = 0; i < mesh.description.point_data.arrays.size(); ++i) {
    mesh.point_arrays.push_back(source->read_array(Association::kPoint, i));
  }
  for (std::size_t i = 0; i < mesh.description.cell_data.arrays.size(); ++i) {
    mesh.cell_arrays.push_back(source->read_array(Association::kCell, i));
  }
  return mesh;
}

std::uint64_t write(const Mesh& mesh, const std::string& path, Encoding encoding) {
  const Geometry& g = mesh.geometry;
  const CellOrder cells{g.tets.size(), &g.lower};
  const std::uint64_t corners = 4 * g.tets.size();
  VtuLayout layout;
  layout.points = point_count(g.points);
  layout.cells = cells.size();
  layout.corners = corners + g.lower.connectivity.size();
  layout.point_type = point_type(g.points);
  layout.point_data = mesh.description.point_data;
  layout.cell_data = mesh.description.cell_data;
  layout.encoding = encoding;
  OutputFile file(path, VtuWriter::access(encoding));
  VtuWriter writer(&file, layout);
  for (const DataArray& array : mesh.point_arrays) writer.put(array.bytes);
  for (const DataArray& array : mesh.cell_arrays) writer.put(array.bytes);
  std::visit([&](const auto& p) { writer.put(std::as_bytes(std::span(p))); }, g.points);
  writer.put_computed<std::int64_t>(
      [&](std::uint64_t first, std::uint64_t count, std::int64_t* out) {
        // Runs begin and end with a tetrahedron: put_computed() cuts at multiples of a power of
        // two.
        const std::uint64_t end = first + count;
        for (std::uint64_t t = first / 4; t < std::min(end, corners) / 4; ++t) {
          for (const VertexId v : g.tets[t]) *out++ = v;
        }
        for (std::uint64_t i = std::max(first, corners); i < end; ++i) {
          *out++ = g.lower.connectivity[i - corners];
        }
      });
  put_ends_and_types(cells, &writer);
  writer.finish();
  const std::uint64_t bytes = file.size();
  file.commit();
  return bytes;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    fmt::print(stderr, "usage: bench_write MESH OUT.vtu ENCODING [TIMES [THREADS]]\n");
    return 2;
  }
  const std::string name = argv[3];
  const Encoding encoding = name == "zlib"  ? Encoding::kZlib
                            : name == "lz4" ? Encoding::kLz4
                                            : Encoding::kRaw;
  const int times = argc > 4 ? std::atoi(argv[4]) : 1;
  set_thread_count(argc > 5 ? std::atoi(argv[5]) : 0);
  try {
    const Mesh mesh = read(argv[1]);
    for (int i = 0; i < times; ++i) {
      const double wall = wall_seconds();
      const double cpu = cpu_seconds();
      const std::uint64_t bytes = write(mesh, argv[2], encoding);
      fmt::print("{:.4f} {:.4f} {}\n", wall_seconds() - wall, cpu_seconds() - cpu, bytes);
    }
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
  return 0;
}
