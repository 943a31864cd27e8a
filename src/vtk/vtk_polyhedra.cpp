#include "vtk/vtk_polyhedra.h"

#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkTetra.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <vector>

#include "io/source/cell_kinds.h"
#include "vtk/versions/vtk_versions.h"
#include "vtk/vtk_pieces.h"

namespace tetfusion {
namespace {

using Position = std::array<double, 3>;

// What points in the middles of cells take of the points round them.
struct Centres {
  std::vector<std::size_t> begins{0};
  std::vector<vtkIdType> points;
  std::vector<double> weights;
  std::uint64_t tets = 0;  // that are cut from there

  std::size_t size() const { return begins.size() - 1; }
};

// A polyhedron is made of tetrahedra between the triangles of its faces and the mean of its
// corners. The centre of its volume is the mean of theirs, each counted by its volume.
class Weigher {
 public:
  explicit Weigher(vtkUnstructuredGrid* grid) : grid_(grid) {}

  void add_centre(vtkIdType cell, Centres* out) {
    grid_->GetCellPoints(cell, corners_);
    const auto count = static_cast<std::size_t>(corners_->GetNumberOfIds());
    shares_.assign(count, 0.0);
    volume_ = 0;
    mean_ = {};
    for (std::size_t i = 0; i < count; ++i) {
      const Position x = position(corner(i));
      for (std::size_t a = 0; a < 3; ++a) mean_[a] += x[a] / static_cast<double>(count);
    }
    for_each_face(grid_, cell, stream_, [&](std::span<const vtkIdType> face) {
      for (std::size_t i = 2; i < face.size(); ++i) {
        weigh({face[0], face[i - 1], face[i]});
        ++out->tets;
      }
    });
    for (std::size_t i = 0; i < count; ++i) {
      // The mean is a corner of each tetrahedron: a quarter of all is everybody's.
      const double even = 1.0 / static_cast<double>(count);
      out->points.push_back(corner(i));
      out->weights.push_back(volume_ > 0 ? 0.25 * (even + shares_[i] / volume_) : even);
    }
    out->begins.push_back(out->points.size());
  }

 private:
  vtkIdType corner(std::size_t i) const { return corners_->GetId(static_cast<vtkIdType>(i)); }

  Position position(vtkIdType id) const {
    if (id < 0 || id >= grid_->GetNumberOfPoints()) {
      throw InvalidMesh(
          "a polyhedron " +
          wrong_vertex(std::to_string(id), static_cast<std::uint64_t>(grid_->GetNumberOfPoints())));
    }
    Position x{};
    grid_->GetPoint(id, x.data());
    return x;
  }

  void weigh(const std::array<vtkIdType, 3>& triangle) {
    std::array<Position, 3> x{};
    for (std::size_t k = 0; k < 3; ++k) x[k] = position(triangle[k]);
    const double volume =
        std::abs(vtkTetra::ComputeVolume(x[0].data(), x[1].data(), x[2].data(), mean_.data()));
    if (!std::isfinite(volume)) return;
    volume_ += volume;
    for (const vtkIdType id : triangle) {
      const vtkIdType at = corners_->IsId(id);
      if (at >= 0) shares_[static_cast<std::size_t>(at)] += volume;
    }
  }

