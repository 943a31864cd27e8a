// Voxels, hexahedra, wedges and pyramids as tetrahedra, and what VTK calls its cell types.
//
// Each quadrilateral face is cut by the diagonal at its smallest vertex id, so that two cells that
// share a face cut it alike, whatever their kind, their place in the file and the order of their
// vertices: the tetrahedra of a conforming mesh conform (Dompierre, Labbe, Vallet, Camarero 1999,
// "How to subdivide pyramids, prisms and hexahedra into tetrahedra"). No vertex is added.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "mesh/geometry.h"

namespace tetfusion {

// Of any kind; what one thread takes at a time.
inline constexpr std::size_t kCellsPerBlock = 65536;

// VTK's cell types that the project knows by name.
enum VtkCellType : std::uint8_t {
  kVtkEmptyCell = 0,
  kVtkVertex = 1,
  kVtkLine = 3,
  kVtkTriangle = 5,
  kVtkPolygon = 7,
  kVtkPixel = 8,
  kVtkQuad = 9,
  kVtkTetra = 10,
  kVtkVoxel = 11,
  kVtkHexahedron = 12,
  kVtkWedge = 13,
  kVtkPyramid = 14,
  kVtkPentagonalPrism = 15,
  kVtkHexagonalPrism = 16,
  kVtkQuadraticEdge = 21,
  kVtkQuadraticTriangle = 22,
  kVtkQuadraticQuad = 23,
  kVtkQuadraticTetra = 24,
  kVtkQuadraticHexahedron = 25,
  kVtkQuadraticWedge = 26,
  kVtkQuadraticPyramid = 27,
  kVtkBiquadraticQuad = 28,
  kVtkTriquadraticHexahedron = 29,
  kVtkQuadraticLinearQuad = 30,
  kVtkQuadraticLinearWedge = 31,
  kVtkBiquadraticQuadraticWedge = 32,
  kVtkBiquadraticQuadraticHexahedron = 33,
  kVtkBiquadraticTriangle = 34,
  kVtkCubicLine = 35,
  kVtkTriquadraticPyramid = 37,
  kVtkConvexPointSet = 41,
  kVtkPolyhedron = 42,
  kVtkLagrangeCurve = 68,
  kVtkLagrangeTriangle = 69,
  kVtkLagrangeQuad = 70,
  kVtkLagrangeTetra = 71,
  kVtkLagrangeHexahedron = 72,
  kVtkLagrangeWedge = 73,
  kVtkLagrangePyramid = 74,
  kVtkBezierCurve = 75,
  kVtkBezierTriangle = 76,
  kVtkBezierQuad = 77,
  kVtkBezierTetra = 78,
  kVtkBezierHexahedron = 79,
  kVtkBezierWedge = 80,
  kVtkBezierPyramid = 81
};

// True for the types that split_cell takes: 10 to 14.
bool is_splittable(std::uint8_t vtk_type);

// "hexahedron", "quadratic tetrahedron", ...; "unknown cell" for numbers that VTK does not use.
std::string_view vtk_cell_name(std::uint8_t vtk_type);

// Points of a cell of that type; 0 where the type does not say (polygons, strips, Lagrange and
// Bezier cells, ...) and for numbers that VTK does not use.
int vtk_cell_size(std::uint8_t vtk_type);

// 0 to 3; 3 for numbers that VTK does not use, and 0 for the empty cell.
int vtk_cell_dimension(std::uint8_t vtk_type);

// Writes the tetrahedra of one cell to `out` and returns their number: 1 for a tetrahedron, 2 for a
// pyramid, 3 for a wedge, 5 or 6 for a hexahedron or voxel, 0 for other types. They are positively
// wound if the cell is convex and wound as VTK documents it (a wedge's triangle (0, 1, 2) faces
// away from (3, 4, 5)); the tetrahedra of a mirrored cell are all negative.
//
// A cell may name a vertex more than once (a hexahedron collapsed to a wedge): tetrahedra that
// would do so are left out and not counted. REQUIRES: ids.size() == vtk_cell_size(vtk_type).
int split_cell(std::uint8_t vtk_type, std::span<const VertexId> ids, std::span<Tet, 6> out);

}  // namespace tetfusion
