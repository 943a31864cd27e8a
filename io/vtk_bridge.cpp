#include "io/vtk_bridge.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <utility>
#include <vector>

#include "base/error.h"
#include "io/foreign_format.h"
#include "io/source/reading_memory.h"
#include "io/vtk_plugin.h"

namespace tetfusion {
namespace {

void throw_if_failed(const PluginStatus& status) {
  if (status.invalid_mesh) throw InvalidMesh(status.message);
  if (status.failed) throw Error(status.code, status.message);
}

class VtkSource : public MeshSource {
 public:
  VtkSource(std::unique_ptr<PluginMesh> mesh, const std::string& what)
      : mesh_(std::move(mesh)), description_(mesh_->description()) {
    if (!what.empty()) description_.format = what.substr(what.find(' ') + 1) + ", read with VTK";
  }

  const MeshDescription& description() const override { return description_; }

  Geometry read_geometry() override {
    Geometry geometry;
    throw_if_failed(mesh_->read_geometry(&geometry));
    return geometry;
  }

  std::uint64_t memory_to_read() override {
    // VTK's grid stays, and so does what is known of its points: whether a cell uses them, and
    // what they are copies of.
    constexpr std::uint64_t kPointBytes = 1 + sizeof(VertexId);
    const MeshDescription& d = description();
    return tetfusion::memory_to_read(d, mesh_->cell_types()) + mesh_->bytes_of_cells() +
           d.points * (3 * size_of(d.point_type) + kPointBytes) + bytes_of(d.point_data) +
           bytes_of(d.cell_data);
  }

  DataArray read_array(Association association, std::size_t index) override {
    DataArray array;
    throw_if_failed(mesh_->read_array(association, index, &array));
    return array;
  }

 private:
  std::unique_ptr<PluginMesh> mesh_;
  MeshDescription description_;
};

std::vector<std::filesystem::path> plugin_folders() {
  std::vector<std::filesystem::path> folders;
  const char* wanted = std::getenv("TETFUSION_PLUGIN_PATH");
  if (wanted != nullptr && *wanted != '\0') folders.emplace_back(wanted);
  std::error_code failed;
  const auto executable = std::filesystem::read_symlink("/proc/self/exe", failed);
  if (!failed) {
    folders.push_back(executable.parent_path());
    folders.push_back(executable.parent_path().parent_path() / "lib" / "tetfusion");
  }
  return folders;
}

[[noreturn]] void throw_missing(const std::string& file,
                                const std::vector<std::filesystem::path>& folders) {
  std::string looked;
  for (const auto& folder : folders) looked += (looked.empty() ? "" : ", ") + folder.string();
  throw Error(
      ErrorCode::kBadInput,
      file +
          ". Only .vtu, .pvtu, .vtk of unstructured grids, Medit, Gmsh and TetGen files are read "
          "without VTK, and the VTK "
          "reader plugin (" +
          kVtkPluginFile + ") is not installed (looked in " + looked +
          "). Build TetFusion with VTK 9.1 or newer (Debian: apt install libvtk9-dev; cmake "
          "-DTETFUSION_VTK=ON), or convert the file to .vtu");
}

// The module, which stays loaded until the process ends: VTK does not like to be unloaded. `file`
// says what it is needed for.
const VtkPlugin* load_plugin(const std::string& file) {
  const auto folders = plugin_folders();
  std::filesystem::path path;
  std::error_code ignored;
  for (const auto& folder : folders) {
    if (std::filesystem::exists(folder / kVtkPluginFile, ignored)) {
      path = folder / kVtkPluginFile;
      break;
    }
  }
  if (path.empty()) throw_missing(file, folders);

  const std::string needed = file + ". It is read with VTK, but the plugin " + path.string();
  void* module = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (module == nullptr) {
    const char* why = ::dlerror();
    throw Error(ErrorCode::kBadInput,
                needed + " cannot be loaded: " + (why != nullptr ? why : "unknown reason") +
                    ". Is VTK's run-time library installed?");
  }
  const auto entry = reinterpret_cast<VtkPluginEntry>(::dlsym(module, kVtkPluginEntry));
  if (entry == nullptr) {
    throw Error(ErrorCode::kBadInput, needed + " is not a plugin of TetFusion");
  }
  const VtkPlugin* plugin = entry();
  if (plugin->interface_version != kVtkPluginInterface ||
      std::strcmp(plugin->program_version, TETFUSION_VERSION) != 0) {
    throw Error(ErrorCode::kBadInput, needed +
                                          " belongs to another version of TetFusion: build or "
                                          "install both together");
  }
  return plugin;
}

// VTK's readers, their libraries and its window for messages are for one thread, and a child that
// is forked meanwhile would find their locks taken.
std::mutex& vtk_readers() {
  static std::mutex mutex;
  return mutex;
}

[[noreturn]] void throw_unknown(const std::string& path) {
  throw Error(
      ErrorCode::kBadInput,
      path +
          ": not a mesh file that is read: neither its beginning nor its name says one of the "
          "formats of VTK (.vtu, .vtk, VTKHDF and others), Exodus, CGNS, XDMF, EnSight (.case), "
          "OpenFOAM (.foam), Medit, Gmsh and TetGen");
}

}  // namespace

std::unique_ptr<MeshSource> open_with_vtk(const std::string& path, const OpenOptions& options,
                                          const std::string& what) {
  const FormatGuess guess = guess_format_of(path);
  if (guess.is_list) {
    throw Error(ErrorCode::kBadInput,
                path +
                    ": this is a list of the steps of a series: give one of the files that it "
                    "names, or its number (--time-step); the commands take the list, called .pvd "
                    "or .series");
  }
  if (guess.format == ForeignFormat::kUnknown) throw_unknown(path);
  const VtkPlugin* plugin = load_plugin(path + ": this is " + (what.empty() ? guess.words : what));
  std::unique_ptr<PluginMesh> mesh;
  const std::lock_guard lock(vtk_readers());
  throw_if_failed(plugin->open(path, options, &mesh));
  return std::make_unique<VtkSource>(std::move(mesh), what);
}

std::vector<double> time_steps_with_vtk(const std::string& path, const OpenOptions& options) {
  const VtkPlugin* plugin = load_plugin(path + ": this is " + guess_format_of(path).words);
  std::vector<double> times;
  const std::lock_guard lock(vtk_readers());
  throw_if_failed(plugin->time_steps(path, options, &times));
  return times;
}

}  // namespace tetfusion
