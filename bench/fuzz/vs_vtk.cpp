// The reader of .vtu files beside VTK's, for libFuzzer: what ours gives, VTK's gives, too, point by
// point, cell by cell and byte by byte of each array; and what ours refuses VTK's refuses, but for
// the reasons in kLaxer, for which it is knowingly laxer.
#include <sys/wait.h>
#include <unistd.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>

#include "base/error.h"
#include "fuzz/mutate_xml.h"
#include "fuzz/read_all.h"
#include "fuzz/targets.h"
#include "io/vtk/vtu_reader.h"

namespace tetfusion::fuzz {

namespace {

// Parts of our messages. VTK takes words that it does not know for others, fills up what an array
// lacks, leaves out what it has too much, and does not look at the mesh.
constexpr std::array kLaxer = {
    // words
    "unknown format", "unknown type", "unknown byte_order", "unknown header_type",
    "unknown encoding", "unknown compressor", "its type is", "is not known",
    "cannot read the version", "NumberOfComponents is", "NumberOfTuples is", "offset is",
    "must be numbers", "two arrays called", "more than one array", "is missing", "are missing",
    "is in piece", "in the pieces before it", "strings are read in field data only",
    "expected integers", "components, expected 3", "too many components", "CDATA sections",
    "an array's data is in two parts",
    // arrays
    "values of type", " values, found ", "is not a number of type", "is not base64",
    "not a whole number of", "no whole number of tuples", "more than there is room for",
    "bytes, but only", "but the cells end at", "lies outside of the file",
    "its data cannot be found", "block sizes in its header", "compressed block",
    "but the file has no <AppendedData>", "behind the end",
    // meshes
    "uses point", "not finite", "has the type", "VTK cell type", "must end at", " goes from ",
    "vertices", "has no cells", "no tetrahedra", "points, more than"};

class CountedErrors : public vtkOutputWindow {
 public:
  static CountedErrors* New();
  vtkTypeMacro(CountedErrors, vtkOutputWindow);
  void DisplayText(const char*) override {}
  void DisplayErrorText(const char* text) override {
    if (++count == 1) first = text;
  }
  void DisplayWarningText(const char*) override {}
  void DisplayGenericWarningText(const char*) override {}
  void DisplayDebugText(const char*) override {}
  int count = 0;
  std::string first;

 protected:
  CountedErrors() = default;
};
vtkStandardNewMacro(CountedErrors);

CountedErrors& errors() {
  static vtkNew<CountedErrors> window;
  vtkOutputWindow::SetInstance(window);
  return *window.Get();
}

// Nothing where it is refused, be it by an exception of the standard library's.
vtkSmartPointer<vtkUnstructuredGrid> read_with_vtk(Input input) try {
  CountedErrors& seen = errors();
  seen.count = 0;
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->ReadFromInputStringOn();
  reader->SetInputString(std::string(reinterpret_cast<const char*>(input.data()), input.size()));
  reader->Update();
  if (seen.count > 0 || reader->GetErrorCode() != 0) return nullptr;
  return reader->GetOutput();
} catch (const std::exception& e) {
  errors().first = e.what();
  return nullptr;
}

struct Mesh {
  MeshDescription description;
  Geometry geometry;
  std::vector<DataArray> points, cells;
};

[[noreturn]] void differ(const std::string& what) { throw std::logic_error("beside VTK: " + what); }

class Comparison {
 public:
  Comparison(const Mesh& ours, vtkUnstructuredGrid* theirs) : ours_(ours), theirs_(theirs) {}

  void run() {
    if (static_cast<std::uint64_t>(theirs_->GetNumberOfPoints()) != ours_.description.points)
      differ("points");
    if (static_cast<std::uint64_t>(theirs_->GetNumberOfCells()) != ours_.description.cells)
      differ("cells");
    for (VertexId v = 0; v < point_count(ours_.geometry.points); ++v) compare_point(v);
    for (std::size_t t = 0; t < ours_.geometry.tets.size(); ++t) {
      compare_cell(row(ours_.geometry.tet_source, t), 10, ours_.geometry.tets[t].data(), 4);
    }
    const LowerCells& lower = ours_.geometry.lower;
    for (std::size_t i = 0; i < lower.size(); ++i) {
      compare_cell(row(ours_.geometry.lower_source, i), lower.types[i],
                   &lower.connectivity[lower.offsets[i]], lower.offsets[i + 1] - lower.offsets[i]);
    }
    for (const DataArray& a : ours_.points) compare_array(a, theirs_->GetPointData());
    for (const DataArray& a : ours_.cells) compare_array(a, theirs_->GetCellData());
  }

