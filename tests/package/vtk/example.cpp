// Makes a box of tetrahedra and halves it in a pipeline.
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkTetFusion.h>
#include <vtkUnstructuredGrid.h>

#include <cstdio>

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

}  // namespace

int main() {
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
