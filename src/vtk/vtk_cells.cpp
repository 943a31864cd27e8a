#include "vtk/vtk_cells.h"

#include <vtkDataSetAttributes.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <variant>

#include "base/error.h"
#include "io/merge_pieces.h"
#include "mesh/split_cells.h"

namespace tetfusion {
namespace {

// Cells of another rank's piece, cells that a refinement replaced, and blanked cells.
constexpr int kDroppedCells = vtkDataSetAttributes::DUPLICATECELL |
                              vtkDataSetAttributes::REFINEDCELL | vtkDataSetAttributes::HIDDENCELL;

class CellConverter {
 public:
  CellConverter(const std::string& path, const PieceList& list, const OpenOptions& options)
      : path_(path), list_(list), options_(options) {}

  Geometry convert() {
    Vector<std::uint8_t> used(list_.points, std::uint8_t{0});
    for_each_cell([&](std::uint8_t, std::uint64_t) {
      for (const VertexId v : corners_) used[v] = 1;
    });
    out_.points = all_points(list_);
    // Numbers first, cells afterwards: the ids that decide on diagonals are those that stay.
    const Vector<VertexId> number = compact_points(used, find_copies(used), &out_);
    check_finite();
    out_.ghost_cells = 0;
    for_each_cell([&](std::uint8_t type, std::uint64_t cell) {
      if (!number.empty()) {
        for (VertexId& v : corners_) v = number[v];
      }
      add(type, cell);
    });
    if (out_.tets.empty()) {
      throw Error(ErrorCode::kBadInput,
                  path_ + ": has no tetrahedra (" + std::to_string(list_.cells) + " cells in all)");
    }
    drop_identity(&out_.tet_source);
    return std::move(out_);
  }

 private:
  using Corners = std::span<const VertexId>;

  // Calls f(type, cell) for each cell that stays, its vertices in corners_: checked, counted
  // through all pieces, mid-edge nodes left out.
  template <class F>
  void for_each_cell(F f) {
    vtkNew<vtkIdList> ids;
    for (const Piece& piece : list_.pieces) {
      vtkUnsignedCharArray* ghosts = piece.data->GetCellGhostArray();
      const auto cells = static_cast<vtkIdType>(piece.cells());
      if (ghosts != nullptr && ghosts->GetNumberOfTuples() != cells) ghosts = nullptr;
      for (vtkIdType c = 0; c < cells; ++c) {
        const std::uint64_t cell = piece.first_cell + static_cast<std::uint64_t>(c);
        const auto type = static_cast<std::uint8_t>(piece.data->GetCellType(c));
        // Structured data call cells "empty" that they blank.
        if (type == kVtkEmptyCell ||
            (ghosts != nullptr && (ghosts->GetValue(c) & kDroppedCells) != 0)) {
          ++out_.ghost_cells;
          continue;
        }
        const int kept = kept_vertices(type, cell);
        piece.data->GetCellPoints(c, ids);
        take_corners(piece, type, cell, kept, ids);
        f(type, cell);
      }
    }
  }

  void take_corners(const Piece& piece, std::uint8_t type, std::uint64_t cell, int kept,
                    vtkIdList* ids) {
    if (ids->GetNumberOfIds() != vtk_cell_size(type)) {
      fail(type, cell,
           "has " + std::to_string(ids->GetNumberOfIds()) + " points, not " +
               std::to_string(vtk_cell_size(type)));
    }
    corners_.resize(static_cast<std::size_t>(kept));
    for (int i = 0; i < ids->GetNumberOfIds(); ++i) {
      const vtkIdType id = ids->GetId(i);
      if (id < 0 || static_cast<std::uint64_t>(id) >= piece.points()) {
        fail(type, cell,
             "uses point " + std::to_string(id) + ", but there are " +
                 std::to_string(piece.points()));
      }
      const std::uint64_t point = piece.first_point + static_cast<std::uint64_t>(id);
      if (i < kept) corners_[static_cast<std::size_t>(i)] = static_cast<VertexId>(point);
    }
  }

  // How many of a cell's vertices stay, from the first on, if the options allow the type.
  int kept_vertices(std::uint8_t type, std::uint64_t cell) const {
    switch (type) {
      case kVtkVertex:
      case kVtkLine:
      case kVtkTriangle:
      case kVtkTetra:
        break;
      case kVtkPixel:
      case kVtkQuad:
      case kVtkVoxel:
      case kVtkHexahedron:
      case kVtkWedge:
      case kVtkPyramid:
        if (!options_.tetrahedralize) {
          fail(type, cell, "is no tetrahedron: use --tetrahedralize to split such cells");
        }
        break;
      case kVtkQuadraticEdge:
      case kVtkQuadraticTriangle:
      case kVtkQuadraticTetra:
        if (!options_.linearize) {
          fail(type, cell, "is curved: use --linearize to drop its mid-edge nodes");
        }
        return type == kVtkQuadraticEdge ? 2 : type == kVtkQuadraticTriangle ? 3 : 4;
      default:
        fail(type, cell, "cannot be made into tetrahedra");
    }
    return vtk_cell_size(type);
  }

