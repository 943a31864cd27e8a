#include "io/source/cell_kinds.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "base/numbers.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

bool is_cut(std::uint8_t type) {
  return type == kVtkQuad || type == kVtkPixel || (type != kVtkTetra && is_splittable(type));
}

std::string with_article(std::uint8_t type) {
  const std::string name(vtk_cell_name(type));
  const bool vowel = std::string("aeiou").find(name[0]) != std::string::npos;
  return (vowel ? "an " : "a ") + name + " (VTK cell type " + std::to_string(type) + ")";
}

}  // namespace

std::uint8_t settled_type(std::uint8_t type, std::uint64_t vertices) {
  return is_of_any_order(type) && vertices == corners_of(type) ? linear_type(type) : type;
}

std::uint8_t linear_type(std::uint8_t type) {
  switch (type) {
    case kVtkQuadraticEdge:
    case kVtkCubicLine:
    case kVtkLagrangeCurve:
    case kVtkBezierCurve:
      return kVtkLine;
    case kVtkQuadraticTriangle:
    case kVtkBiquadraticTriangle:
    case kVtkLagrangeTriangle:
    case kVtkBezierTriangle:
      return kVtkTriangle;
    case kVtkQuadraticQuad:
    case kVtkBiquadraticQuad:
    case kVtkQuadraticLinearQuad:
    case kVtkLagrangeQuad:
    case kVtkBezierQuad:
      return kVtkQuad;
    case kVtkQuadraticTetra:
    case kVtkLagrangeTetra:
    case kVtkBezierTetra:
      return kVtkTetra;
    case kVtkQuadraticHexahedron:
    case kVtkTriquadraticHexahedron:
    case kVtkBiquadraticQuadraticHexahedron:
    case kVtkLagrangeHexahedron:
    case kVtkBezierHexahedron:
      return kVtkHexahedron;
    case kVtkQuadraticWedge:
    case kVtkQuadraticLinearWedge:
    case kVtkBiquadraticQuadraticWedge:
    case kVtkLagrangeWedge:
    case kVtkBezierWedge:
      return kVtkWedge;
    case kVtkQuadraticPyramid:
    case kVtkTriquadraticPyramid:
    case kVtkLagrangePyramid:
    case kVtkBezierPyramid:
      return kVtkPyramid;
    default:
      return type;
  }
}

void forget_ghosts(Association association, const ArrayInfo& info, std::span<std::byte> values) {
  if (info.name == "vtkGhostLevels") {
    std::fill(values.begin(), values.end(), std::byte{0});
  } else if (info.name == "vtkGhostType" && info.type == ValueType::kUInt8) {
    const auto gone =
        static_cast<std::byte>(association == Association::kCell ? kGhostDropped : kGhostCopy);
    for (std::byte& flags : values) flags &= ~gone;
  }
}

bool is_dropped_patch(std::uint8_t type, const OpenOptions& options) {
  return options.drop_patches && vtk_cell_dimension(type) < 3;
}

void leave_out_patches(const OpenOptions& options, std::span<std::uint8_t> types) {
  if (!options.drop_patches) return;
  for (std::uint8_t& type : types) {
    if (is_dropped_patch(type, options)) type = kLeftOut;
  }
}

int kept_vertices(std::uint8_t type, const OpenOptions& options) {
  if (type == kLeftOut || is_dropped_patch(type, options)) return 0;
  const std::uint8_t linear = linear_type(type);
  if (linear != type && !options.linearize) return -1;
  if (is_cut(linear)) return options.tetrahedralize ? vtk_cell_size(linear) : -1;
  const bool read =
      linear == kVtkVertex || linear == kVtkLine || linear == kVtkTriangle || linear == kVtkTetra;
  return read ? vtk_cell_size(linear) : -1;
}

bool may_have_vertices(std::uint8_t type, std::uint64_t count) {
  return is_of_any_order(type) ? count > corners_of(type)
                               : count == static_cast<std::uint64_t>(vtk_cell_size(type));
}

void unmark_global_ids(const OpenOptions& options, AttributeSet* cell_data) {
  if (!options.tetrahedralize) return;
  const auto ids = cell_data->active.extract("GlobalIds");
  if (ids) cell_data->active.try_emplace("PedigreeIds", ids.mapped());
}

std::string refusal(std::uint8_t type, const OpenOptions& options, bool is_in_memory) {
  const std::uint8_t linear = linear_type(type);
  const bool is_split_by_vtk = !is_in_memory && (type == kVtkPolyhedron || type == kVtkPolygon);
  std::string advice =
      ", which cannot be read: only tetrahedra, and vertices, lines and triangles beside them";
  if (vtk_cell_dimension(type) < 3) advice += "; --drop-patches leaves such cells out";
  if (linear != type && is_cut(linear)) {
    advice =
        ": use --linearize and --tetrahedralize to keep no more than the corners of such cells, "
        "and split them";
  } else if (linear != type) {
    advice = ": use --linearize to keep no more than the corners of such cells";
  } else if (is_cut(type) || (is_split_by_vtk && !options.tetrahedralize)) {
    advice = ": use --tetrahedralize to split such cells";
  } else if (type == kVtkConvexPointSet || type == kVtkPolyhedron || type == kVtkPentagonalPrism ||
             type == kVtkHexagonalPrism) {
    advice += "; ParaView's filter Tetrahedralize makes tetrahedra of such cells";
  }
  return "is " + with_article(type) + advice;
}

std::string wrong_vertex_count(std::uint8_t type, std::uint64_t count) {
  const std::string expected = is_of_any_order(type) ? std::to_string(corners_of(type)) + " or more"
                                                     : std::to_string(vtk_cell_size(type));
  return "has " + format_count(count, "vertex", "vertices") + ", expected " + expected + " for " +
         with_article(type);
}

std::string wrong_vertex(const std::string& id, std::uint64_t points) {
  return "uses point " + id + ", but there are " + std::to_string(points) + " points";
}

int split_quadrilateral(std::uint8_t type, std::array<VertexId, 4> ids,
                        std::array<std::array<VertexId, 3>, 2>* out) {
  if (type == kVtkPixel) std::swap(ids[2], ids[3]);  // a pixel's go in rows, not round it
  const auto s = static_cast<std::size_t>(std::min_element(ids.begin(), ids.end()) - ids.begin());
  const VertexId a = ids[s], b = ids[(s + 1) % 4], c = ids[(s + 2) % 4], d = ids[(s + 3) % 4];
  std::size_t count = 0;
  for (const std::array<VertexId, 3>& t : {std::array{a, b, c}, std::array{a, c, d}}) {
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) (*out)[count++] = t;
  }
  return static_cast<int>(count);
}

}  // namespace tetfusion
