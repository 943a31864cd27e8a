#include "vtk/vtk_load.h"

#include <vtkCellData.h>
#include <vtkGenericDataObjectReader.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkStringArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLGenericDataObjectReader.h>
#include <vtkXMLPUnstructuredGridReader.h>
#include <vtkXMLPartitionedDataSetCollectionReader.h>
#include <vtkXMLPartitionedDataSetReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "io/foreign_format.h"
#include "vtk/vtk_collect.h"
#include "vtk/vtk_exodus.h"
#include "vtk/vtk_polyhedra.h"
#include "vtk/vtk_trap.h"
#include "vtk/vtk_trial.h"

namespace tetfusion {
namespace {

// Says of each cell which block it is of, where several blocks have cells: these are most often
// materials, and the patches of a boundary. The name is one whose interfaces are kept. The blocks'
// names go beside it.
void mark_blocks(LoadedFile* file) {
  constexpr char kName[] = "block";
  std::set<int> with_cells;
  for (std::size_t k = 0; k < file->pieces.size(); ++k) {
    if (file->pieces[k]->GetCellData()->HasArray(kName) != 0) return;
    if (file->pieces[k]->GetNumberOfCells() > 0) with_cells.insert(file->block_of[k]);
  }
  if (with_cells.size() < 2) return;
  for (std::size_t k = 0; k < file->pieces.size(); ++k) {
    vtkNew<vtkIntArray> blocks;
    blocks->SetName(kName);
    blocks->SetNumberOfTuples(file->pieces[k]->GetNumberOfCells());
    blocks->FillValue(file->block_of[k]);
    file->pieces[k]->GetCellData()->AddArray(blocks);
  }
  const auto is_named = [](const std::string& name) { return !name.empty(); };
  if (std::none_of(file->block_names.begin(), file->block_names.end(), is_named)) return;
  vtkNew<vtkStringArray> names;
  names->SetName("block_names");
  for (const std::string& name : file->block_names) names->InsertNextValue(name);
  file->field_data.push_back(field_data_of(names));
}

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
  collect(reader->GetOutput(), path, out);
}

// Piece by piece: VTK's reader would append them and forget which point came from where.
template <class Reader>
void load_grid(const std::string& path, const TrapScope& trap, LoadedFile* out) {
  vtkNew<Reader> reader;
  reader->SetFileName(path.c_str());
  reader->UpdateInformation();
  trap.check(path);
  const int pieces = reader->GetNumberOfPieces();
  for (int i = 0; i < pieces; ++i) {
    reader->UpdatePiece(i, pieces, 0);
    trap.check(path);
    vtkNew<vtkUnstructuredGrid> copy;
    copy->ShallowCopy(reader->GetOutput());
    collect(copy, path, out);
  }
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

void load_xml(const std::string& path, const TrapScope& trap, LoadedFile* out) {
  // VTK 9.1's generic reader knows neither.
  if (load_if_readable<vtkXMLPartitionedDataSetReader>(path, trap, out)) return;
  if (load_if_readable<vtkXMLPartitionedDataSetCollectionReader>(path, trap, out)) return;
  vtkNew<vtkXMLGenericDataObjectReader> reader;
  bool parallel = false;
  const int type = reader->ReadOutputType(path.c_str(), parallel);
  if (type == VTK_UNSTRUCTURED_GRID) {
    if (parallel) return load_grid<vtkXMLPUnstructuredGridReader>(path, trap, out);
    return load_grid<vtkXMLUnstructuredGridReader>(path, trap, out);
  }
  reader->SetFileName(path.c_str());
  reader->Update();
  trap.check(path);
  collect(reader->GetOutput(), path, out);
}

LoadedFile load(const std::string& path, const OpenOptions& options, ForeignFormat format) {
  LoadedFile out;
  const TrapScope trap;
  switch (format) {
    case ForeignFormat::kLegacyVtk:
      load_legacy(path, trap, &out);
      break;
    case ForeignFormat::kXmlVtk:
      load_xml(path, trap, &out);
      mark_blocks(&out);
      break;
    case ForeignFormat::kNetCdf:
    case ForeignFormat::kHdf5:
      load_exodus(path, options, trap, &out);
      break;
    case ForeignFormat::kUnknown:
      throw Error(ErrorCode::kBadInput, path + ": not a mesh file that VTK reads");
  }
  if (options.tetrahedralize) add_centres(path, &out);
  return out;
}

}  // namespace

LoadedFile load_with_vtk(const std::string& path, const OpenOptions& options) {
  const FormatGuess guess = guess_format_of(path);
  if (!options.was_read) try_in_child(path, [&] { load(path, options, guess.format); });
  LoadedFile out = load(path, options, guess.format);
  out.format = guess.words.substr(guess.words.find(' ') + 1) + ", read with VTK";
  return out;
}

std::vector<double> load_time_steps(const std::string& path) {
  try_in_child(path, [&] { find_time_steps(path); });
  return find_time_steps(path);
}

}  // namespace tetfusion
