#include "vtk/vtk_load.h"

#include <vtkDoubleArray.h>
#include <vtkGenericDataObjectReader.h>
#include <vtkNew.h>
#include <vtkXMLGenericDataObjectReader.h>
#include <vtkXMLPartitionedDataSetCollectionReader.h>
#include <vtkXMLPartitionedDataSetReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <memory>
#include <sstream>

#include "base/error.h"
#include "io/files/mapped_file.h"
#include "io/foreign_format.h"
#include "io/open_mesh.h"
#include "io/vtk/pvtu_reader.h"
#include "vtk/vtk_collect.h"
#include "vtk/vtk_polyhedra.h"
#include "vtk/vtk_reader.h"
#include "vtk/vtk_trap.h"
#include "vtk/vtk_trial.h"

namespace tetfusion {
namespace {

void load_legacy(const std::string& path, const TrapScope& trap, LoadedFile* out) {
  vtkNew<vtkGenericDataObjectReader> reader;
  reader->SetFileName(path.c_str());
  // The reader's own choice is the first array of each kind.
  reader->ReadAllScalarsOn();
  reader->ReadAllVectorsOn();
  reader->ReadAllNormalsOn();
  reader->ReadAllTensorsOn();
  reader->ReadAllColorScalarsOn();
  reader->ReadAllTCoordsOn();
  reader->ReadAllFieldsOn();
  reader->Update();
  trap.check(path);
  // Where the file ends too early VTK warns, in part, and takes what it has.
  for (const std::string& warning : trap.generic_warnings()) {
    if (warning.find("Error reading") == std::string::npos) continue;
    throw Error(ErrorCode::kBadInput,
                path + ": VTK cannot read all of its values: it is cut off or damaged");
  }
  collect(reader->GetOutput(), path, out);
}

// Not appended: VTK's reader would forget which point came from where.
void load_grid(const std::string& path, const TrapScope& trap, LoadedFile* out) {
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName(path.c_str());
  reader->UpdateInformation();
  trap.check(path);
  collect_pieces(reader, reader->GetNumberOfPieces(), path, trap, out);
}

// File by file: VTK's reader of the list takes its word for the types of arrays, and leaves out
// those that it does not name.
void load_listed_grids(const std::string& path, const TrapScope& trap, LoadedFile* out) {
  out->files = pieces_of_pvtu(MappedFile::open(path));
  for (const std::string& piece : out->files) load_grid(piece, trap, out);
}

// False where the file is of another type.
template <class Reader>
bool load_if_readable(const std::string& path, const TrapScope& trap, LoadedFile* out) {
  vtkNew<Reader> reader;
  if (reader->CanReadFile(path.c_str()) == 0) return false;
  reader->SetFileName(path.c_str());
  reader->Update();
  trap.check(path);
  collect(reader->GetOutputDataObject(0), path, out);
  return true;
}

void load_any_xml(const std::string& path, const TrapScope& trap, LoadedFile* out) {
  // VTK 9.1's generic reader knows neither.
  if (load_if_readable<vtkXMLPartitionedDataSetReader>(path, trap, out)) return;
  if (load_if_readable<vtkXMLPartitionedDataSetCollectionReader>(path, trap, out)) return;
  vtkNew<vtkXMLGenericDataObjectReader> reader;
  bool parallel = false;
  const int type = reader->ReadOutputType(path.c_str(), parallel);
  if (type == VTK_UNSTRUCTURED_GRID) {
    return parallel ? load_listed_grids(path, trap, out) : load_grid(path, trap, out);
  }
  reader->SetFileName(path.c_str());
  reader->Update();
  trap.check(path);
  collect(reader->GetOutput(), path, out);
}

void load_xml(const std::string& path, const TrapScope& trap, LoadedFile* out) {
  load_any_xml(path, trap, out);
  mark_blocks(out);
}

std::unique_ptr<FileReader> open_hdf5(const std::string& path, const TrapScope& trap) {
  if (is_vtkhdf(path)) return open_vtkhdf(path, trap);
  if (is_cgns(path)) return open_cgns(path, trap);
  if (is_exodus(path)) return open_exodus(path, trap);
  throw Error(ErrorCode::kBadInput,
              path +
                  ": is an HDF5 file, but damaged, or none of those that this build's VTK reads: "
                  "VTKHDF, CGNS and Exodus; where an .xdmf file lies beside it, give that one");
}

std::unique_ptr<FileReader> open_reader(const std::string& path, const TrapScope& trap,
                                        ForeignFormat format) {
  switch (format) {
    case ForeignFormat::kLegacyVtk:
      return without_steps([&](LoadedFile* out) { load_legacy(path, trap, out); });
    case ForeignFormat::kXmlVtk:
      return without_steps([&](LoadedFile* out) { load_xml(path, trap, out); });
    case ForeignFormat::kNetCdf:
      return open_exodus(path, trap);
    case ForeignFormat::kHdf5:
      return open_hdf5(path, trap);
    case ForeignFormat::kAdf:
      return open_cgns(path, trap);
    case ForeignFormat::kXdmf:
      return open_xdmf(path);
    case ForeignFormat::kEnSight:
      return open_ensight(path, trap);
    case ForeignFormat::kOpenFoam:
      return open_openfoam(path, trap);
    case ForeignFormat::kUnknown:
      break;
  }
  throw Error(ErrorCode::kBadInput, path + ": not a mesh file that VTK reads");
}

// Its time is an array, and where nobody has chosen it the others are named.
void tell_of_steps(bool is_chosen, LoadedFile* out) {
  const std::vector<double>& times = out->time_steps;
  if (times.empty()) return;
  vtkNew<vtkDoubleArray> time;
  time->SetName("TimeValue");
  time->InsertNextValue(times[out->time_step]);
  out->field_data.push_back(field_data_of(time));
  if (is_chosen || times.size() == 1) return;
  std::ostringstream text;
  text << "the time steps from " << times[1] << " to " << times.back() << " (the first of "
       << times.size() << ", at " << times[0] << ", is read; --time-step takes another one, "
       << "an output called OUT_{step}.vtu or OUT.pvd all of them)";
  out->left_out.push_back(text.str());
}

LoadedFile load(const std::string& path, const OpenOptions& options, const FormatGuess& guess) {
  LoadedFile out;
  out.format = guess.words.substr(guess.words.find(' ') + 1);
  const TrapScope trap;
  const auto reader = open_reader(path, trap, guess.format);
  out.time_steps = reader->time_steps();
  out.time_step = choose_time_step(path, out.time_steps.size(), options.time_step);
  reader->load(out.time_step, &out);
  tell_of_steps(options.time_step.has_value(), &out);
  if (options.tetrahedralize) add_centres(path, &out);
  out.format += ", read with VTK";
  return out;
}

std::vector<double> find_time_steps(const std::string& path, ForeignFormat format) {
  const TrapScope trap;
  return open_reader(path, trap, format)->time_steps();
}

}  // namespace

LoadedFile load_with_vtk(const std::string& path, const OpenOptions& options) {
  const FormatGuess guess = guess_format_of(path);
  if (!options.was_read) try_in_child(path, options, [&] { load(path, options, guess); });
  return load(path, options, guess);
}

std::vector<double> load_time_steps(const std::string& path, const OpenOptions& options) {
  const ForeignFormat format = guess_format_of(path).format;
  try_in_child(path, options, [&] { find_time_steps(path, format); });
  return find_time_steps(path, format);
}

}  // namespace tetfusion
