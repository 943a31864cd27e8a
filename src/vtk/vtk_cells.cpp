#include "vtk/vtk_cells.h"

#include <vtkDataSetAttributes.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <variant>

#include "base/error.h"
#include "io/cell_kinds.h"
#include "io/merge_pieces.h"
#include "io/vtu_cells.h"
#include "mesh/split_cells.h"

namespace tetfusion {
namespace {

static_assert(kGhostCopy == vtkDataSetAttributes::DUPLICATECELL &&
              kGhostRefined == vtkDataSetAttributes::REFINEDCELL &&
              kGhostHidden == vtkDataSetAttributes::HIDDENCELL);

class CellConverter {
 public:
  CellConverter(const std::string& path, const PieceList& list, const OpenOptions& options)
      : path_(path), list_(list), options_(options) {}

  PointUse find_point_use() {
    PointUse use;
    use.used.assign(list_.points, std::uint8_t{0});
    for_each_cell([&](std::uint8_t, std::uint64_t) {
      for (const VertexId v : corners_) use.used[v] = 1;
    });
    const auto begins = point_begins(list_);
    if (begins.size() <= 2) return use;
    const auto ids = global_point_ids(list_);
    const Points points = ids.empty() ? all_points(list_) : Points();
    use.copy_of = match_points({&points, begins, ids}, use.used);
    return use;
  }

  Geometry convert(const PointUse& use) {
    out_.points = all_points(list_);
    // Numbers first, cells afterwards: the ids that decide on diagonals are those that stay.
    const Vector<VertexId> number = compact_points(use.used, use.copy_of, &out_);
    check_finite();
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

  // Calls f(linear type, cell) for each cell that stays, its corners in corners_: checked, counted
  // through all pieces, mid-edge nodes left out.
  template <class F>
  void for_each_cell(F f) {
    vtkNew<vtkIdList> ids;
    for (const Piece& piece : list_.pieces) {
      vtkUnsignedCharArray* ghosts = piece.data->GetCellGhostArray();
      const auto cells = static_cast<vtkIdType>(piece.cells());
      if (ghosts != nullptr && ghosts->GetNumberOfTuples() != cells) ghosts = nullptr;
      // Structured data call cells "empty" that they blank.
      const bool may_be_blank = vtkUnstructuredGrid::SafeDownCast(piece.data) == nullptr;
      for (vtkIdType c = 0; c < cells; ++c) {
        const std::uint64_t cell = piece.first_cell + static_cast<std::uint64_t>(c);
        auto type = static_cast<std::uint8_t>(piece.data->GetCellType(c));
        if ((may_be_blank && type == kVtkEmptyCell) ||
            (ghosts != nullptr && (ghosts->GetValue(c) & kGhostDropped) != 0)) {
          ++out_.ghost_cells;
          continue;
        }
        piece.data->GetCellPoints(c, ids);
        type = settled_type(type, static_cast<std::uint64_t>(ids->GetNumberOfIds()));
        const int kept = kept_vertices(type, options_);
        if (kept < 0) fail(cell, refusal(type));
        take_corners(piece, type, cell, kept, ids);
        f(linear_type(type), cell);
      }
    }
  }

  void take_corners(const Piece& piece, std::uint8_t type, std::uint64_t cell, int kept,
                    vtkIdList* ids) {
    const auto count = static_cast<std::uint64_t>(ids->GetNumberOfIds());
    if (!may_have_vertices(type, count)) fail(cell, wrong_vertex_count(type, count));
    corners_.resize(static_cast<std::size_t>(kept));
    for (int i = 0; i < ids->GetNumberOfIds(); ++i) {
      const vtkIdType id = ids->GetId(i);
      if (id < 0 || static_cast<std::uint64_t>(id) >= piece.points()) {
        throw InvalidMesh(name_of(cell) + wrong_vertex(std::to_string(id), piece.points()));
      }
      const std::uint64_t point = piece.first_point + static_cast<std::uint64_t>(id);
      if (i < kept) corners_[static_cast<std::size_t>(i)] = static_cast<VertexId>(point);
    }
  }

  void add(std::uint8_t type, std::uint64_t cell) {
    const Corners c = corners_;
    switch (type) {
      case kVtkVertex:
      case kVtkLine:
      case kVtkTriangle:
        return add_lower(type, c, cell);
      case kVtkPixel:
      case kVtkQuad:
        return add_quadrilateral(type, {c[0], c[1], c[2], c[3]}, cell);
      case kVtkTetra:
        return add_tet({c[0], c[1], c[2], c[3]}, cell);
      default: {
        std::array<Tet, 6> tets;
        const int count = split_cell(type, c, tets);
        for (int i = 0; i < count; ++i) add_tet(tets[i], cell);
      }
    }
  }

  void add_tet(const Tet& tet, std::uint64_t cell) {
    if (out_.tets.size() == kMaxTets) fail_too_many_tets(path_, kMaxTets + std::uint64_t{1});
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

  void add_quadrilateral(std::uint8_t type, const std::array<VertexId, 4>& ids,
                         std::uint64_t cell) {
    std::array<std::array<VertexId, 3>, 2> triangles{};
    const int count = split_quadrilateral(type, ids, &triangles);
    for (int i = 0; i < count; ++i) {
      add_lower(kVtkTriangle, triangles[static_cast<std::size_t>(i)], cell);
    }
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
            throw InvalidMesh(path_ + ": point " + std::to_string(source.empty() ? i : source[i]) +
                              " has a coordinate that is not finite");
          }
        },
        out_.points);
  }

  std::string name_of(std::uint64_t cell) const {
    return path_ + ": cell " + std::to_string(cell) + " ";
  }
  [[noreturn]] void fail(std::uint64_t cell, const std::string& what) const {
    throw Error(ErrorCode::kBadInput, name_of(cell) + what);
  }

  const std::string& path_;
  const PieceList& list_;
  const OpenOptions& options_;
  Vector<VertexId> corners_;  // of the cell at hand
  Geometry out_;
};

}  // namespace

PointUse find_point_use(const std::string& path, const PieceList& list,
                        const OpenOptions& options) {
  return CellConverter(path, list, options).find_point_use();
}

Geometry convert_cells(const std::string& path, const PieceList& list, const OpenOptions& options,
                       const PointUse& use) {
  return CellConverter(path, list, options).convert(use);
}

}  // namespace tetfusion
