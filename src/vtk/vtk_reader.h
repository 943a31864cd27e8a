// What each format's reader does for vtk_load. The factories throw Error(kBadInput) with VTK's own
// words if its reader complains, or where this build's VTK has none.
#pragma once

#include <vtkAlgorithm.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "vtk/vtk_load.h"
#include "vtk/vtk_trap.h"

namespace tetfusion {

// An opened file of which nothing but the head is read.
class FileReader {
 public:
  virtual ~FileReader() = default;

  // Empty: the file has none. Not to be asked for after load().
  virtual std::vector<double> time_steps() { return {}; }

  // Adds all but what LoadedFile says of steps; `step` is 0 where there are none. To be called
  // once. Throws Error(kBadInput).
  virtual void load(std::size_t step, LoadedFile* out) = 0;
};

// Of a format that has no steps.
std::unique_ptr<FileReader> without_steps(std::function<void(LoadedFile*)> load);

// The path and the trap must outlive the reader.
std::unique_ptr<FileReader> open_exodus(const std::string& path, const TrapScope& trap);
std::unique_ptr<FileReader> open_ensight(const std::string& path, const TrapScope& trap);
std::unique_ptr<FileReader> open_openfoam(const std::string& path, const TrapScope& trap);
std::unique_ptr<FileReader> open_cgns(const std::string& path, const TrapScope& trap);
std::unique_ptr<FileReader> open_vtkhdf(const std::string& path, const TrapScope& trap);
// Read here, and not by VTK.
std::unique_ptr<FileReader> open_xdmf(const std::string& path);

// What an HDF5 file is; false where this build's VTK has no reader for that. Nothing is printed.
bool is_exodus(const std::string& path);
bool is_cgns(const std::string& path);
bool is_vtkhdf(const std::string& path);

// Throws Error(kBadInput): VTK was built without this module.
[[noreturn]] void refuse_without(const std::string& path, const std::string& module,
                                 const std::string& format);

// Those that VTK's reader tells of when it has read the head.
std::vector<double> time_steps_in(vtkAlgorithm* reader);

// Lets it read that one of them, or what it reads where there are none.
void update_to_step(vtkAlgorithm* reader, const std::vector<double>& times, std::size_t step);

}  // namespace tetfusion
