#include "mesh/split_cells.h"

#include <algorithm>
#include <array>

namespace tetfusion {
namespace {

struct CellKind {
  std::string_view name;
  int size;
  int dimension;
};

// Indexed by VTK's number; from vtkCellType.h.
constexpr std::array<CellKind, 82> kCellKinds = {{
    {"empty cell", 0, 0},
    {"vertex", 1, 0},
    {"poly-vertex", 0, 0},
    {"line", 2, 1},
    {"polyline", 0, 1},
    {"triangle", 3, 2},
    {"triangle strip", 0, 2},
    {"polygon", 0, 2},
    {"pixel", 4, 2},
    {"quadrilateral", 4, 2},
    {"tetrahedron", 4, 3},
    {"voxel", 8, 3},
    {"hexahedron", 8, 3},
    {"wedge", 6, 3},
    {"pyramid", 5, 3},
    {"pentagonal prism", 10, 3},
    {"hexagonal prism", 12, 3},
    {"", 0, 3},
    {"", 0, 3},
    {"", 0, 3},
    {"", 0, 3},
    {"quadratic edge", 3, 1},
    {"quadratic triangle", 6, 2},
    {"quadratic quadrilateral", 8, 2},
    {"quadratic tetrahedron", 10, 3},
    {"quadratic hexahedron", 20, 3},
    {"quadratic wedge", 15, 3},
    {"quadratic pyramid", 13, 3},
    {"biquadratic quadrilateral", 9, 2},
    {"triquadratic hexahedron", 27, 3},
    {"quadratic linear quadrilateral", 6, 1},
    {"quadratic linear wedge", 12, 3},
    {"biquadratic quadratic wedge", 18, 3},
    {"biquadratic quadratic hexahedron", 24, 3},
    {"biquadratic triangle", 7, 2},
    {"cubic line", 4, 1},
    {"quadratic polygon", 0, 2},
    {"triquadratic pyramid", 19, 3},
    {"", 0, 3},
    {"", 0, 3},
    {"", 0, 3},
    {"convex point set", 0, 3},
    {"polyhedron", 0, 3},
    {"", 0, 3},
    {"", 0, 3},
    {"", 0, 3},
    {"", 0, 3},
    {"", 0, 3},
    {"", 0, 3},
    {"", 0, 3},
    {"", 0, 3},
    {"parametric curve", 0, 1},
    {"parametric surface", 0, 2},
    {"parametric triangle surface", 0, 2},
    {"parametric quadrilateral surface", 0, 2},
    {"parametric tetrahedral region", 0, 3},
    {"parametric hexahedral region", 0, 3},
    {"", 0, 3},
    {"", 0, 3},
    {"", 0, 3},
    {"higher-order edge", 0, 1},
    {"higher-order triangle", 0, 2},
    {"higher-order quadrilateral", 0, 2},
    {"higher-order polygon", 0, 2},
    {"higher-order tetrahedron", 0, 3},
    {"higher-order wedge", 0, 3},
    {"higher-order pyramid", 0, 3},
    {"higher-order hexahedron", 0, 3},
    {"Lagrange curve", 0, 1},
    {"Lagrange triangle", 0, 2},
    {"Lagrange quadrilateral", 0, 2},
    {"Lagrange tetrahedron", 0, 3},
    {"Lagrange hexahedron", 0, 3},
    {"Lagrange wedge", 0, 3},
    {"Lagrange pyramid", 0, 3},
    {"Bezier curve", 0, 1},
    {"Bezier triangle", 0, 2},
    {"Bezier quadrilateral", 0, 2},
    {"Bezier tetrahedron", 0, 3},
    {"Bezier hexahedron", 0, 3},
    {"Bezier wedge", 0, 3},
    {"Bezier pyramid", 0, 3},
}};

// A face's corners, counter-clockwise seen from outside; -1 ends a triangle.
using Face = std::array<int, 4>;

constexpr std::array<Face, 6> kHexahedronFaces = {
    {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4}, {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}}};
constexpr std::array<int, 8> kHexahedronOpposite = {6, 7, 4, 5, 2, 3, 0, 1};
constexpr std::array<Face, 5> kWedgeFaces = {
    {{0, 1, 2, -1}, {3, 5, 4, -1}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}}};
constexpr std::array<Face, 5> kPyramidFaces = {
    {{0, 3, 2, 1}, {0, 1, 4, -1}, {1, 2, 4, -1}, {2, 3, 4, -1}, {3, 0, 4, -1}}};
constexpr std::array<int, 8> kVoxelToHexahedron = {0, 1, 3, 2, 4, 5, 7, 6};

using CornerTriangle =
    std::array<int, 3>;  // corners of the cell, counter-clockwise seen from outside

bool contains(std::span<const int> corners, int corner) {
  return std::find(corners.begin(), corners.end(), corner) != corners.end();
}

