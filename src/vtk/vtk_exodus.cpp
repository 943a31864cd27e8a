#include "vtk/vtk_reader.h"

#ifdef TETFUSION_HAS_EXODUS
#include <vtkCell.h>
#include <vtkCellArray.h>
#include <vtkCharArray.h>
#include <vtkDataArray.h>
#include <vtkExodusIIReader.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointSet.h>
#include <vtkPoints.h>
#include <vtkStringArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtk_exodusII.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#include "io/files/mapped_file.h"
#include "vtk/netcdf_length.h"
#endif

#include "base/error.h"
#include "mesh/split_cells.h"
#include "vtk/vtk_collect.h"

namespace tetfusion {

#ifdef TETFUSION_HAS_EXODUS
namespace {

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
  bool has_attributes = false;
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
                        static_cast<std::size_t>(nodes), attributes > 0};
  }

  // Nodes of one element after another, counted from 1; none: they cannot be read.
  std::vector<int> nodes(int id, const ElementBlock& block) const {
    std::vector<int> nodes(block.elements * block.nodes);
    if (ex_get_conn(file_, EX_ELEM_BLOCK, id, nodes.data(), nullptr, nullptr) < 0) nodes.clear();
    return nodes;
  }

  // Whether the library finds the values of all variables of the nodes. Where it does not it warns,
  // and VTK takes what happens to lie in memory for the values.
  bool has_nodal_values(std::size_t step) const {
    int variables = 0;
    if (ex_get_variable_param(file_, EX_NODAL, &variables) < 0) return false;
    double one = 0;
    for (int i = 1; i <= variables; ++i) {
      if (ex_get_partial_var(file_, static_cast<int>(step) + 1, EX_NODAL, i, 1, 1, 1, &one) !=
          EX_NOERR) {
        return false;
      }
    }
    return true;
  }

 private:
  int file_ = -1;
};

// Of elements, such as thicknesses of shells, which are not read either.
void tell_of_attributes(const std::string& path, vtkExodusIIReader* reader, LoadedFile* out) {
  constexpr int kBlocks = vtkExodusIIReader::ELEM_BLOCK;
  const ExodusFile file(path);
  for (int i = 0; i < reader->GetNumberOfObjects(kBlocks); ++i) {
    const auto block = file.block(reader->GetObjectId(kBlocks, i));
    if (!block || !block->has_attributes) continue;
    out->left_out.push_back(std::string("attributes of the elements of '") +
                            reader->GetObjectName(kBlocks, i) + "'");
  }
}

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

// All blocks have the file's points, and so each gets the same array of them.
void share_points(const std::string& path, const LoadedFile& loaded) {
  vtkPoints* points = nullptr;
  for (const auto& piece : loaded.pieces) {
    auto* const grid = vtkPointSet::SafeDownCast(piece);
    if (grid == nullptr || grid->GetPoints() == nullptr) continue;
    if (points == nullptr) points = grid->GetPoints();
    if (grid->GetNumberOfPoints() != points->GetNumberOfPoints()) {
      throw Error(ErrorCode::kBadInput, path + ": VTK read blocks with different points from it");
    }
    grid->SetPoints(points);
  }
}

// What is not there would be zeros.
void require_whole(const std::string& path, std::uint64_t steps) {
  const MappedFile file = MappedFile::open(path);
  const std::uint64_t length = netcdf_length(file.bytes(), steps);
  if (length <= file.size()) return;
  throw Error(ErrorCode::kBadInput,
              path + ": it was cut off: it ends after " + std::to_string(file.size()) +
                  " bytes, and by its header has values up to byte " + std::to_string(length));
}

// VTK's rows of characters, as QA_Records, have whatever lay in memory behind the end of a text.
void clear_behind_texts(LoadedFile* out) {
  for (const auto& data : out->field_data) {
    for (int i = 0; i < data->GetNumberOfArrays(); ++i) {
      auto* const texts = vtkCharArray::SafeDownCast(data->GetAbstractArray(i));
      if (texts == nullptr) continue;
      const auto width = static_cast<std::size_t>(texts->GetNumberOfComponents());
      for (vtkIdType t = 0; t < texts->GetNumberOfTuples(); ++t) {
        char* const text = texts->GetPointer(t * texts->GetNumberOfComponents());
        std::fill(std::find(text, text + width, '\0'), text + width, '\0');
      }
    }
  }
}

class ExodusReader : public FileReader {
 public:
  ExodusReader(const std::string& path, const TrapScope& trap) : path_(path), trap_(trap) {
    ex_opts(0);  // print nothing from here on
    reader_->SetFileName(path.c_str());
    reader_->UpdateInformation();
    trap.check(path);
  }

  std::vector<double> time_steps() override { return time_steps_in(reader_); }

  void load(std::size_t step, LoadedFile* out) override {
    require_whole(path_, step + 1);
    reader_->SetApplyDisplacements(false);  // the coordinates that the file holds
    // Squeezed points would be Float32 whatever the file has. So all blocks get all points of the
    // file, and the cache lets them share one copy.
    reader_->SetSqueezePoints(false);
    reader_->SetCacheSize(kCacheMebibytes);
    reader_->SetTimeStep(static_cast<int>(step));
    if (!time_steps().empty()) {  // else results have names, but no values
      if (!ExodusFile(path_).has_nodal_values(step)) {
        throw Error(ErrorCode::kBadInput,
                    path_ +
                        ": the Exodus library does not find the values at the nodes, as in "
                        "files that meshio writes: convert it to .vtu with what made it");
      }
      choose_arrays();
    }
    for (int i = 0; i < reader_->GetNumberOfObjects(vtkExodusIIReader::ELEM_BLOCK); ++i) {
      reader_->SetObjectStatus(vtkExodusIIReader::ELEM_BLOCK, i, 1);
    }
    reader_->Update();
    trap_.check(path_);
    collect(reader_->GetOutput(), path_, out);
    share_points(path_, *out);
    mend_curved_elements(path_, *out);
    clear_behind_texts(out);
    tell_of_blocks(reader_, out);
    tell_of_sets(reader_, out);
    tell_of_attributes(path_, reader_, out);
  }

 private:
  // Global variables come as field data, with their values at all steps.
  void choose_arrays() {
    for (const int kind :
         {vtkExodusIIReader::NODAL, vtkExodusIIReader::ELEM_BLOCK, vtkExodusIIReader::GLOBAL}) {
      for (int i = 0; i < reader_->GetNumberOfObjectArrays(kind); ++i) {
        reader_->SetObjectArrayStatus(kind, i, 1);
      }
    }
  }

  const std::string& path_;
  const TrapScope& trap_;
  vtkNew<vtkExodusIIReader> reader_;
};

}  // namespace

// The library insists on printing why it cannot open a file.
bool is_exodus(const std::string& path) {
  vtkNew<vtkExodusIIReader> reader;
  const StandardErrorCaught caught;
  return reader->CanReadFile(path.c_str()) != 0;
}

std::unique_ptr<FileReader> open_exodus(const std::string& path, const TrapScope& trap) {
  if (!is_exodus(path)) {
    throw Error(ErrorCode::kBadInput, path + ": is not an Exodus II file, or is damaged");
  }
  return std::make_unique<ExodusReader>(path, trap);
}
#else
bool is_exodus(const std::string&) { return false; }

std::unique_ptr<FileReader> open_exodus(const std::string& path, const TrapScope&) {
  refuse_without(path, "IOExodus", "Exodus");
}
#endif

}  // namespace tetfusion
