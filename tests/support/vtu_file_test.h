// A test that writes .vtu files and reads them. Every file that it opens is also read in windows,
// which must give the same mesh or the same error.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "base/error.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "support/mesh_file.h"
#include "support/stream_check.h"
#include "support/temp_dir.h"
#include "support/vtu_text.h"

namespace tetfusion::testing {

// Two tetrahedra that share a triangle.
inline const std::vector<double> kCoordinates = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0.1, 1, 1, -1e-3};
inline const std::vector<double> kIds = {0, 1, 2, 3, 4, 2, 1, 3};

class VtuFileTest : public ::testing::Test {
 protected:
  std::unique_ptr<MeshSource> open(const std::string& bytes, const OpenOptions& options = {}) {
    write_file(path_, bytes);
    expect_windows_like_whole(path_, options);
    return open_mesh(path_, options);
  }
  std::unique_ptr<MeshSource> open(const VtuText& mesh, const OpenOptions& options = {},
                                   const VtuStyle& style = {}) {
    return open(to_vtu(mesh, style), options);
  }
  Geometry read(const VtuText& mesh, const OpenOptions& options = {}) {
    return open(mesh, options)->read_geometry();
  }

  TempDir dir_;
  std::string path_ = dir_.file("mesh.vtu");
};

template <class Real>
std::vector<double> coordinates(const Geometry& mesh) {
  std::vector<double> out;
  for (const Vec3<Real>& p : std::get<Vector<Vec3<Real>>>(mesh.points)) {
    out.insert(out.end(), {p.x, p.y, p.z});
  }
  return out;
}

inline std::vector<Tet> tets(const Geometry& mesh) { return {mesh.tets.begin(), mesh.tets.end()}; }

template <class T>
std::vector<std::uint64_t> plain(const Vector<T>& v) {
  return {v.begin(), v.end()};
}

// What is thrown by reading: "InvalidMesh: ..." or "Error: ...".
inline std::string thrown_by(MeshSource* source) {
  try {
    source->read_geometry();
  } catch (const InvalidMesh& e) {
    return std::string("InvalidMesh: ") + e.what();
  } catch (const Error& e) {
    return std::string("Error: ") + e.what();
  }
  return "nothing";
}

}  // namespace tetfusion::testing
