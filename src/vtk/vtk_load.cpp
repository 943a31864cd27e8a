#include "vtk/vtk_load.h"

#include <fcntl.h>
#include <unistd.h>
#include <vtkCellData.h>
#include <vtkCompositeDataIterator.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkDoubleArray.h>
#include <vtkGenericDataObjectReader.h>
#include <vtkInformation.h>
#include <vtkIntArray.h>
#include <vtkLogger.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkStringArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLGenericDataObjectReader.h>
#include <vtkXMLPUnstructuredGridReader.h>
#include <vtkXMLPartitionedDataSetCollectionReader.h>
#include <vtkXMLPartitionedDataSetReader.h>
#ifdef TETFUSION_HAS_EXODUS
#include <vtkExodusIIReader.h>
#include <vtk_exodusII.h>
#endif

#include <algorithm>
#include <cstdio>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "io/mapped_file.h"
#include "io/vtk_bridge.h"
#include "vtk/vtk_trial.h"

namespace tetfusion {
namespace {

// Keeps VTK's first error message instead of printing it.
class MessageTrap : public vtkOutputWindow {
 public:
  static MessageTrap* New();

  void DisplayText(const char*) override {}
  void DisplayWarningText(const char*) override {}
  void DisplayGenericWarningText(const char*) override {}
  void DisplayDebugText(const char*) override {}
  void DisplayErrorText(const char* text) override {
    if (error_.empty() && text != nullptr) error_ = tidy(text);
  }
  const std::string& error() const { return error_; }

 private:
  // "ERROR: In vtkFoo.cxx, line 1\nvtkFoo (0x55d0): What is wrong\n\n" is "What is wrong".
  static std::string tidy(std::string_view text) {
    const std::size_t object = text.find("): ");
    if (object != std::string_view::npos) text.remove_prefix(object + 3);
    std::string words;
    for (const char c : text) {
      const bool blank = c == '\n' || c == '\r' || c == '\t' || c == ' ';
      if (!blank) {
        words += c;
      } else if (!words.empty() && words.back() != ' ') {
        words += ' ';
      }
    }
    while (!words.empty() && words.back() == ' ') words.pop_back();
    return words.empty() ? "an error without a message" : words;
  }

  std::string error_;
};
vtkStandardNewMacro(MessageTrap);

// Puts a trap in the place of VTK's message window for its life time, and keeps VTK's log quiet,
// which would print the same messages.
class TrapScope {
 public:
  TrapScope()
      : before_(vtkOutputWindow::GetInstance()),
        verbosity_before_(vtkLogger::GetCurrentVerbosityCutoff()) {
    trap_->SetDisplayMode(vtkOutputWindow::NEVER);
    vtkOutputWindow::SetInstance(trap_);
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
  }
  ~TrapScope() {
    vtkOutputWindow::SetInstance(before_);
    vtkLogger::SetStderrVerbosity(verbosity_before_);
  }
  TrapScope(const TrapScope&) = delete;
  TrapScope& operator=(const TrapScope&) = delete;

  void check(const std::string& path) const {
    if (trap_->error().empty()) return;
    throw Error(ErrorCode::kBadInput, path + ": VTK cannot read it: " + trap_->error());
  }

