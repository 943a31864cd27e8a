// VTKHDF: VTK's own files in HDF5.

#include "vtk/vtk_reader.h"

#ifdef TETFUSION_HAS_VTKHDF
#include <vtkHDFReader.h>
#include <vtkNew.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "vtk/hdf5_handle.h"
#endif

#include "base/error.h"
#include "vtk/vtk_collect.h"

namespace tetfusion {

#ifdef TETFUSION_HAS_VTKHDF
namespace {

// What VTK's reader keeps to itself.
class VtkHdfFile {
 public:
  explicit VtkHdfFile(const std::string& path)
      : file_(open_hdf5_file(path.c_str())),
        group_(file_ ? H5Gopen2(file_.get(), "/VTKHDF", H5P_DEFAULT) : -1, H5Gclose) {}

  bool is_one() const { return static_cast<bool>(group_); }

  bool has_steps() const { return H5Lexists(group_.get(), "Steps", H5P_DEFAULT) > 0; }

  // Of the first version, which has none, it is known by what there is.
  std::string type() const {
    const Hdf5Handle attribute(H5Aopen(group_.get(), "Type", H5P_DEFAULT), H5Aclose);
    if (!attribute) {
      return H5Aexists(group_.get(), "WholeExtent") > 0 ? "ImageData" : "UnstructuredGrid";
    }
    const Hdf5Handle of(H5Aget_type(attribute.get()), H5Tclose);
    std::array<char, 64> text{};
    if (H5Tis_variable_str(of.get()) > 0 || H5Tget_size(of.get()) >= text.size()) return "";
    H5Aread(attribute.get(), of.get(), text.data());
    return text.data();
  }

  // As many as there are counts of points. 0: there are none, or several for each.
  int pieces() const {
    const Hdf5Handle counts(H5Dopen2(group_.get(), "NumberOfPoints", H5P_DEFAULT), H5Dclose);
    if (!counts) return 0;
    const Hdf5Handle space(H5Dget_space(counts.get()), H5Sclose);
    hsize_t length = 0;
    if (H5Sget_simple_extent_ndims(space.get()) != 1) return 0;
    H5Sget_simple_extent_dims(space.get(), &length, nullptr);
    return static_cast<int>(std::min<hsize_t>(length, 1 << 24));
  }

 private:
  Hdf5Handle file_, group_;
};

void load_vtkhdf(const std::string& path, const TrapScope& trap, LoadedFile* out) {
  std::string type;
  int pieces = 1;
  {
    const VtkHdfFile file(path);
    type = file.type();
    if (type != "UnstructuredGrid" && type != "ImageData") {
      throw Error(ErrorCode::kBadInput,
                  path + ": is a VTKHDF file of type '" + type +
                      "'; only UnstructuredGrid and ImageData are read: save it as such, or as a "
                      ".vtm, with ParaView");
    }
    if (file.has_steps()) {
      throw Error(ErrorCode::kBadInput,
                  path +
                      ": is a VTKHDF file with time steps, which are not read: let ParaView save "
                      "it as a series of .vtu");
    }
    if (type == "UnstructuredGrid") pieces = file.pieces();
  }
  if (pieces == 0) throw Error(ErrorCode::kBadInput, path + ": this VTKHDF file has no pieces");
  vtkNew<vtkHDFReader> reader;
  reader->SetFileName(path.c_str());
  reader->UpdateInformation();
  trap.check(path);
  collect_pieces(reader, pieces, path, trap, out);
  out->format = "VTKHDF file of type " + type;
}

}  // namespace

bool is_vtkhdf(const std::string& path) { return VtkHdfFile(path).is_one(); }

std::unique_ptr<FileReader> open_vtkhdf(const std::string& path, const TrapScope& trap) {
  return without_steps([&](LoadedFile* out) { load_vtkhdf(path, trap, out); });
}
#else
bool is_vtkhdf(const std::string&) { return false; }

std::unique_ptr<FileReader> open_vtkhdf(const std::string& path, const TrapScope&) {
  refuse_without(path, "IOHDF", "VTKHDF");
}
#endif

}  // namespace tetfusion
