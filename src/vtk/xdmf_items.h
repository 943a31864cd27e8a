// DataItems of an XDMF file: arrays that it holds as text, or in binary and HDF5 files beside it.
#pragma once

#include <vtkDataArray.h>
#include <vtkSmartPointer.h>

#include <map>
#include <pugixml.hpp>
#include <string>
#include <vector>

#include "io/files/mapped_file.h"
#include "vtk/hdf5_data.h"
#include "vtk/hyperslab.h"
#include "vtk/xdmf_document.h"

namespace tetfusion {

// Keeps files open until it goes. The document outlives it.
class XdmfItems {
 public:
  explicit XdmfItems(const XdmfDocument& document) : document_(document) {}

  // All values, one behind the other, of the type that they have in the file: what the XML says of
  // an HDF5 file's types is not asked. Throws Error(kBadInput) where they are not there, or not as
  // many as is said.
  vtkSmartPointer<vtkDataArray> read(pugi::xml_node item);

  // The same, but null where it is of a kind that is not read, and in which words to say that
  // behind its name.
  vtkSmartPointer<vtkDataArray> read_if_known(pugi::xml_node item, std::string* why);

  // A few of them, as of times.
  std::vector<double> read_doubles(pugi::xml_node item);

  // Two items with the same key are one array; others may be, too.
  std::string key(pugi::xml_node item) const;

  // Those that were read, in order, each of them once.
  const std::vector<std::string>& files() const { return files_; }

 private:
  using Array = vtkSmartPointer<vtkDataArray>;
  // "run.h5:/T", with "|0 0:1 1:1 5:2 5" behind it where it is a part.
  struct Hdf5Place {
    std::string file, name;
    std::vector<Dimensions> part;
  };

  Array read_any(pugi::xml_node item, int depth);
  Array read_uniform(pugi::xml_node item);
  Array read_text(pugi::xml_node item) const;
  Array read_binary(pugi::xml_node item, const Dimensions& extent, const Hyperslab* part);
  Array read_hdf5(pugi::xml_node item, const Hyperslab* part);
  Array read_part(pugi::xml_node item, int depth);
  Array read_joined(pugi::xml_node item, int depth);
  Hyperslab slab_of(pugi::xml_node list);
  Hdf5Place place_of(pugi::xml_node item) const;
  std::string path_of(pugi::xml_node item, const std::string& name);
  const Hdf5Data& hdf5(const std::string& path);
  const MappedFile& binary(const std::string& path);

  const XdmfDocument& document_;
  std::vector<std::string> files_;
  std::map<std::string, Hdf5Data> hdf5_;
  std::map<std::string, MappedFile> binary_;
};

}  // namespace tetfusion
