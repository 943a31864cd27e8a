// What tests of the library share.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/library_mesh.h"
#include "support/temp_dir.h"
#include "tetfusion.h"

namespace tetfusion::testing {

// The jittered cube of n^3 cubes, with a surface that is not flat and a field "wave".
inline MeshFile wavy_box(std::uint32_t n) {
  MeshFile file;
  file.geometry = five_split_cube(n, 0.15, 4);
  for (Point& p : std::get<Vector<Point>>(file.geometry.points)) {
    p.z += 0.04 * p.z * std::sin(p.x) * std::cos(0.8 * p.y);
  }
  file.point_arrays.push_back(point_array<float>(
      file, "wave", [&](const Point& p) { return std::sin(6 * p.x / n) * p.y + p.z; }));
  return file;
}

class LibraryTest : public ::testing::Test {
 protected:
  Result run(const MeshFile& file, const Observer& observer = {}) {
    LibraryMesh<std::int64_t> input(file, false);
    return simplify(input.mesh(), options, observer);
  }
  // Expects a failure.
  Status failure(const Mesh& mesh) {
    const Result result = simplify(mesh, options);
    EXPECT_FALSE(result.status.ok());
    EXPECT_TRUE(result.mesh.points.empty());
    return result.status;
  }

  TempDir folder = TempDir::in_memory();
  Options options;
};

}  // namespace tetfusion::testing