class Splitter {
 public:
  Splitter(std::span<const VertexId> ids, std::span<Tet, 6> out) : ids_(ids), out_(out) {
    apex_ = static_cast<int>(std::min_element(ids.begin(), ids.end()) - ids.begin());
  }

  // The cell is the cone from its smallest vertex, where the diagonals of all faces round it start,
  // over the triangles of the other faces.
  int cone(std::span<const Face> faces) {
    triangulate_far_faces(faces);
    for (int i = 0; i < triangle_count_; ++i) add(triangles_[i], apex_);
    return count_;
  }

  // If no diagonal ends at the corner opposite the smallest one, the three tetrahedra round the
  // long diagonal between them are two: five in all, and none of them thin.
  int hexahedron() {
    triangulate_far_faces(kHexahedronFaces);
    const int far = kHexahedronOpposite[apex_];
    CornerTriangle cap[3];
    int caps = 0;
    for (int i = 0; i < triangle_count_; ++i) {
      if (contains(triangles_[i], far) && ++caps <= 3) cap[caps - 1] = triangles_[i];
    }
    const bool five = caps == 3 && ids_[far] != ids_[apex_];
    for (int i = 0; i < triangle_count_; ++i) {
      if (!five || !contains(triangles_[i], far)) add(triangles_[i], apex_);
    }
    if (five) {
      const CornerTriangle base = link_of(far, cap);
      add(base, apex_);
      add({base[0], base[2], base[1]}, far);
    }
    return count_;
  }

 private:
  void triangulate_far_faces(std::span<const Face> faces) {
    for (const Face& f : faces) {
      if (contains(f, apex_)) continue;
      if (f[3] < 0) {
        triangles_[triangle_count_++] = {f[0], f[1], f[2]};
        continue;
      }
      int s = 0;
      for (int i = 1; i < 4; ++i) {
        if (ids_[f[i]] < ids_[f[s]]) s = i;
      }
      const int a = f[s], b = f[(s + 1) % 4], c = f[(s + 2) % 4], d = f[(s + 3) % 4];
      triangles_[triangle_count_++] = {a, b, c};
      triangles_[triangle_count_++] = {a, c, d};
    }
  }

  // The triangle that bounds three triangles round `corner`, wound like them.
  static CornerTriangle link_of(int corner, const CornerTriangle (&round)[3]) {
    int next[8] = {};
    int start = 0;
    for (const CornerTriangle& t : round) {
      int i = 0;
      while (t[i] != corner) ++i;
      start = t[(i + 1) % 3];
      next[start] = t[(i + 2) % 3];
    }
    return {start, next[start], next[next[start]]};
  }

  // The tetrahedron between `corner` and a triangle that it sees from inside.
  void add(const CornerTriangle& t, int corner) {
    const Tet tet = {ids_[t[0]], ids_[t[2]], ids_[t[1]], ids_[corner]};
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) {
        if (tet[i] == tet[j]) return;
      }
    }
    out_[count_++] = tet;
  }

  std::span<const VertexId> ids_;
  std::span<Tet, 6> out_;
  int apex_;
  CornerTriangle triangles_[6];
  int triangle_count_ = 0;
  int count_ = 0;
};

}  // namespace

bool is_splittable(std::uint8_t vtk_type) {
  return vtk_type >= kVtkTetra && vtk_type <= kVtkPyramid;
}

std::string_view vtk_cell_name(std::uint8_t vtk_type) {
  const bool known = vtk_type < kCellKinds.size() && !kCellKinds[vtk_type].name.empty();
  return known ? kCellKinds[vtk_type].name : "unknown cell";
}

int vtk_cell_size(std::uint8_t vtk_type) {
  return vtk_type < kCellKinds.size() ? kCellKinds[vtk_type].size : 0;
}

int vtk_cell_dimension(std::uint8_t vtk_type) {
  return vtk_type < kCellKinds.size() ? kCellKinds[vtk_type].dimension : 3;
}

int split_cell(std::uint8_t vtk_type, std::span<const VertexId> ids, std::span<Tet, 6> out) {
  switch (vtk_type) {
    case kVtkTetra: {
      // The tetrahedron is the cone from its last vertex over the first three.
      const Tet tet = {ids[0], ids[1], ids[2], ids[3]};
      Tet sorted = tet;
      std::sort(sorted.begin(), sorted.end());
      if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) return 0;
      out[0] = tet;
      return 1;
    }
    case kVtkVoxel: {
      std::array<VertexId, 8> hexahedron;
      for (int i = 0; i < 8; ++i) hexahedron[i] = ids[kVoxelToHexahedron[i]];
      return Splitter(hexahedron, out).hexahedron();
    }
    case kVtkHexahedron:
      return Splitter(ids, out).hexahedron();
    case kVtkWedge:
      return Splitter(ids, out).cone(kWedgeFaces);
    case kVtkPyramid:
      return Splitter(ids, out).cone(kPyramidFaces);
    default:
      return 0;
  }
}

}  // namespace tetfusion
