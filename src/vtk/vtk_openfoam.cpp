// OpenFOAM cases: a folder, of which a file in it is given.

#include "vtk/vtk_reader.h"

#ifdef TETFUSION_HAS_GEOMETRY
#include <vtkCompositeDataSet.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkOpenFOAMReader.h>
#include <vtkStringArray.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string_view>
#include <vector>

#include "io/files/mapped_file.h"
#endif

#include "base/error.h"
#include "vtk/versions/vtk_versions.h"
#include "vtk/vtk_collect.h"

namespace tetfusion {

#ifdef TETFUSION_HAS_GEOMETRY
namespace {

namespace fs = std::filesystem;

constexpr char kConstant[] = "constant";  // the folder of what is the same at all times

std::string folder_of(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  const bool is_dictionary = fs::path(path).filename().string().starts_with("controlDict");
  return (is_dictionary ? folder / ".." : folder).lexically_normal().string();
}

bool is_there(const fs::path& file) {
  std::error_code unknown;
  return fs::exists(file, unknown) || fs::exists(file.string() + ".gz", unknown);
}

void check_case(const std::string& path, const fs::path& folder) {
  std::error_code unknown;
  std::error_code end;
  bool has_mesh = is_there(folder / kConstant / "polyMesh" / "faces");
  for (const auto& entry : fs::directory_iterator(folder / kConstant, end)) {
    has_mesh = has_mesh || is_there(entry.path() / "polyMesh" / "faces");
  }
  if (has_mesh) return;
  if (fs::exists(folder / "processor0", unknown) || fs::exists(folder / "processors", unknown)) {
    throw Error(ErrorCode::kBadInput,
                path +
                    ": the case is decomposed (processor0, ...), and only reconstructed ones are "
                    "read: let reconstructParMesh and reconstructPar join it first");
  }
  throw Error(ErrorCode::kBadInput, path + ": there is no mesh in this case: " +
                                        (folder / kConstant / "polyMesh" / "faces").string() +
                                        " is missing");
}

void add_files_in(const fs::path& folder, std::vector<std::string>* files) {
  std::error_code not_there;
  std::vector<std::string> found;
  for (const auto& entry : fs::directory_iterator(folder, not_there)) {
    std::error_code unknown;
    if (entry.is_regular_file(unknown)) found.push_back(entry.path().string());
  }
  std::sort(found.begin(), found.end());
  files->insert(files->end(), found.begin(), found.end());
}

// Of parentheses and braces that are opened and not closed, comments and texts left out.
std::size_t end_of_text(std::string_view text, std::size_t begin) {
  std::size_t at = text.find_first_of("\"\\", begin + 1);
  while (at != std::string_view::npos && text[at] == '\\') at = text.find_first_of("\"\\", at + 2);
  return at == std::string_view::npos ? at : at + 1;
}

std::int64_t open_brackets(std::string_view text) {
  std::int64_t open = 0;
  while (!text.empty()) {
    const std::size_t at = text.find_first_of("(){}/\"");
    if (at == std::string_view::npos) break;
    const bool is_line = text.substr(at).starts_with("//");
    const bool is_block = text.substr(at).starts_with("/*");
    open += text[at] == '(' || text[at] == '{' ? 1 : 0;
    open -= text[at] == ')' || text[at] == '}' ? 1 : 0;
    std::size_t next = at + 1;
    if (is_line) next = text.find('\n', at);
    if (is_block) next = text.find("*/", at + 2);
    if (text[at] == '"') next = end_of_text(text, at);
    if (next == std::string_view::npos) break;
    text.remove_prefix(next);
  }
  return open;
}

// The class that a file's head gives; empty: none that can be read.
std::string class_in(const std::string& file) {
  std::string head(4096, '\0');
  const gzFile stream = gzopen(file.c_str(), "rb");  // or what is not packed
  if (stream == nullptr) return "";
  const int got = gzread(stream, head.data(), static_cast<unsigned>(head.size()));
  gzclose_r(stream);
  head.resize(static_cast<std::size_t>(std::max(got, 0)));
  const std::size_t key = head.find("class");
  const std::size_t begin =
      head.find_first_not_of(" \t\r\n", key == std::string::npos ? key : key + 5);
  if (head.find("FoamFile") == std::string::npos || begin == std::string::npos) return "";
  return head.substr(begin, head.find_first_of("; \t\r\n", begin) - begin);
}

// Fields on faces, or of what VTK's reader does not know.
bool is_unread_field(const std::string& kind) {
  return kind.ends_with("Field") && !kind.starts_with("vol") && !kind.starts_with("point");
}

// VTK passes over one whose beginning it cannot read.
void check_packed(const std::string& path, const std::string& file) {
  std::vector<char> block(std::size_t{1} << 18);
  const gzFile packed = gzopen(file.c_str(), "rb");
  int got = packed == nullptr ? -1 : 1;
  while (got > 0) got = gzread(packed, block.data(), static_cast<unsigned>(block.size()));
  // What is cut off shows in the end.
  const int end = packed == nullptr ? Z_ERRNO : gzclose_r(packed);
  if (got == 0 && end == Z_OK) return;
  throw Error(ErrorCode::kBadInput, path + ": " + file + " is cut off or damaged");
}

// VTK takes a field for one of fewer values where its file is cut off.
void check_whole(const std::string& path, const std::string& file) {
  if (file.ends_with(".gz")) return check_packed(path, file);
  const MappedFile mapped = MappedFile::open(file);
  const std::string_view text(reinterpret_cast<const char*>(mapped.bytes().data()), mapped.size());
  const std::string_view head = text.substr(0, 4096);
  const bool is_text = head.find("FoamFile") != std::string_view::npos &&
                       head.find("binary") == std::string_view::npos;
  if (!is_text || open_brackets(text) == 0) return;
  throw Error(ErrorCode::kBadInput,
              path + ": in " + file + " a bracket is not closed: it is cut off or damaged");
}

class OpenFoamReader : public FileReader {
 public:
  OpenFoamReader(const std::string& path, const TrapScope& trap)
      : path_(path), trap_(trap), folder_(folder_of(path)) {
    check_case(path, folder_);
    // VTK looks for the folder in the name.
    reader_->SetFileName(fs::absolute(path).lexically_normal().c_str());
    reader_->SetCreateCellToPoint(false);  // the arrays of the case alone
    vtk_version::keep_polyhedra(reader_.Get());
    reader_->UpdateInformation();
    trap.check(path);
  }

