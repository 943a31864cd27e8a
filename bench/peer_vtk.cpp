// Runs VTK's vtkUnstructuredGridQuadricDecimation on a .vtu and measures the filter alone, without
// reading and writing. The figures go to standard output as JSON; --help lists the options.
#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridQuadricDecimation.h>
#include <vtkVersion.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <exception>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "base/error.h"
#include "base/resources.h"

namespace {

using namespace tetfusion;
using Grid = vtkSmartPointer<vtkUnstructuredGrid>;

struct Arguments {
  std::string in;
  std::string out;
  std::string array;
  double reduction = 0;
  double scale = 1;  // 0: so that the volumes' mean is 1
  double boundary_weight = 100;
};

// What the filter may see: the points, the tetrahedra and the array it follows.
Grid read(const Arguments& a) {
  if (!std::ifstream(a.in)) throw Error(ErrorCode::kIo, a.in + ": cannot be opened");
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName(a.in.c_str());
  reader->Update();
  Grid grid = reader->GetOutput();
  if (grid->GetNumberOfCells() == 0)
    throw Error(ErrorCode::kBadInput, a.in + ": VTK reads no cells from it");
  vtkDataArray* array = grid->GetPointData()->GetArray(a.array.c_str());
  if (array == nullptr || array->GetNumberOfComponents() != 1)
    throw Error(ErrorCode::kBadInput, a.in + ": has no point array of one component " + a.array);
  Grid bare = Grid::New();
  bare->SetPoints(grid->GetPoints());
  bare->SetCells(VTK_TETRA, grid->GetCells());
  bare->GetPointData()->AddArray(array);
  return bare;
}

// The factor by which lengths grow for the mean volume to be 1, taken for a box that is full.
double scale_of(const Arguments& a, vtkUnstructuredGrid* grid) {
  if (a.scale != 0) return a.scale;
  const double* box = grid->GetBounds();
  const double volume = (box[1] - box[0]) * (box[3] - box[2]) * (box[5] - box[4]);
  return std::cbrt(static_cast<double>(grid->GetNumberOfCells()) / volume);
}

// Coordinates and field alike, so that the quadrics, which mix them, keep their proportions.
void multiply(vtkUnstructuredGrid* grid, const std::string& name, double factor) {
  if (factor == 1) return;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(grid->GetNumberOfPoints());
  vtkDataArray* old = grid->GetPointData()->GetArray(name.c_str());
  vtkNew<vtkDoubleArray> values;
  values->SetName(name.c_str());
  values->SetNumberOfValues(grid->GetNumberOfPoints());
  for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i) {
    const double* p = grid->GetPoint(i);
    points->SetPoint(i, p[0] * factor, p[1] * factor, p[2] * factor);
    values->SetValue(i, old->GetTuple1(i) * factor);
  }
  grid->SetPoints(points);
  grid->GetPointData()->RemoveArray(name.c_str());
  grid->GetPointData()->AddArray(values);
}

void write(const std::string& path, vtkUnstructuredGrid* grid) {
  vtkNew<vtkXMLUnstructuredGridWriter> writer;
  writer->SetFileName(path.c_str());
  writer->SetInputData(grid);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetCompressorTypeToNone();
  writer->SetHeaderTypeToUInt64();
  if (writer->Write() != 1 || writer->GetErrorCode() != 0)
    throw Error(ErrorCode::kIo, path + ": cannot be written");
}

nlohmann::ordered_json run(const Arguments& a) {
  Grid input = read(a);
  const vtkIdType tets = input->GetNumberOfCells();
  const double scale = scale_of(a, input);
  multiply(input, a.array, scale);
  vtkNew<vtkUnstructuredGridQuadricDecimation> filter;
  filter->SetInputData(input);
  filter->SetScalarsName(a.array.c_str());
  filter->SetTargetReduction(a.reduction);
  filter->SetBoundaryWeight(a.boundary_weight * scale);  // a face's quadric grows by less
  const std::uint64_t rss = current_rss_bytes(), peak = peak_rss_bytes();
  const double cpu = cpu_seconds(), wall = wall_seconds();
  filter->Update();
  nlohmann::ordered_json json{{"vtk", vtkVersion::GetVTKVersion()},
                              {"input_tets", tets},
                              {"cpu_seconds", cpu_seconds() - cpu},
                              {"wall_seconds", wall_seconds() - wall},
                              {"rss_before_bytes", rss},
                              {"peak_rss_before_bytes", peak},
                              {"peak_rss_bytes", peak_rss_bytes()},
                              {"scale", scale}};
  Grid output = filter->GetOutput();
  vtkDataArray* array = output->GetPointData()->GetArray("scalars");
  if (output->GetNumberOfCells() == 0 || array == nullptr)
    throw Error(ErrorCode::kBadInput, a.in + ": VTK's filter made nothing of it");
  array->SetName(a.array.c_str());
  multiply(output, a.array, 1 / scale);
  output->GetPointData()->SetActiveScalars(a.array.c_str());
  json["points"] = output->GetNumberOfPoints();
  json["tets"] = output->GetNumberOfCells();
  write(a.out, output);
  return json;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments a;
  CLI::App app{"VTK's vtkUnstructuredGridQuadricDecimation, measured"};
  app.add_option("IN", a.in, "a .vtu of tetrahedra")->required();
  app.add_option("OUT", a.out, "the result, with the array under its old name")->required();
  app.add_option("--array", a.array, "point array that the filter follows")->required();
  app.add_option("--reduction", a.reduction, "share of the tetrahedra that is to go, 0 to 1")
      ->required()
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--scale", a.scale,
                 "coordinates, array and boundary weight times this, and back afterwards; 0: so "
                 "that a tetrahedron's volume is about 1. The filter moves no vertex of a "
                 "tetrahedron whose new volume is under 1.7e-7")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--boundary-weight", a.boundary_weight, "of the filter; default as there, 100");
  CLI11_PARSE(app, argc, argv);
  try {
    std::cout << run(a).dump(2) << "\n";
  } catch (const std::exception& e) {
    std::cerr << e.what() << "\n";
    return 1;
  }
  return 0;
}