  void add(std::uint8_t type, std::uint64_t cell) {
    const Corners c = corners_;
    switch (type) {
      case kVtkVertex:
      case kVtkLine:
      case kVtkTriangle:
        return add_lower(type, c, cell);
      case kVtkQuadraticEdge:
        return add_lower(kVtkLine, c, cell);
      case kVtkQuadraticTriangle:
        return add_lower(kVtkTriangle, c, cell);
      case kVtkPixel:
        return add_quadrilateral({c[0], c[1], c[3], c[2]}, cell);
      case kVtkQuad:
        return add_quadrilateral({c[0], c[1], c[2], c[3]}, cell);
      case kVtkTetra:
      case kVtkQuadraticTetra:
        return add_tet({c[0], c[1], c[2], c[3]}, cell);
      default: {
        std::array<Tet, 6> tets;
        const int count = split_cell(type, c, tets);
        for (int i = 0; i < count; ++i) add_tet(tets[i], cell);
      }
    }
  }

  void add_tet(const Tet& tet, std::uint64_t cell) {
    if (out_.tets.size() == kMaxTets) {
      throw Error(ErrorCode::kBadInput, path_ + ": has more than " + std::to_string(kMaxTets) +
                                            " tetrahedra, which is as many as are possible");
    }
    out_.tets.push_back(tet);
    out_.tet_source.push_back(cell);
  }

  void add_lower(std::uint8_t type, Corners corners, std::uint64_t cell) {
    LowerCells& lower = out_.lower;
    if (lower.offsets.empty()) lower.offsets.push_back(0);
    lower.types.push_back(type);
    lower.connectivity.insert(lower.connectivity.end(), corners.begin(), corners.end());
    lower.offsets.push_back(lower.connectivity.size());
    out_.lower_source.push_back(cell);
  }

  // Cut like the face of a split cell, so that it stays one.
  void add_quadrilateral(const std::array<VertexId, 4>& q, std::uint64_t cell) {
    const auto s = static_cast<std::size_t>(std::min_element(q.begin(), q.end()) - q.begin());
    const VertexId a = q[s], b = q[(s + 1) % 4], c = q[(s + 2) % 4], d = q[(s + 3) % 4];
    for (const std::array<VertexId, 3>& t : {std::array{a, b, c}, std::array{a, c, d}}) {
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) add_lower(kVtkTriangle, t, cell);
    }
  }

  // For each used point the one that it is a copy of; empty if only one piece brings points.
  Vector<VertexId> find_copies(const Vector<std::uint8_t>& used) const {
    const auto begins = point_begins(list_);
    if (begins.size() <= 2) return {};
    const auto ids = global_point_ids(list_);
    return match_points({&out_.points, begins, ids}, used);
  }

  // An identity is not worth its memory.
  static void drop_identity(Vector<std::uint64_t>* source) {
    for (std::size_t i = 0; i < source->size(); ++i) {
      if ((*source)[i] != i) return;
    }
    *source = {};
  }

  void check_finite() const {
    const auto& source = out_.point_source;
    std::visit(
        [&](const auto& points) {
          for (std::size_t i = 0; i < points.size(); ++i) {
            const auto& p = points[i];
            if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) continue;
            throw Error(ErrorCode::kBadInput, path_ + ": point " +
                                                  std::to_string(source.empty() ? i : source[i]) +
                                                  " has a coordinate that is not finite");
          }
        },
        out_.points);
  }

  [[noreturn]] void fail(std::uint8_t type, std::uint64_t cell, const std::string& what) const {
    throw Error(ErrorCode::kBadInput, path_ + ": cell " + std::to_string(cell) + ", a " +
                                          std::string(vtk_cell_name(type)) + " (VTK type " +
                                          std::to_string(type) + "), " + what);
  }

  const std::string& path_;
  const PieceList& list_;
  const OpenOptions& options_;
  Vector<VertexId> corners_;  // of the cell at hand
  Geometry out_;
};

}  // namespace

Geometry convert_cells(const std::string& path, const PieceList& list, const OpenOptions& options) {
  return CellConverter(path, list, options).convert();
}

}  // namespace tetfusion
