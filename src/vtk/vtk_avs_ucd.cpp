// AVS UCD: one grid without time steps.

#include "vtk/vtk_reader.h"

#ifdef TETFUSION_HAS_GEOMETRY
#include <vtkAVSucdReader.h>
#include <vtkNew.h>
#include <vtkUnstructuredGrid.h>
#endif

#include "vtk/vtk_collect.h"

namespace tetfusion {

#ifdef TETFUSION_HAS_GEOMETRY
std::unique_ptr<FileReader> open_avs_ucd(const std::string& path, const TrapScope& trap) {
  return without_steps([&](LoadedFile* out) {
    vtkNew<vtkAVSucdReader> reader;
    reader->SetFileName(path.c_str());
    reader->Update();
    trap.check(path);
    collect(reader->GetOutput(), path, out);
  });
}
#else
std::unique_ptr<FileReader> open_avs_ucd(const std::string& path, const TrapScope&) {
  refuse_without(path, "IOGeometry", "AVS UCD");
}
#endif

}  // namespace tetfusion
