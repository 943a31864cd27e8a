#include "vtk/hdf5_data.h"

#ifdef TETFUSION_HAS_HDF5
#include <algorithm>
#include <array>
#include <optional>

#include "vtk/hdf5_handle.h"
#include "vtk/number_types.h"
#endif

namespace tetfusion {

#ifdef TETFUSION_HAS_HDF5
namespace {

struct MemoryType {
  int vtk;
  hid_t hdf5;
};

// What values of the file's type are read as; nothing where they are no numbers.
std::optional<MemoryType> memory_type(hid_t type) {
  const std::size_t size = H5Tget_size(type);
  switch (H5Tget_class(type)) {
    case H5T_FLOAT:
      if (size <= sizeof(float)) return MemoryType{VTK_TYPE_FLOAT32, H5T_NATIVE_FLOAT};
      return MemoryType{VTK_TYPE_FLOAT64, H5T_NATIVE_DOUBLE};
    case H5T_INTEGER:
    case H5T_ENUM: {  // as h5py writes truth values
      const bool is_signed = H5Tget_sign(type) == H5T_SGN_2;
      if (size == 1 && is_signed) return MemoryType{VTK_TYPE_INT8, H5T_NATIVE_INT8};
      if (size == 1) return MemoryType{VTK_TYPE_UINT8, H5T_NATIVE_UINT8};
      if (size == 2 && is_signed) return MemoryType{VTK_TYPE_INT16, H5T_NATIVE_INT16};
      if (size == 2) return MemoryType{VTK_TYPE_UINT16, H5T_NATIVE_UINT16};
      if (size == 4 && is_signed) return MemoryType{VTK_TYPE_INT32, H5T_NATIVE_INT32};
      if (size == 4) return MemoryType{VTK_TYPE_UINT32, H5T_NATIVE_UINT32};
      if (size == 8 && is_signed) return MemoryType{VTK_TYPE_INT64, H5T_NATIVE_INT64};
      if (size == 8) return MemoryType{VTK_TYPE_UINT64, H5T_NATIVE_UINT64};
      return {};
    }
    default:
      return {};
  }
}

Hdf5Handle space_of(const Hdf5Handle& data) { return {H5Dget_space(data.get()), H5Sclose}; }

Dimensions extent_of(const Hdf5Handle& space) {
  if (H5Sget_simple_extent_type(space.get()) == H5S_NULL) return {0};
  std::array<hsize_t, H5S_MAX_RANK> lengths{};
  const int rank = H5Sget_simple_extent_dims(space.get(), lengths.data(), nullptr);
  return {lengths.begin(), lengths.begin() + std::max(rank, 0)};
}

}  // namespace

struct Hdf5Data::File {
  std::string path;
  Hdf5Handle handle;

  std::string words(const std::string& name) const {
    return "names the data set " + name + " of " + path + ", which ";
  }
  [[noreturn]] void fail(const std::string& name, const std::string& what) const {
    throw DataFault(words(name) + what);
  }

  Hdf5Handle open(const std::string& name) const {
    Hdf5Handle data(H5Dopen2(handle.get(), name.c_str(), H5P_DEFAULT), H5Dclose);
    if (!data) fail(name, "is not there");
    return data;
  }
};

Hdf5Data::Hdf5Data(const std::string& path)
    : file_(std::make_unique<File>(File{path, open_hdf5_file(path.c_str())})) {
  if (!file_->handle) {
    throw DataFault("names the file " + path +
                    ", which the HDF5 library cannot open: it is no HDF5 file, or damaged, or "
                    "another program still writes to it");
  }
}

Dimensions Hdf5Data::dimensions(const std::string& name) const {
  return extent_of(space_of(file_->open(name)));
}

vtkSmartPointer<vtkDataArray> Hdf5Data::read(const std::string& name, const Hyperslab* part) const {
  const Hdf5Handle data = file_->open(name);
  const Hdf5Handle in_file = space_of(data);
  const Hdf5Handle type(H5Dget_type(data.get()), H5Tclose);
  const auto in_memory = memory_type(type.get());
  if (!in_memory) throw DataUnread(file_->words(name) + "holds no numbers of 1, 2, 4 or 8 bytes");
  const auto count = value_count(part != nullptr ? part->count : extent_of(in_file));
  if (!count) file_->fail(name, "has more values than can be counted: it is damaged");
  auto array = new_numbers(in_memory->vtk, *count);
  if (*count == 0) return array;
  hid_t from = H5S_ALL;
  hid_t to = H5S_ALL;
  const hsize_t length = *count;
  const Hdf5Handle line(H5Screate_simple(1, &length, nullptr), H5Sclose);
  if (part != nullptr && !part->count.empty()) {
    const std::vector<hsize_t> start(part->start.begin(), part->start.end()),
        stride(part->stride.begin(), part->stride.end()),
        counts(part->count.begin(), part->count.end());
    H5Sselect_hyperslab(in_file.get(), H5S_SELECT_SET, start.data(), stride.data(), counts.data(),
                        nullptr);
    from = in_file.get();
    to = line.get();
  }
  if (H5Dread(data.get(), in_memory->hdf5, to, from, H5P_DEFAULT, array->GetVoidPointer(0)) < 0) {
    file_->fail(name,
                "the HDF5 library cannot read: it is damaged, or packed in a way that this "
                "library does not know");
  }
  return array;
}
#else
struct Hdf5Data::File {};

Hdf5Data::Hdf5Data(const std::string& path) {
  throw DataFault("names the file " + path +
                  ", and this build's VTK has no HDF5: let ParaView or meshio convert all to .vtu");
}

Dimensions Hdf5Data::dimensions(const std::string&) const { return {}; }

vtkSmartPointer<vtkDataArray> Hdf5Data::read(const std::string&, const Hyperslab*) const {
  return nullptr;
}
#endif

Hdf5Data::~Hdf5Data() = default;
Hdf5Data::Hdf5Data(Hdf5Data&&) noexcept = default;

}  // namespace tetfusion