 private:
  static vtkIdType row(const Vector<std::uint64_t>& rows, std::size_t i) {
    return static_cast<vtkIdType>(rows.empty() ? i : rows[i]);
  }

  void compare_point(VertexId v) const {
    std::array<double, 3> theirs{};
    theirs_->GetPoint(row(ours_.geometry.point_source, v), theirs.data());
    std::visit(
        [&](const auto& points) {
          const std::array<double, 3> ours{points[v].x, points[v].y, points[v].z};
          if (std::memcmp(ours.data(), theirs.data(), sizeof ours) != 0) differ("coordinates");
        },
        ours_.geometry.points);
  }

  // Points of other pieces that ours were merged with lie in the same place, to the bit.
  void compare_cell(vtkIdType cell, int type, const VertexId* corners, std::size_t count) const {
    vtkIdType size = 0;
    const vtkIdType* ids = nullptr;
    if (theirs_->GetCellType(cell) != type) differ("a cell's type");
    theirs_->GetCellPoints(cell, size, ids);
    if (static_cast<std::size_t>(size) != count) differ("a cell's size");
    for (std::size_t k = 0; k < count; ++k) {
      const vtkIdType ours = row(ours_.geometry.point_source, corners[k]);
      if (ids[k] < 0 || ids[k] >= theirs_->GetNumberOfPoints()) differ("a cell's point");
      std::array<double, 3> a{}, b{};
      theirs_->GetPoint(ids[k], a.data());
      theirs_->GetPoint(ours, b.data());
      if (ids[k] != ours && a != b) differ("a cell's corner");
    }
  }

  static void compare_array(const DataArray& ours, vtkFieldData* data) {
    vtkDataArray* const theirs = data->GetArray(ours.info.name.c_str());
    if (theirs == nullptr) differ("no array " + ours.info.name);
    const std::size_t bytes = static_cast<std::size_t>(theirs->GetNumberOfValues()) *
                              static_cast<std::size_t>(theirs->GetDataTypeSize());
    if (static_cast<std::uint32_t>(theirs->GetNumberOfComponents()) != ours.info.components) {
      differ("components of " + ours.info.name);
    }
    if (bytes != ours.bytes.size()) differ("the length of " + ours.info.name);
    if (bytes > 0 && std::memcmp(theirs->GetVoidPointer(0), ours.bytes.data(), bytes) != 0) {
      differ("the values of " + ours.info.name);
    }
  }

  const Mesh& ours_;
  vtkUnstructuredGrid* theirs_;
};

Mesh read_ours(Input input) {
  const auto source = open_vtu(memory_file(input, "input.vtu"), {});
  Mesh mesh{source->description(), source->read_geometry(), {}, {}};
  for (std::size_t i = 0; i < mesh.description.point_data.arrays.size(); ++i) {
    mesh.points.push_back(source->read_array(Association::kPoint, i));
  }
  for (std::size_t i = 0; i < mesh.description.cell_data.arrays.size(); ++i) {
    mesh.cells.push_back(source->read_array(Association::kCell, i));
  }
  return mesh;
}

// In a process of its own, which VTK may bring to an end.
bool vtk_takes(Input input) {
  const pid_t child = ::fork();
  if (child == 0) {
    // The fuzzer's handlers would take it for its own.
    for (const int s : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL}) std::signal(s, SIG_DFL);
    ::_exit(read_with_vtk(input) != nullptr ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

bool is_excused(std::string_view message) {
  return std::any_of(kLaxer.begin(), kLaxer.end(),
                     [&](std::string_view part) { return message.find(part) != message.npos; });
}

// VTK minds characters that XML does not allow, and elements where it expects none; ours passes
// over them. The latter it refuses without a word of its own.
bool is_stricter(std::string_view message) {
  return message.find("vtkXMLParser") != message.npos ||
         message.find("Request: REQUEST_INFORMATION") != message.npos;
}

void compare(Input input) {
  Mesh ours;
  try {
    ours = read_ours(input);
  } catch (const Error& e) {
    if (!is_excused(e.what()) && vtk_takes(input))
      differ(std::string("only ours refuses: ") + e.what());
    return;
  }
  const auto theirs = read_with_vtk(input);
  if (theirs == nullptr) {
    if (is_stricter(errors().first)) return;
    differ("only VTK refuses: " + errors().first);
  }
  Comparison(ours, theirs).run();
}

}  // namespace

}  // namespace tetfusion::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    tetfusion::fuzz::compare({data, size});
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    std::abort();
  }
  return 0;
}

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  return tetfusion::fuzz::mutate_xml(data, size, max_size, seed, LLVMFuzzerMutate);
}
