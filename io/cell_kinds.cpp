#include "io/cell_kinds.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

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
  if (!is_lagrange(type)) return type;
  const std::array<std::uint8_t, 2> kinds =
      type == kVtkLagrangeCurve ? std::array<std::uint8_t, 2>{kVtkLine, kVtkQuadraticEdge}
      : type == kVtkLagrangeTriangle
          ? std::array<std::uint8_t, 2>{kVtkTriangle, kVtkQuadraticTriangle}
          : std::array<std::uint8_t, 2>{kVtkTetra, kVtkQuadraticTetra};
  for (const std::uint8_t kind : kinds) {
    if (vertices == static_cast<std::uint64_t>(vtk_cell_size(kind))) return kind;
  }
  return type;
}

std::uint8_t linear_type(std::uint8_t type) {
  switch (type) {
    case kVtkQuadraticEdge:
      return kVtkLine;
    case kVtkQuadraticTriangle:
      return kVtkTriangle;
    case kVtkQuadraticTetra:
      return kVtkTetra;
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

int kept_vertices(std::uint8_t type, const OpenOptions& options) {
  const std::uint8_t linear = linear_type(type);
  if (linear != type) return options.linearize ? vtk_cell_size(linear) : -1;
  if (is_cut(type)) return options.tetrahedralize ? vtk_cell_size(type) : -1;
  const bool read =
      type == kVtkVertex || type == kVtkLine || type == kVtkTriangle || type == kVtkTetra;
  return read ? vtk_cell_size(type) : -1;
}

void unmark_global_ids(const OpenOptions& options, AttributeSet* cell_data) {
  if (!options.tetrahedralize) return;
  const auto ids = cell_data->active.extract("GlobalIds");
  if (ids) cell_data->active.try_emplace("PedigreeIds", ids.mapped());
}

std::string refusal(std::uint8_t type) {
  std::string advice =
      ", which cannot be read: only tetrahedra, and vertices, lines and triangles beside them";
  if (linear_type(type) != type) {
    advice = ": use --linearize to drop the mid-edge nodes of such cells";
  } else if (is_cut(type)) {
    advice = ": use --tetrahedralize to split such cells";
  } else if (is_lagrange(type)) {
    advice += ", and of Lagrange cells those of first order, or with --linearize of second";
  } else if (type == kVtkConvexPointSet || type == kVtkPolyhedron) {
    advice += "; ParaView's filter Tetrahedralize makes tetrahedra of such cells";
  }
  return "is " + with_article(type) + advice;
}

std::string wrong_vertex_count(std::uint8_t type, std::uint64_t count) {
  return "has " + std::to_string(count) + " vertices, expected " +
         std::to_string(vtk_cell_size(type)) + " for " + with_article(type);
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
