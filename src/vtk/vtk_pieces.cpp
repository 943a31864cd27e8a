#include "vtk/vtk_pieces.h"

#include <vtkCellArray.h>
#include <vtkDataArray.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>
#include <vtkPoints.h>
#include <vtkRectilinearGrid.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <cstring>
#include <map>

#include "base/error.h"
#include "io/source/cell_kinds.h"
#include "vtk/versions/vtk_versions.h"

namespace tetfusion {
namespace {

ValueType float_type(vtkDataArray* array) {
  return array != nullptr && array->GetDataType() == VTK_FLOAT ? ValueType::kFloat32
                                                               : ValueType::kFloat64;
}

ValueType point_type_of(vtkDataSet* data) {
  if (auto* set = vtkPointSet::SafeDownCast(data)) {
    return float_type(set->GetPoints() != nullptr ? set->GetPoints()->GetData() : nullptr);
  }
  if (auto* grid = vtkRectilinearGrid::SafeDownCast(data)) {
    for (vtkDataArray* axis :
         {grid->GetXCoordinates(), grid->GetYCoordinates(), grid->GetZCoordinates()}) {
      if (float_type(axis) == ValueType::kFloat64) return ValueType::kFloat64;
    }
    return ValueType::kFloat32;
  }
  return ValueType::kFloat64;  // an image's origin and spacing are doubles
}

void check_cells(const std::string& path, std::size_t piece, vtkDataSet* data) {
  auto* grid = vtkUnstructuredGrid::SafeDownCast(data);
  if (grid == nullptr || grid->GetNumberOfCells() == 0) return;
  vtkDataArray* const types = vtk_version::cell_types(grid);
  vtkCellArray* cells = grid->GetCells();
  if (types == nullptr || types->GetNumberOfTuples() != cells->GetNumberOfCells()) {
    throw Error(ErrorCode::kBadInput, path + ": piece " + std::to_string(piece) +
                                          ": there are not as many cell types as cells");
  }
  if (!cells->IsValid()) {
    throw Error(ErrorCode::kBadInput, path + ": piece " + std::to_string(piece) +
                                          ": the offsets of the cells do not ascend from 0 to the "
                                          "length of the connectivity");
  }
}

vtkPoints* points_of(const Piece& piece) {
  auto* set = vtkPointSet::SafeDownCast(piece.data);
  return set != nullptr ? set->GetPoints() : nullptr;
}

std::vector<const Piece*> point_pieces(const PieceList& list) {
  return pieces_with_rows(list, Association::kPoint);
}

// The number of the first point that has these coordinates; `first`, and so from now on, where no
// piece had them yet.
std::uint64_t first_with(const Piece& piece, std::uint64_t first,
                         std::map<vtkDataArray*, std::uint64_t>* known) {
  vtkPoints* const points = points_of(piece);
  if (points == nullptr || piece.points() == 0) return first;
  return known->emplace(points->GetData(), first).first->second;
}

template <class Real>
Vector<Vec3<Real>> copy_points(const PieceList& list) {
  Vector<Vec3<Real>> out(list.points);
  for (const Piece* const piece : point_pieces(list)) {
    if (piece->points() == 0) continue;
    Vec3<Real>* to = out.data() + piece->first_point;
    vtkPoints* points = points_of(*piece);
    constexpr int kType = sizeof(Real) == sizeof(float) ? VTK_FLOAT : VTK_DOUBLE;
    if (points != nullptr && points->GetDataType() == kType &&
        points->GetData()->HasStandardMemoryLayout()) {
      std::memcpy(to, points->GetData()->GetVoidPointer(0), piece->points() * sizeof(Vec3<Real>));
      continue;
    }
    for (std::uint64_t i = 0; i < piece->points(); ++i) {
      double p[3];
      piece->data->GetPoint(static_cast<vtkIdType>(i), p);
      to[i] = {static_cast<Real>(p[0]), static_cast<Real>(p[1]), static_cast<Real>(p[2])};
    }
  }
  return out;
}

}  // namespace

vtkUnsignedCharArray* ghosts_of(vtkDataSet* data) {
  vtkUnsignedCharArray* const ghosts = data->GetCellGhostArray();
  const bool fits = ghosts != nullptr && ghosts->GetNumberOfTuples() == data->GetNumberOfCells();
  return fits ? ghosts : nullptr;
}

bool is_dropped(vtkUnsignedCharArray* ghosts, vtkIdType cell) {
  return ghosts != nullptr && (ghosts->GetValue(cell) & kGhostDropped) != 0;
}

vtkDataArray* global_id_array(vtkDataSet* data) {
  vtkPointData* arrays = data->GetPointData();
  for (vtkDataArray* array :
       {arrays->GetGlobalIds(), arrays->GetArray("GlobalNodeIds"), arrays->GetArray("GlobalNodeId"),
        arrays->GetArray("GlobalPointIds")}) {
    if (array == nullptr || array->GetNumberOfComponents() != 1) continue;
    if (array->GetDataType() != VTK_FLOAT && array->GetDataType() != VTK_DOUBLE) return array;
  }
  return nullptr;
}

PieceList number_pieces(const std::string& path, const LoadedFile& file) {
  PieceList list;
  std::map<vtkDataArray*, std::uint64_t> known;
  for (const auto& data : file.pieces) {
    check_cells(path, list.pieces.size(), data);
    Piece piece;
    piece.data = data;
    if (!file.centres.empty()) piece.centres = file.centres[list.pieces.size()];
    piece.first_cell = list.cells;
    list.cells += piece.cells();
    piece.first_point = first_with(piece, list.points, &known);
    piece.brings_points = piece.first_point == list.points;
    if (piece.brings_points) list.points += piece.points();
    if (piece.points() > 0 && point_type_of(data) == ValueType::kFloat64) {
      list.point_type = ValueType::kFloat64;
    }
    list.pieces.push_back(piece);
  }
  if (list.points > kMaxPoints) {
    throw Error(ErrorCode::kMemory, path + ": " + std::to_string(list.points) +
                                        " points are more than can be held in memory at once (" +
                                        std::to_string(kMaxPoints) + ")");
  }
  return list;
}

std::vector<const Piece*> pieces_with_rows(const PieceList& list, Association association) {
  std::vector<const Piece*> with_rows;
  for (const Piece& piece : list.pieces) {
    if (association == Association::kCell || piece.brings_points) with_rows.push_back(&piece);
  }
  return with_rows;
}

CellTypeCounts count_types(const LoadedFile& file) {
  CellTypeCounts counts{};
  for (const auto& piece : file.pieces) {
    for (vtkIdType c = 0; c < piece->GetNumberOfCells(); ++c) {
      ++counts[static_cast<std::uint8_t>(piece->GetCellType(c))];
    }
  }
  counts[kVtkPolyhedron] = 0;
  counts[kVtkTetra] += file.tets_round_centres;
  return counts;
}

std::uint64_t bytes_of_cells(const LoadedFile& file) {
  std::uint64_t kibibytes = 0;
  for (const auto& piece : file.pieces) {
    auto* const grid = vtkUnstructuredGrid::SafeDownCast(piece);
    if (grid != nullptr) kibibytes += vtk_version::kibibytes_of_cells(grid);
  }
  return kibibytes * 1024;
}

Points all_points(const PieceList& list) {
  if (list.point_type == ValueType::kFloat32) return copy_points<float>(list);
  return copy_points<double>(list);
}

std::vector<std::uint64_t> point_begins(const PieceList& list) {
  std::vector<std::uint64_t> begins;
  for (const Piece* const piece : point_pieces(list)) begins.push_back(piece->first_point);
  begins.push_back(list.points);
  return begins;
}

namespace {

template <class T>
void append_first_components(const T* values, vtkIdType tuples, int width,
                             std::vector<std::int64_t>* out) {
  for (vtkIdType i = 0; i < tuples; ++i) {
    out->push_back(static_cast<std::int64_t>(values[i * width]));
  }
}

}  // namespace

std::vector<std::int64_t> global_point_ids(const PieceList& list) {
  std::vector<std::int64_t> ids;
  for (const Piece* const piece : point_pieces(list)) {
    vtkDataArray* array = global_id_array(piece->data);
    if (array == nullptr) return {};
    // Not component by component, which would be doubles.
    const auto copy = vtk_version::in_standard_layout(array);
    const int width = array->GetNumberOfComponents();
    const vtkIdType tuples = array->GetNumberOfTuples();
    switch (array->GetDataType()) {
      vtkTemplateMacro(append_first_components(static_cast<VTK_TT*>(copy->GetVoidPointer(0)),
                                               tuples, width, &ids));
    }
  }
  return ids;
}

}  // namespace tetfusion
