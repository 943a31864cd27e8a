#include "vtk/vtk_exodus.h"

#ifdef TETFUSION_HAS_EXODUS
#include <fcntl.h>
#include <unistd.h>
#include <vtkCell.h>
#include <vtkCellArray.h>
#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkExodusIIReader.h>
#include <vtkInformation.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkStringArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtk_exodusII.h>

#include <array>
#include <cctype>
#include <cstdio>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>
#endif

#include "base/error.h"
#include "mesh/split_cells.h"
#include "vtk/vtk_collect.h"

namespace tetfusion {

#ifdef TETFUSION_HAS_EXODUS
namespace {

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

constexpr char kBlockIds[] = "ElementBlockIds";

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

// A block of elements as the file says it.
struct ElementBlock {
  std::string type;
  std::size_t elements = 0, nodes = 0;  // nodes of each element
};

// Opened beside VTK's reader, for what that does not tell.
class ExodusFile {
 public:
  explicit ExodusFile(const std::string& path) {
    int word = sizeof(double), file_word = 0;
    float version = 0;
    file_ = ex_open(path.c_str(), EX_READ, &word, &file_word, &version);
    if (file_ < 0) throw Error(ErrorCode::kBadInput, path + ": cannot be opened as an Exodus file");
  }
  ~ExodusFile() { ex_close(file_); }
  ExodusFile(const ExodusFile&) = delete;
  ExodusFile& operator=(const ExodusFile&) = delete;

  std::optional<ElementBlock> block(int id) const {
    std::array<char, MAX_STR_LENGTH + 1> type{};
    int elements = 0, nodes = 0, edges = 0, faces = 0, attributes = 0;
    if (ex_get_block(file_, EX_ELEM_BLOCK, id, type.data(), &elements, &nodes, &edges, &faces,
                     &attributes) < 0 ||
        elements < 0 || nodes < 0) {
      return {};
    }
    return ElementBlock{type.data(), static_cast<std::size_t>(elements),
                        static_cast<std::size_t>(nodes)};
  }

  // Nodes of one element after another, counted from 1; none: they cannot be read.
  std::vector<int> nodes(int id, const ElementBlock& block) const {
    std::vector<int> nodes(block.elements * block.nodes);
    if (ex_get_conn(file_, EX_ELEM_BLOCK, id, nodes.data(), nullptr, nullptr) < 0) nodes.clear();
    return nodes;
  }

 private:
  int file_ = -1;
};

// Of any order, by the beginning of the type's name; 0: this program does not know it.
std::uint8_t curved_type(std::string name) {
  constexpr std::array<std::pair<std::string_view, std::uint8_t>, 13> kTypes{
      {{"TET", kVtkLagrangeTetra},
       {"HEX", kVtkLagrangeHexahedron},
       {"WED", kVtkLagrangeWedge},
       {"PRI", kVtkLagrangeWedge},
       {"PYR", kVtkLagrangePyramid},
       {"TRI", kVtkLagrangeTriangle},
       {"QUA", kVtkLagrangeQuad},
       {"SHE", kVtkLagrangeQuad},
       {"EDG", kVtkLagrangeCurve},
       {"BAR", kVtkLagrangeCurve},
       {"BEA", kVtkLagrangeCurve},
       {"TRU", kVtkLagrangeCurve},
       {"ROD", kVtkLagrangeCurve}}};
  for (char& c : name) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  for (const auto& [beginning, type] : kTypes) {
    if (name.starts_with(beginning)) return type;
  }
  return 0;
}

// VTK takes elements of some orders, as TET14, for linear ones, and then nodes of one for those of
// the next. The file says how many an element has, corners first.
void mend_curved_elements(const std::string& path, const LoadedFile& loaded) {
  const ExodusFile file(path);
  for (const auto& piece : loaded.pieces) {
    auto* const grid = vtkUnstructuredGrid::SafeDownCast(piece);
    vtkDataArray* const ids = piece->GetFieldData()->GetArray(kBlockIds);
    if (grid == nullptr || ids == nullptr || grid->GetNumberOfCells() == 0) continue;
    const int id = static_cast<int>(ids->GetTuple1(0));
    const auto block = file.block(id);
    const auto of_vtk = static_cast<std::size_t>(grid->GetCell(0)->GetNumberOfPoints());
    if (!block || block->nodes == 0 || block->nodes == of_vtk) continue;
    const std::uint8_t type = curved_type(block->type);
    const std::vector<int> nodes = file.nodes(id, *block);
    if (type == 0 || nodes.empty() ||
        block->elements != static_cast<std::size_t>(grid->GetNumberOfCells())) {
      throw Error(ErrorCode::kBadInput, path + ": block " + std::to_string(id) +
                                            " has elements of " + std::to_string(block->nodes) +
                                            " nodes (" + block->type +
                                            "), which VTK takes for others");
    }
    vtkNew<vtkCellArray> cells;
    for (std::size_t e = 0; e < block->elements; ++e) {
      cells->InsertNextCell(static_cast<int>(block->nodes));
      for (std::size_t k = 0; k < block->nodes; ++k) {
        cells->InsertCellPoint(vtkIdType{nodes[e * block->nodes + k]} - 1);
      }
    }
    grid->SetCells(type, cells);
  }
}

// VTK says in each block which one it is. Here the file says which there are, and their names.
void tell_of_blocks(vtkExodusIIReader* reader, LoadedFile* out) {
  constexpr int kKind = vtkExodusIIReader::ELEM_BLOCK;
  vtkNew<vtkIntArray> ids;
  ids->SetName(kBlockIds);
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
  for (const auto& piece : out->pieces) piece->GetFieldData()->RemoveArray(kBlockIds);
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

}  // namespace

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
  mend_curved_elements(path, *out);
  tell_of_blocks(reader, out);
  tell_of_sets(reader, out);
  tell_of_steps(options.time_step.has_value(), out);
}
#else
namespace {

[[noreturn]] void refuse_exodus(const std::string& path) {
  throw Error(ErrorCode::kBadInput, path + ": this build's VTK has no Exodus reader (IOExodus)");
}

}  // namespace

std::vector<double> find_time_steps(const std::string& path) { refuse_exodus(path); }
void load_exodus(const std::string& path, const OpenOptions&, const TrapScope&, LoadedFile*) {
  refuse_exodus(path);
}
#endif

}  // namespace tetfusion
