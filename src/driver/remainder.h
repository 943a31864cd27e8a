// What would be left of a mesh of which a part has been simplified: told by the inside of the part,
// as all that touches where it was cut out has stayed for that alone.
#pragma once

#include <cstdint>
#include <vector>

#include "base/vector.h"
#include "mesh/geometry.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Depth is how many edges there are from a vertex to the cut, of a tetrahedron the least of its
// corners'. Cells are so much the larger the deeper they lie, till they are what they would be
// without a cut; so there is an estimate for each depth, by what lies there or deeper, and the
// least one counts, as long as there are cells enough to tell. Cells that touch the boundary are
// taken for as many as there are boundary vertices, the others for what those leave of the mesh.
template <class Real>
class Remainder {
 public:
  // The part before anything has fused, along the curve. Vertices of the cut are on the interface.
  explicit Remainder(const WorkMesh<Real>& part);

  // How many tetrahedra would be left of a mesh of so many, with so many vertices on the boundary,
  // if it fared as the part, of which `left` is left.
  double of_mesh(const WorkMesh<Real>& left, double tets, double boundary_vertices) const;

 private:
  // Of the part, at one depth or deeper.
  struct Layer {
    double boundary_vertices = 0;
    // Left: where some of one lies deeper, its share.
    double cells_inside = 0, cells_at_boundary = 0;
    // There were where these cells are now.
    double tets_inside = 0, tets_at_boundary = 0;
  };
  struct Bounds {
    void add(const Vec3<double>& p);
    bool meets(const Bounds& other) const;
    Vec3<double> lo, hi;
  };
  void find_depths(const WorkMesh<Real>& part);
  void find_centres(const WorkMesh<Real>& part);
  std::vector<Layer> layers_of(const WorkMesh<Real>& left) const;
  void find_inside(const WorkMesh<Real>& mesh, const Tet& tet, Vector<std::uint8_t>* taken,
                   std::vector<std::uint32_t>* found) const;

  std::uint32_t deepest_ = 0;
  Vector<std::uint32_t> depths_;           // of tetrahedra
  std::vector<double> boundary_vertices_;  // of each depth
  Vector<Vec3<double>> centres_;           // of tetrahedra
  // Of kBlock centres each, and of kBlock blocks.
  std::vector<Bounds> blocks_, groups_;
};

}  // namespace tetfusion
