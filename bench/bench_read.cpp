// Reads a mesh with all its arrays, several times, and prints the seconds of each reading, a line
// each: geometry alone, then geometry and arrays. Usage: bench_read FILE [TIMES [THREADS]]
#include <fmt/format.h>

#include <cstdlib>
#include <exception>

#include "base/resources.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"

int main(int argc, char** argv) {
  using namespace tetfusion;
  if (argc < 2) {
    fmt::print(stderr, "usage: bench_read FILE [TIMES [THREADS]]\n");
    return 2;
  }
  const int times = argc > 2 ? std::atoi(argv[2]) : 1;
  set_thread_count(argc > 3 ? std::atoi(argv[3]) : 0);
  try {
    for (int i = 0; i < times; ++i) {
      const double start = wall_seconds();
      const auto source = open_mesh(argv[1]);
      const Geometry geometry = source->read_geometry();
      const double geometry_read = wall_seconds();
      const MeshDescription& mesh = source->description();
      for (std::size_t a = 0; a < mesh.point_data.arrays.size(); ++a)
        source->read_array(Association::kPoint, a);
      for (std::size_t a = 0; a < mesh.cell_data.arrays.size(); ++a)
        source->read_array(Association::kCell, a);
      fmt::print("{:.4f} {:.4f}\n", geometry_read - start, wall_seconds() - start);
    }
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
  return 0;
}
