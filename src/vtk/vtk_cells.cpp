#include "vtk/vtk_cells.h"

#include <vtkDataSetAttributes.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkTetra.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "base/error.h"
#include "io/source/cell_kinds.h"
#include "io/source/file_cells.h"
#include "io/source/merge_pieces.h"
#include "mesh/polygon_cut.h"
#include "mesh/split_cells.h"
#include "vtk/vtk_polyhedra.h"

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
    const bool merges = options_.merge_points;  // whatever their ids
    if (begins.size() <= 2 && !merges) return use;
    const auto ids = merges ? std::vector<std::int64_t>() : global_point_ids(list_);
    const Points points = all_points(list_);
    use.copy_of = match_points({&points, begins, ids, merges}, without_centres(use.used));
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
  using Position = std::array<double, 3>;

  // Calls f(linear type, cell) for each cell that stays, its corners in corners_: checked, counted
  // through all pieces, mid-edge nodes left out.
  template <class F>
  void for_each_cell(F f) {
    vtkNew<vtkIdList> ids;
    for (const Piece& piece : list_.pieces) {
      vtkUnsignedCharArray* const ghosts = ghosts_of(piece.data);
      const auto cells = static_cast<vtkIdType>(piece.cells());
      // Structured data call cells "empty" that they blank.
      const bool may_be_blank = vtkUnstructuredGrid::SafeDownCast(piece.data) == nullptr;
      for (vtkIdType c = 0; c < cells; ++c) {
        const std::uint64_t cell = piece.first_cell + static_cast<std::uint64_t>(c);
        auto type = static_cast<std::uint8_t>(piece.data->GetCellType(c));
        if ((may_be_blank && type == kVtkEmptyCell) || is_dropped(ghosts, c)) {
          ++out_.ghost_cells;
          continue;
        }
        piece.data->GetCellPoints(c, ids);
        type = settled_type(type, static_cast<std::uint64_t>(ids->GetNumberOfIds()));
        if (is_dropped_patch(type, options_)) continue;
        if (type == kVtkPolyhedron && has_centre(piece, c)) {
          take_faces(piece, c, cell, ids);
        } else if (type == kVtkPolygon && options_.tetrahedralize) {
          take_corners(piece, cell, ids->GetNumberOfIds(), ids);
        } else {
          const int kept = kept_vertices(type, options_);
          if (kept < 0) fail(cell, refusal(type, options_));
          const auto count = static_cast<std::uint64_t>(ids->GetNumberOfIds());
          if (!may_have_vertices(type, count)) fail(cell, wrong_vertex_count(type, count));
          take_corners(piece, cell, kept, ids);
        }
        f(linear_type(type), cell);
      }
    }
  }

  // They are nobody's copies, whatever ids they have.
  Vector<std::uint8_t> without_centres(Vector<std::uint8_t> used) const {
    for (const Piece& piece : list_.pieces) {
      for (const vtkIdType centre : piece.centres) {
        if (centre >= 0) used[piece.first_point + static_cast<std::uint64_t>(centre)] = 0;
      }
    }
    return used;
  }

  static bool has_centre(const Piece& piece, vtkIdType c) {
    return !piece.centres.empty() && piece.centres[static_cast<std::size_t>(c)] >= 0;
  }

  VertexId checked(const Piece& piece, std::uint64_t cell, vtkIdType id) const {
    if (id < 0 || static_cast<std::uint64_t>(id) >= piece.points()) {
      throw InvalidMesh(name_of(cell) + wrong_vertex(std::to_string(id), piece.points()));
    }
    return static_cast<VertexId>(piece.first_point + static_cast<std::uint64_t>(id));
  }

  void take_corners(const Piece& piece, std::uint64_t cell, vtkIdType kept, vtkIdList* ids) {
    corners_.resize(static_cast<std::size_t>(kept));
    for (vtkIdType i = 0; i < ids->GetNumberOfIds(); ++i) {
      const VertexId point = checked(piece, cell, ids->GetId(i));
      if (i < kept) corners_[static_cast<std::size_t>(i)] = point;
    }
  }

  // The vertices of face after face, and the cell's centre.
  void take_faces(const Piece& piece, vtkIdType c, std::uint64_t cell, vtkIdList* stream) {
    corners_.clear();
    face_sizes_.clear();
    auto* const grid = vtkUnstructuredGrid::SafeDownCast(piece.data);
    for_each_face(grid, c, stream, [&](std::span<const vtkIdType> face) {
      for (const vtkIdType id : face) corners_.push_back(checked(piece, cell, id));
      face_sizes_.push_back(face.size());
    });
    corners_.push_back(checked(piece, cell, piece.centres[static_cast<std::size_t>(c)]));
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
      case kVtkPolygon:
        for (const auto& triangle : cut(c)) add_lower(kVtkTriangle, triangle, cell);
        return;
      case kVtkPolyhedron:
        return add_polyhedron(cell);
      case kVtkTetra:
        return add_tet({c[0], c[1], c[2], c[3]}, cell);
      default: {
        std::array<Tet, 6> tets;
        const auto count = static_cast<std::size_t>(split_cell(type, c, tets));
        if (type == kVtkWedge) wind({tets.data(), count});
        for (std::size_t i = 0; i < count; ++i) add_tet(tets[i], cell);
      }
    }
  }

  void add_tet(const Tet& tet, std::uint64_t cell) {
    if (out_.tets.size() == kMaxTets) fail_too_many_tets(path_, kMaxTets + std::uint64_t{1});
    out_.tets.push_back(tet);
    out_.tet_source.push_back(cell);
  }

  // VTK sees a wedge's first triangle from outside, Exodus and CGNS from inside: VTK's readers
  // leave it so, and files that its writer made have it the other way.
  void wind(std::span<Tet> tets) const {
    double volume = 0;
    for (const Tet& tet : tets) {
      std::array<Position, 4> at{};
      for (std::size_t i = 0; i < at.size(); ++i) at[i] = position(tet[i]);
      volume += vtkTetra::ComputeVolume(at[0].data(), at[1].data(), at[2].data(), at[3].data());
    }
    if (volume >= 0) return;
    for (Tet& tet : tets) std::swap(tet[2], tet[3]);
  }

  // Not all files list a face's vertices counter-clockwise, seen from outside.
  void add_polyhedron(std::uint64_t cell) {
    Corners left = corners_;
    const VertexId centre = left.back();
    for (const std::size_t size : face_sizes_) {
      for (const auto& [a, b, c] : cut(left.first(size))) {
        Position at_a = position(a), at_b = position(b), at_c = position(c), top = position(centre);
        const bool is_wound_so =
            vtkTetra::ComputeVolume(at_a.data(), at_b.data(), at_c.data(), top.data()) > 0;
        add_tet(is_wound_so ? Tet{a, b, c, centre} : Tet{a, c, b, centre}, cell);
      }
      left = left.subspan(size);
    }
  }

  std::span<const std::array<VertexId, 3>> cut(Corners polygon) {
    positions_.clear();
    for (const VertexId v : polygon) {
      const auto [x, y, z] = position(v);
      positions_.push_back({x, y, z});
    }
    return polygon_cut_.cut(polygon, positions_);
  }

  Position position(VertexId v) const {
    return std::visit(
        [&](const auto& points) {
          return Position{points[v].x, points[v].y, points[v].z};
        },
        out_.points);
  }

  void add_lower(std::uint8_t type, Corners corners, std::uint64_t cell) {
    out_.lower.add(type, corners);
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
  std::vector<std::size_t> face_sizes_;
  std::vector<Vec3<double>> positions_;
  PolygonCut polygon_cut_;
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
