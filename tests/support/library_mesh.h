// A mesh file in the making, as the public header wants meshes.
#pragma once

#include <cstdint>
#include <vector>

#include "support/mesh_file.h"
#include "tetfusion.h"

namespace tetfusion::testing {

// Owns what a Mesh refers to.
template <class Id>
class LibraryMesh {
 public:
  explicit LibraryMesh(const MeshFile& file, bool with_types) : file_(file) {
    const Geometry& g = file_.geometry;
    for (const Tet& t : g.tets) ids_.insert(ids_.end(), t.begin(), t.end());
    ids_.insert(ids_.end(), g.lower.connectivity.begin(), g.lower.connectivity.end());
    std::visit(
        [&](const auto& p) {
          mesh_.points = {value_of(p), p.data(), 3 * p.size()};
        },
        g.points);
    mesh_.connectivity = ids_;
    mesh_.point_arrays = arrays(file_.point_arrays);
    mesh_.cell_arrays = arrays(file_.cell_arrays);
    const auto scalars = file_.point_markers.find("Scalars");
    if (scalars != file_.point_markers.end()) mesh_.active_scalars = scalars->second;
    if (with_types || g.lower.size() > 0) add_types();
  }
  LibraryMesh(const LibraryMesh&) = delete;
  LibraryMesh& operator=(const LibraryMesh&) = delete;

  Mesh& mesh() { return mesh_; }

 private:
  static Type value_of(const Vector<Vec3<float>>&) { return Type::kFloat32; }
  static Type value_of(const Vector<Vec3<double>>&) { return Type::kFloat64; }

  static std::vector<Array> arrays(const std::vector<DataArray>& all) {
    std::vector<Array> out;
    for (const DataArray& a : all) {
      out.push_back({a.info.name,
                     a.info.components,
                     {static_cast<Type>(a.info.type), a.bytes.data(), a.info.values()}});
    }
    return out;
  }

  void add_types() {
    const Geometry& g = file_.geometry;
    types_.assign(g.tets.size(), 10);
    types_.insert(types_.end(), g.lower.types.begin(), g.lower.types.end());
    for (std::size_t c = 0; c <= g.tets.size(); ++c) offsets_.push_back(static_cast<Id>(4 * c));
    for (std::size_t c = 1; c <= g.lower.size(); ++c) {
      offsets_.push_back(static_cast<Id>(4 * g.tets.size() + g.lower.offsets[c]));
    }
    mesh_.types = types_;
    mesh_.offsets = offsets_;
  }

  MeshFile file_;
  std::vector<Id> ids_, offsets_;
  std::vector<std::uint8_t> types_;
  Mesh mesh_;
};

}  // namespace tetfusion::testing
