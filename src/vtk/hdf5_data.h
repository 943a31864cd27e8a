// Data sets of an HDF5 file, as arrays.
#pragma once

#include <vtkDataArray.h>
#include <vtkSmartPointer.h>

#include <memory>
#include <stdexcept>
#include <string>

#include "vtk/hyperslab.h"

namespace tetfusion {

// What is wrong with data, in words that go behind the name of who wants them.
struct DataFault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The same, of what is not damaged, but of a kind that is not read.
struct DataUnread : DataFault {
  using DataFault::DataFault;
};

class Hdf5Data {
 public:
  // The file is there. Throws DataFault where it is no HDF5 file, or this build's VTK has no HDF5.
  explicit Hdf5Data(const std::string& path);
  ~Hdf5Data();
  Hdf5Data(Hdf5Data&&) noexcept;

  // Throws DataFault where there is no such data set.
  Dimensions dimensions(const std::string& name) const;

  // All of it, or a part that lies in it: one value behind the other, of the file's type in this
  // machine's byte order. Throws DataFault, DataUnread where they are no numbers.
  vtkSmartPointer<vtkDataArray> read(const std::string& name, const Hyperslab* part) const;

 private:
  struct File;
  std::unique_ptr<File> file_;
};

}  // namespace tetfusion
