// Makes a box of tetrahedra and halves it in a pipeline. With arguments, IN.vtu EXPECTED.vtu:
// halves the first, and looks whether that is the second, to the bit.
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkTetFusion.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <cstdio>
#include <cstring>

namespace {

constexpr vtkIdType kSide = 6;

vtkIdType point(vtkIdType x, vtkIdType y, vtkIdType z) {
  return (z * (kSide + 1) + y) * (kSide + 1) + x;
}

// Six tetrahedra round the diagonal of each cube.
void fill_box(vtkUnstructuredGrid* grid) {
  vtkNew<vtkPoints> points;
  for (vtkIdType i = 0; i < point(0, 0, kSide + 1); ++i) {
    points->InsertNextPoint(static_cast<double>(i % (kSide + 1)),
                            static_cast<double>(i / (kSide + 1) % (kSide + 1)),
                            static_cast<double>(i / (kSide + 1) / (kSide + 1)));
  }
  grid->SetPoints(points);
  constexpr int kOrders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {1, 0, 2}, {2, 1, 0}};
  for (vtkIdType cube = 0; cube < kSide * kSide * kSide; ++cube) {
    for (const auto& order : kOrders) {
      vtkIdType at[3] = {cube % kSide, cube / kSide % kSide, cube / kSide / kSide};
      vtkIdType corners[4] = {point(at[0], at[1], at[2])};
      for (int step = 0; step < 3; ++step) {
        ++at[order[step]];
        corners[step + 1] = point(at[0], at[1], at[2]);
      }
      grid->InsertNextCell(VTK_TETRA, 4, corners);
    }
  }
}

bool same(vtkDataArray* one, vtkDataArray* other) {
  if (one == nullptr || other == nullptr || one->GetDataType() != other->GetDataType())
    return false;
  if (one->GetNumberOfValues() != other->GetNumberOfValues()) return false;
  const auto bytes = static_cast<std::size_t>(one->GetNumberOfValues() * one->GetDataTypeSize());
  return bytes == 0 || std::memcmp(one->GetVoidPointer(0), other->GetVoidPointer(0), bytes) == 0;
}

bool same(vtkDataSetAttributes* one, vtkDataSetAttributes* other) {
  if (one->GetNumberOfArrays() != other->GetNumberOfArrays()) return false;
  for (int i = 0; i < one->GetNumberOfArrays(); ++i) {
    if (!same(one->GetArray(i), other->GetArray(one->GetArrayName(i)))) return false;
  }
  return true;
}

bool same(vtkUnstructuredGrid* one, vtkUnstructuredGrid* other) {
  vtkCellArray* const cells = one->GetCells();
  vtkCellArray* const others = other->GetCells();
  return same(one->GetPoints()->GetData(), other->GetPoints()->GetData()) &&
         same(cells->GetConnectivityArray(), others->GetConnectivityArray()) &&
         same(cells->GetOffsetsArray(), others->GetOffsetsArray()) &&
         same(one->GetPointData(), other->GetPointData()) &&
         same(one->GetCellData(), other->GetCellData());
}

int compare(const char* input, const char* expected) {
  vtkNew<vtkXMLUnstructuredGridReader> reader, other;
  reader->SetFileName(input);
  other->SetFileName(expected);
  other->Update();
  vtkNew<vtkTetFusion> simplify;
  simplify->SetInputConnection(reader->GetOutputPort());
  simplify->SetTargetReduction(0.5);
  simplify->Update();
  if (simplify->GetErrorCode() != 0) return 1;
  vtkUnstructuredGrid* const output = simplify->GetOutput();
  const vtkIdType before = reader->GetOutput()->GetNumberOfCells();
  std::printf("%lld -> %lld cells\n", static_cast<long long>(before),
              static_cast<long long>(output->GetNumberOfCells()));
  return output->GetNumberOfCells() < before && same(output, other->GetOutput()) ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3) return compare(argv[1], argv[2]);
  vtkNew<vtkUnstructuredGrid> grid;
  fill_box(grid);
  vtkNew<vtkTetFusion> simplify;
  simplify->SetInputData(grid);
  simplify->SetTargetReduction(0.4);
  simplify->Update();
  if (simplify->GetErrorCode() != 0) return 1;
  std::printf("%lld -> %lld cells\n%s\n", static_cast<long long>(grid->GetNumberOfCells()),
              static_cast<long long>(simplify->GetOutput()->GetNumberOfCells()),
              simplify->GetStopSentence());
  return 0;
}
