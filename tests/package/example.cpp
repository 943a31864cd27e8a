// Makes a box of tetrahedra with a field on its points, and halves it.
#include <tetfusion.h>

#include <cstdint>
#include <cstdio>
#include <vector>

namespace {

constexpr std::int64_t kSide = 8;

std::int64_t point(std::int64_t x, std::int64_t y, std::int64_t z) {
  return (z * (kSide + 1) + y) * (kSide + 1) + x;
}

// Six tetrahedra round the diagonal of each cube.
std::vector<std::int64_t> kuhn_box() {
  constexpr int kOrders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {1, 0, 2}, {2, 1, 0}};
  std::vector<std::int64_t> corners;
  for (std::int64_t cube = 0; cube < kSide * kSide * kSide; ++cube) {
    for (const auto& order : kOrders) {
      std::int64_t at[3] = {cube % kSide, cube / kSide % kSide, cube / kSide / kSide};
      corners.push_back(point(at[0], at[1], at[2]));
      for (const int axis : order) {
        ++at[axis];
        corners.push_back(point(at[0], at[1], at[2]));
      }
    }
  }
  return corners;
}

}  // namespace

int main() {
  std::vector<double> coordinates;
  std::vector<float> field;
  for (std::int64_t z = 0; z <= kSide; ++z) {
    for (std::int64_t y = 0; y <= kSide; ++y) {
      for (std::int64_t x = 0; x <= kSide; ++x) {
        const double p[] = {0.1 * static_cast<double>(x), 0.1 * static_cast<double>(y),
                            0.1 * static_cast<double>(z)};
        coordinates.insert(coordinates.end(), p, p + 3);
        field.push_back(static_cast<float>(p[0] * p[1] - p[2]));
      }
    }
  }
  const std::vector<std::int64_t> corners = kuhn_box();

  tetfusion::Mesh mesh;
  mesh.points = coordinates;
  mesh.connectivity = corners;
  mesh.point_arrays = {{"field", 1, field}};
  tetfusion::Options options;
  options.reduction = 0.5;
  const tetfusion::Result result = tetfusion::simplify(mesh, options);
  if (!result.status.ok()) {
    std::fprintf(stderr, "%s\n", result.status.message.c_str());
    return static_cast<int>(result.status.code);
  }
  std::printf("tetfusion %s: %llu -> %llu tetrahedra\n%s\n", tetfusion::library_version(),
              static_cast<unsigned long long>(result.report.input.tets),
              static_cast<unsigned long long>(result.mesh.tets),
              result.report.stop_sentence.c_str());
  return 0;
}
