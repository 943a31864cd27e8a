// The readers of single files, and of several.
#include <unistd.h>

#include <array>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/error.h"
#include "fuzz/read_all.h"
#include "fuzz/targets.h"
#include "io/gmsh/gmsh_reader.h"
#include "io/medit/medit_reader.h"
#include "io/tetgen/tetgen_reader.h"
#include "io/vtk/pvtu_reader.h"
#include "io/vtk/series_list.h"
#include "io/vtk/vtu_reader.h"
#include "support/temp_dir.h"
#include "support/vtu_text.h"

namespace tetfusion::fuzz {

namespace {

using Open = std::unique_ptr<MeshSource> (*)(MappedFile, const OpenOptions&);

void read_file(Input input, const char* name, Open open) try {
  read_all(open(memory_file(input, name), options_of(input)).get());
} catch (const Error&) {
}

std::vector<std::string> parts_of(Input input) {
  const std::string_view text(reinterpret_cast<const char*>(input.data()), input.size());
  std::vector<std::string> parts;
  for (std::size_t from = 0;;) {
    const std::size_t to = text.find(kCut, from);
    parts.emplace_back(text.substr(from, to - from));
    if (to == text.npos) return parts;
    from = to + kCut.size();
  }
}

// Kept in memory, and for the whole process: making and removing a folder takes longer than most
// inputs.
const testing::TempDir& folder() {
  static const testing::TempDir dir = testing::TempDir::in_memory();
  return dir;
}

void write_or_remove(const std::string& name, const std::string* bytes) {
  if (bytes != nullptr) {
    testing::write_file(folder().file(name), *bytes);
  } else {
    ::unlink(folder().file(name).c_str());
  }
}

}  // namespace

void read_vtu(Input input) { read_file(input, "input.vtu", open_vtu); }
void read_legacy(Input input) { read_file(input, "input.vtk", open_legacy_vtk); }
void read_medit(Input input) { read_file(input, "input.mesh", open_medit); }
void read_gmsh(Input input) { read_file(input, "input.msh", open_gmsh); }

void read_tetgen(Input input) {
  constexpr std::array<const char*, 4> kNames{"m.node", "m.ele", "m.face", "m.edge"};
  const std::vector<std::string> parts = parts_of(input);
  for (std::size_t i = 0; i < kNames.size(); ++i)
    write_or_remove(kNames[i], i < parts.size() ? &parts[i] : nullptr);
  try {
    read_all(open_tetgen(MappedFile::open(folder().file("m.node")), options_of(input)).get());
  } catch (const Error&) {
  }
}

void read_pvtu(Input input) {
  constexpr std::size_t kPieces = 3;
  const std::vector<std::string> parts = parts_of(input);
  for (std::size_t i = 0; i < kPieces; ++i) {
    write_or_remove(std::to_string(i) + ".vtu", i + 1 < parts.size() ? &parts[i + 1] : nullptr);
  }
  write_or_remove("m.pvtu", parts.data());
  try {
    std::string why;
    const auto source =
        open_pvtu(MappedFile::open(folder().file("m.pvtu")), options_of(input), &why);
    if (source) read_all(source.get());
  } catch (const Error&) {
  }
}

void read_pvd_list(Input input) {
  const std::string bytes(reinterpret_cast<const char*>(input.data()), input.size());
  write_or_remove("m.pvd", &bytes);
  try {
    for (const ListedStep& step : read_series_list(folder().file("m.pvd"))) {
      if (!step.path.starts_with(folder().path().string())) throw std::logic_error(step.path);
    }
  } catch (const Error&) {
  }
}

}  // namespace tetfusion::fuzz