  // Where there is no folder of a time VTK takes the fields in 'constant', and says 0.
  std::vector<double> time_steps() override {
    vtkStringArray* const names = reader_->GetTimeNames();
    const bool has_times = names != nullptr && names->GetNumberOfValues() > 0 &&
                           std::string(names->GetValue(0)) != kConstant;
    return has_times ? time_steps_in(reader_) : std::vector<double>{};
  }

  void load(std::size_t step, LoadedFile* out) override {
    choose_parts(out);
    name_files(step, out);
    for (const std::string& file : out->files) {
      check_whole(path_, file);
      const std::string kind = class_in(file);
      const bool is_of_mesh = fs::path(file).parent_path().filename() == "polyMesh";
      if (is_of_mesh || !is_unread_field(kind)) continue;
      std::string name = fs::path(file).filename().string();
      if (name.ends_with(".gz")) name.resize(name.size() - 3);
      out->left_out.push_back(name.append(" (").append(kind).append(")"));
    }
    reader_->EnableAllCellArrays();
    reader_->EnableAllPointArrays();
    update_to_step(reader_, time_steps(), step);
    trap_.check(path_);
    add_region(reader_->GetOutput(), "", out);
    mark_blocks(out);
  }

 private:
  // The inner mesh and the patches.
  void choose_parts(LoadedFile* out) {
    for (int i = 0; i < reader_->GetNumberOfPatchArrays(); ++i) {
      const std::string name = reader_->GetPatchArrayName(i);
      const auto has = [&](std::string_view part) { return name.find(part) != std::string::npos; };
      const bool is_group = has("group/");  // its patches have names of their own
      const bool wanted = !is_group && (name.ends_with("internalMesh") || has("patch/"));
      reader_->SetPatchArrayStatus(name.c_str(), wanted ? 1 : 0);
      if (!wanted && !is_group) out->left_out.push_back("'" + name + "'");
    }
  }

  // Of several regions each has a block of blocks of its own.
  void add_region(vtkMultiBlockDataSet* region, const std::string& prefix, LoadedFile* out) {
    for (unsigned i = 0; i < region->GetNumberOfBlocks(); ++i) {
      const char* const told = region->HasMetaData(i) != 0
                                   ? region->GetMetaData(i)->Get(vtkCompositeDataSet::NAME())
                                   : nullptr;
      const std::string name = told != nullptr ? told : "";
      vtkDataObject* const block = region->GetBlock(i);
      if (auto* const inner = vtkMultiBlockDataSet::SafeDownCast(block)) {
        add_region(inner, name == "boundary" ? prefix : prefix + name + "/", out);
      } else {
        add_block(block, prefix + name, path_, out);
      }
    }
  }

  // What VTK looks for: the mesh in 'constant', or in the folder of the last time that has another
  // one, and the fields in the folder of the time; of each region in a folder below these.
  void name_files(std::size_t step, LoadedFile* out) {
    vtkStringArray* const names = reader_->GetTimeNames();
    if (names == nullptr || static_cast<vtkIdType>(step) >= names->GetNumberOfValues()) return;
    std::vector<std::string> times{kConstant};
    for (std::size_t i = 0; i <= step; ++i) {
      times.push_back(names->GetValue(static_cast<vtkIdType>(i)));
    }
    std::set<fs::path> meshes;
    for (const std::string& region : regions()) {
      for (const char* const file : {"faces", "points"}) {
        const auto last = std::find_if(times.rbegin(), times.rend(), [&](const std::string& time) {
          return is_there(folder_ / time / region / "polyMesh" / file);
        });
        if (last == times.rend()) continue;
        meshes.insert(folder_ / *last / region / "polyMesh");
      }
      add_files_in(folder_ / times.back() / region, &out->files);
    }
    for (const fs::path& mesh : meshes) {
      add_files_in(mesh, &out->files);
      for (const char* const zones : {"cellZones", "faceZones", "pointZones"}) {
        if (is_there(mesh / zones)) out->left_out.emplace_back(zones);
      }
    }
  }

  std::vector<std::string> regions() const {
    std::vector<std::string> found{""};
    std::error_code not_there;
    for (const auto& entry : fs::directory_iterator(folder_ / kConstant, not_there)) {
      if (is_there(entry.path() / "polyMesh" / "faces")) {
        found.push_back(entry.path().filename().string());
      }
    }
    std::sort(found.begin(), found.end());
    return found;
  }

  const std::string& path_;
  const TrapScope& trap_;
  fs::path folder_;
  vtkNew<vtkOpenFOAMReader> reader_;
};

}  // namespace

std::unique_ptr<FileReader> open_openfoam(const std::string& path, const TrapScope& trap) {
  return std::make_unique<OpenFoamReader>(path, trap);
}
#else
std::unique_ptr<FileReader> open_openfoam(const std::string& path, const TrapScope&) {
  refuse_without(path, "IOGeometry", "OpenFOAM");
}
#endif

}  // namespace tetfusion
