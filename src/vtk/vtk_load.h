// A file as VTK reads it: the data sets that it holds, one after another.
#pragma once

#include <vtkDataSet.h>
#include <vtkFieldData.h>
#include <vtkSmartPointer.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "io/source/mesh_source.h"

namespace tetfusion {

struct LoadedFile {
  std::string format;  // for MeshDescription
  // Pieces whose coordinates are one array of VTK's have the same points.
  std::vector<vtkSmartPointer<vtkDataSet>> pieces;
  // For each piece the block that it is or belongs to, as the file counts them from 0 on. Parts of
  // one partitioned data set are one block.
  std::vector<int> block_of;
  int blocks = 0;
  std::vector<std::string> block_names;  // of the first ones; empty: it has none
  // For each piece: of each of its cells the point in its middle, or -1; empty: none has one.
  // add_centres() fills it.
  std::vector<std::vector<vtkIdType>> centres;
  std::uint64_t tets_round_centres = 0;
  std::vector<vtkSmartPointer<vtkFieldData>> field_data;  // of the file as a whole
  // For MeshDescription.
  std::vector<std::string> files;
  std::vector<std::string> left_out;
  std::vector<double> time_steps;
  std::size_t time_step = 0;
};

// Throws Error(kBadInput) with VTK's own words if a reader complains, Error(kMemory) if it takes
// more memory than it may, Error(kUsage) for a time step that is not there, Error(kInterrupted).
// Nothing is printed. Not to be called from two threads at once.
LoadedFile load_with_vtk(const std::string& path, const OpenOptions& options);

// LoadedFile::time_steps, and no more is read. The same goes for it.
std::vector<double> load_time_steps(const std::string& path, const OpenOptions& options);

}  // namespace tetfusion