  vtkUnstructuredGrid* grid_;
  vtkNew<vtkIdList> corners_, stream_;
  std::vector<double> shares_;  // of the corners in the volumes that they are of
  double volume_ = 0;
  Position mean_{};
};

// Of each cell the number of its centre, which `centres` gets, from `next` on; -1: it has none.
// Empty where no cell has one.
std::vector<vtkIdType> find_centres(vtkDataSet* piece, vtkIdType next, Centres* centres) {
  auto* const grid = vtkUnstructuredGrid::SafeDownCast(piece);
  if (grid == nullptr || !vtk_version::has_polyhedra(grid)) return {};
  Weigher weigher(grid);
  const std::size_t before = centres->size();
  vtkUnsignedCharArray* const ghosts = ghosts_of(grid);
  std::vector<vtkIdType> centre_of(static_cast<std::size_t>(grid->GetNumberOfCells()), -1);
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c) {
    if (grid->GetCellType(c) != kVtkPolyhedron || is_dropped(ghosts, c)) continue;
    if (grid->GetCells()->GetCellSize(c) == 0) continue;  // refused later
    weigher.add_centre(c, centres);
    centre_of[static_cast<std::size_t>(c)] = next++;
  }
  if (centres->size() == before) centre_of.clear();
  return centre_of;
}

// With the values at the centres behind those of the points.
vtkSmartPointer<vtkDataArray> extended(vtkDataArray* array, const Centres& centres) {
  const auto longer = vtk::TakeSmartPointer(vtkDataArray::CreateDataArray(array->GetDataType()));
  const vtkIdType points = array->GetNumberOfTuples();
  longer->SetName(array->GetName());
  longer->SetNumberOfComponents(array->GetNumberOfComponents());
  longer->CopyComponentNames(array);
  if (array->HasInformation()) longer->CopyInformation(array->GetInformation());
  longer->SetNumberOfTuples(points + static_cast<vtkIdType>(centres.size()));
  longer->InsertTuples(0, points, 0, array);
  const bool is_blended = array->GetDataType() == VTK_FLOAT || array->GetDataType() == VTK_DOUBLE;
  vtkNew<vtkIdList> ids;
  for (std::size_t k = 0; k < centres.size(); ++k) {
    const std::size_t begin = centres.begins[k], end = centres.begins[k + 1];
    const vtkIdType at = points + static_cast<vtkIdType>(k);
    if (!is_blended) {
      longer->SetTuple(at, centres.points[begin], array);
      continue;
    }
    ids->SetNumberOfIds(static_cast<vtkIdType>(end - begin));
    std::copy(centres.points.data() + begin, centres.points.data() + end, ids->GetPointer(0));
    // VTK takes them as it would change them.
    longer->InterpolateTuple(at, ids, array, const_cast<double*>(centres.weights.data() + begin));
  }
  return longer;
}

// A piece like this one that has the centres, too.
vtkSmartPointer<vtkDataSet> with_centres(vtkPointSet* piece, vtkDataArray* coordinates,
                                         const Centres& centres) {
  const auto longer = vtk::TakeSmartPointer(piece->NewInstance());
  longer->ShallowCopy(piece);
  vtkNew<vtkPoints> points;
  points->SetDataType(coordinates->GetDataType());
  points->SetData(coordinates);
  longer->SetPoints(points);
  vtkPointData* const from = piece->GetPointData();
  vtkPointData* const to = longer->GetPointData();
  to->Initialize();
  for (int i = 0; i < from->GetNumberOfArrays(); ++i) {
    vtkDataArray* const array = from->GetArray(i);
    // Strings are not read, and what is of no point is refused later.
    const bool is_of_points =
        array != nullptr && array->GetNumberOfTuples() == piece->GetNumberOfPoints();
    const int at =
        to->AddArray(is_of_points ? extended(array, centres).Get() : from->GetAbstractArray(i));
    for (int kind = 0; kind < vtkDataSetAttributes::NUM_ATTRIBUTES; ++kind) {
      if (from->GetAbstractAttribute(kind) == from->GetAbstractArray(i)) {
        to->SetActiveAttribute(at, kind);
      }
    }
  }
  return longer;
}

vtkDataArray* coordinates_of(vtkDataSet* piece) {
  auto* const set = vtkPointSet::SafeDownCast(piece);
  return set != nullptr && set->GetPoints() != nullptr ? set->GetPoints()->GetData() : nullptr;
}

// Whole numbers have no middles.
vtkSmartPointer<vtkDataArray> floating(vtkDataArray* coordinates) {
  const int type = coordinates->GetDataType();
  if (type == VTK_FLOAT || type == VTK_DOUBLE) return coordinates;
  const auto numbers = vtkSmartPointer<vtkDoubleArray>::New();
  numbers->DeepCopy(coordinates);
  return numbers;
}

// The pieces that have points, those that share theirs together.
std::vector<std::vector<std::size_t>> by_coordinates(const LoadedFile& file) {
  std::vector<std::vector<std::size_t>> groups;
  std::map<vtkDataArray*, std::size_t> group_of;
  for (std::size_t p = 0; p < file.pieces.size(); ++p) {
    vtkDataArray* const coordinates = coordinates_of(file.pieces[p]);
    if (coordinates == nullptr) continue;
    const auto [at, is_new] = group_of.emplace(coordinates, groups.size());
    if (is_new) groups.emplace_back();
    groups[at->second].push_back(p);
  }
  return groups;
}

}  // namespace

void add_centres(const std::string& path, LoadedFile* file) {
  try {
    file->centres.resize(file->pieces.size());
    for (const auto& group : by_coordinates(*file)) {
      vtkDataArray* const coordinates = coordinates_of(file->pieces[group[0]]);
      const vtkIdType points = coordinates->GetNumberOfTuples();
      Centres centres;
      for (const std::size_t p : group) {
        file->centres[p] = find_centres(file->pieces[p],
                                        points + static_cast<vtkIdType>(centres.size()), &centres);
      }
      file->tets_round_centres += centres.tets;
      if (centres.size() == 0) continue;
      const auto all = extended(floating(coordinates), centres);
      for (const std::size_t p : group) {
        auto& piece = file->pieces[p];
        piece = with_centres(vtkPointSet::SafeDownCast(piece), all, centres);
      }
    }
  } catch (const InvalidMesh& error) {
    throw InvalidMesh(path + ": " + error.what());
  }
}

}  // namespace tetfusion
