// The contract between the core and the module tetfusion-vtk.so, which reads with VTK.
//
// Both sides are built from one tree by one compiler, and the core refuses a module of another
// version, so that C++ types may cross. Exceptions may not: the two sides need not agree on their
// type information. Memory may be allocated on one side and freed on the other (base/vector.h keeps
// no state).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "io/source/mesh_source.h"
#include "io/source/reading_memory.h"

namespace tetfusion {

// Raised whenever anything in this header, in io/source/mesh_source.h or in the types that they use
// changes.
inline constexpr std::uint32_t kVtkPluginInterface = 12;
inline constexpr char kVtkPluginFile[] = "tetfusion-vtk.so";
inline constexpr char kVtkPluginEntry[] = "tetfusion_vtk_plugin";

// What becomes an Error on the core's side.
struct PluginStatus {
  bool failed = false;
  bool invalid_mesh = false;  // an InvalidMesh
  ErrorCode code = ErrorCode::kBadInput;
  std::string message;
};

// MeshSource without exceptions.
class PluginMesh {
 public:
  virtual ~PluginMesh() = default;
  virtual const MeshDescription& description() const noexcept = 0;
  // Polyhedra counted as the tetrahedra that they become.
  virtual const CellTypeCounts& cell_types() const noexcept = 0;
  virtual std::uint64_t bytes_of_cells() const noexcept = 0;  // as VTK holds them
  virtual PluginStatus read_geometry(Geometry* out) noexcept = 0;
  virtual PluginStatus read_array(Association association, std::size_t index,
                                  DataArray* out) noexcept = 0;
};

// The first two members keep their place for ever: they tell whether the others can be trusted.
struct VtkPlugin {
  std::uint32_t interface_version;
  const char* program_version;
  PluginStatus (*open)(const std::string& path, const OpenOptions& options,
                       std::unique_ptr<PluginMesh>* out) noexcept;
  PluginStatus (*time_steps)(const std::string& path, const OpenOptions& options,
                             std::vector<double>* out) noexcept;
};

using VtkPluginEntry = const VtkPlugin* (*)();

}  // namespace tetfusion