 private:
  vtkSmartPointer<vtkOutputWindow> before_;
  vtkLogger::Verbosity verbosity_before_;
  vtkNew<MessageTrap> trap_;
};

bool holds_blocks(vtkDataObject* data) {
  return vtkMultiBlockDataSet::SafeDownCast(data) != nullptr ||
         vtkPartitionedDataSetCollection::SafeDownCast(data) != nullptr;
}

std::string name_of_current(vtkCompositeDataIterator* at) {
  if (at->HasCurrentMetaData() == 0) return "";
  const char* const name = at->GetCurrentMetaData()->Get(vtkCompositeDataSet::NAME());
  return name != nullptr ? name : "";
}

void collect(vtkDataObject* data, const std::string& path, LoadedFile* out) {
  if (data == nullptr) throw Error(ErrorCode::kBadInput, path + ": VTK read nothing from it");
  if (auto* composite = vtkCompositeDataSet::SafeDownCast(data)) {
    out->field_data.emplace_back(composite->GetFieldData());
    auto at = vtk::TakeSmartPointer(composite->NewIterator());
    at->SkipEmptyNodesOff();  // an empty block is counted
    if (auto* children = vtkDataObjectTreeIterator::SafeDownCast(at)) {
      children->TraverseSubTreeOff();
      children->VisitOnlyLeavesOff();
    }
    for (at->InitTraversal(); !at->IsDoneWithTraversal(); at->GoToNextItem()) {
      vtkDataObject* child = at->GetCurrentDataObject();
      const bool is_block = holds_blocks(data) && !holds_blocks(child);
      if (is_block) out->block_names.push_back(name_of_current(at));
      if (child != nullptr) collect(child, path, out);
      if (is_block) ++out->blocks;
    }
    return;
  }
  auto* set = vtkDataSet::SafeDownCast(data);
  if (set == nullptr) {
    throw Error(ErrorCode::kBadInput,
                path + ": holds a " + data->GetClassName() + ", which has no tetrahedra");
  }
  out->field_data.emplace_back(set->GetFieldData());
  out->pieces.emplace_back(set);
  out->block_of.push_back(out->blocks);
}

vtkSmartPointer<vtkFieldData> field_data_of(vtkAbstractArray* array) {
  auto data = vtkSmartPointer<vtkFieldData>::New();
  data->AddArray(array);
  return data;
}

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
void load_parallel_grid(const std::string& path, const TrapScope& trap, LoadedFile* out) {
  vtkNew<vtkXMLPUnstructuredGridReader> reader;
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
  if (parallel && type == VTK_UNSTRUCTURED_GRID) {
    load_parallel_grid(path, trap, out);
    return;
  }
  reader->SetFileName(path.c_str());
  reader->Update();
  trap.check(path);
  collect(reader->GetOutput(), path, out);
}

#ifdef TETFUSION_HAS_EXODUS
// The library insists on printing why it cannot open a file, so that standard error is closed to
// it.
bool is_exodus(const std::string& path) {
  vtkNew<vtkExodusIIReader> reader;
  std::fflush(stderr);
  const int terminal = ::dup(STDERR_FILENO);
  const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (terminal >= 0 && nowhere >= 0) ::dup2(nowhere, STDERR_FILENO);
  const bool readable = reader->CanReadFile(path.c_str()) != 0;
  std::fflush(stderr);
  if (terminal >= 0) {
    ::dup2(terminal, STDERR_FILENO);
    ::close(terminal);
  }
  if (nowhere >= 0) ::close(nowhere);
  return readable;
}

constexpr double kCacheMebibytes = 1 << 20;  // a limit that is never met

// Sets of nodes, edges, faces, elements and sides, which are not read.
void tell_of_sets(vtkExodusIIReader* reader, LoadedFile* out) {
  constexpr std::pair<int, const char*> kSets[] = {{vtkExodusIIReader::NODE_SET, "node"},
                                                   {vtkExodusIIReader::EDGE_SET, "edge"},
                                                   {vtkExodusIIReader::FACE_SET, "face"},
                                                   {vtkExodusIIReader::SIDE_SET, "side"},
                                                   {vtkExodusIIReader::ELEM_SET, "element"}};
  for (const auto& [kind, what] : kSets) {
    for (int i = 0; i < reader->GetNumberOfObjects(kind); ++i) {
      out->left_out.push_back(std::string(what) + " set '" + reader->GetObjectName(kind, i) + "'");
    }
  }
}

// VTK says in each block which one it is. Here the file says which there are, and their names.
void tell_of_blocks(vtkExodusIIReader* reader, LoadedFile* out) {
  constexpr char kIds[] = "ElementBlockIds";
  constexpr int kKind = vtkExodusIIReader::ELEM_BLOCK;
  vtkNew<vtkIntArray> ids;
  ids->SetName(kIds);
  vtkNew<vtkStringArray> names;
  names->SetName("block_names");
  bool any_named = false;
  for (int i = 0; i < reader->GetNumberOfObjects(kKind); ++i) {
    const std::string name = reader->GetObjectName(kKind, i);
    const bool is_named = !name.empty() && !name.starts_with("Unnamed");
    ids->InsertNextValue(reader->GetObjectId(kKind, i));
    names->InsertNextValue(is_named ? name : "");
    any_named = any_named || is_named;
  }
  for (const auto& piece : out->pieces) piece->GetFieldData()->RemoveArray(kIds);
  out->field_data.push_back(field_data_of(ids));
  if (any_named) out->field_data.push_back(field_data_of(names));
}

std::vector<double> time_steps_in(vtkExodusIIReader* reader) {
  vtkInformation* const info = reader->GetOutputInformation(0);
  auto* const key = vtkStreamingDemandDrivenPipeline::TIME_STEPS();
  if (info->Has(key) == 0) return {};
  const double* const times = info->Get(key);
  return {times, times + info->Length(key)};
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
       << "'tetfusion simplify IN' with -o OUT_{step}.vtu or -o OUT.pvd all of them)";
  out->left_out.push_back(text.str());
}

// What it says of the file before it reads it.
vtkNew<vtkExodusIIReader> open_exodus(const std::string& path, const TrapScope& trap) {
  if (!is_exodus(path)) {
    throw Error(ErrorCode::kBadInput, path + ": is not an Exodus II file, or is damaged");
  }
  ex_opts(0);  // print nothing from here on
  vtkNew<vtkExodusIIReader> reader;
  reader->SetFileName(path.c_str());
  reader->UpdateInformation();
  trap.check(path);
  return reader;
}

std::vector<double> find_time_steps(const std::string& path) {
  const TrapScope trap;
  return time_steps_in(open_exodus(path, trap));
}

void load_exodus(const std::string& path, const OpenOptions& options, const TrapScope& trap,
                 LoadedFile* out) {
  const vtkNew<vtkExodusIIReader> reader = open_exodus(path, trap);
  out->time_steps = time_steps_in(reader);
  out->time_step = choose_time_step(path, out->time_steps.size(), options.time_step);
  reader->SetApplyDisplacements(false);  // the coordinates that the file holds
  // Squeezed points would be Float32 whatever the file has. So all blocks get all points of the
  // file, and the cache lets them share one copy.
  reader->SetSqueezePoints(false);
  reader->SetCacheSize(kCacheMebibytes);
  reader->SetTimeStep(static_cast<int>(out->time_step));
  for (const int kind : {vtkExodusIIReader::NODAL, vtkExodusIIReader::ELEM_BLOCK}) {
    if (out->time_steps.empty()) break;  // results have names, but no values
    for (int i = 0; i < reader->GetNumberOfObjectArrays(kind); ++i) {
      reader->SetObjectArrayStatus(kind, i, 1);
    }
  }
  for (int i = 0; i < reader->GetNumberOfObjects(vtkExodusIIReader::ELEM_BLOCK); ++i) {
    reader->SetObjectStatus(vtkExodusIIReader::ELEM_BLOCK, i, 1);
  }
  reader->Update();
  trap.check(path);
  collect(reader->GetOutput(), path, out);
  out->shared_points = true;
  tell_of_blocks(reader, out);
  tell_of_sets(reader, out);
  tell_of_steps(options.time_step.has_value(), out);
}
#else
[[noreturn]] void refuse_exodus(const std::string& path) {
  throw Error(ErrorCode::kBadInput, path + ": this build's VTK has no Exodus reader (IOExodus)");
}
std::vector<double> find_time_steps(const std::string& path) { refuse_exodus(path); }
void load_exodus(const std::string& path, const OpenOptions&, const TrapScope&, LoadedFile*) {
  refuse_exodus(path);
}
#endif

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
      break;
  }
  return out;
}

}  // namespace

LoadedFile load_with_vtk(const std::string& path, const OpenOptions& options) {
  FormatGuess guess;
  {
    const MappedFile file = MappedFile::open(path);
    guess = guess_format(file.bytes());
  }
  if (guess.format == ForeignFormat::kUnknown) {
    throw Error(ErrorCode::kBadInput,
                path +
                    ": not a mesh file that VTK reads: it begins neither like VTK's legacy or "
                    "XML formats nor like NetCDF or HDF5 (Exodus)");
  }
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
