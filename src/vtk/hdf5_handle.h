// An identifier of the HDF5 library's, closed as its kind wants it. For those files alone that are
// compiled with TETFUSION_HAS_HDF5.
#pragma once

#include <vtk_hdf5.h>

#include <utility>

namespace tetfusion {

class Hdf5Handle {
 public:
  Hdf5Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Hdf5Handle() {
    if (id_ >= 0) close_(id_);
  }
  Hdf5Handle(Hdf5Handle&& other) noexcept
      : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;
  explicit operator bool() const { return id_ >= 0; }
  hid_t get() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

// The library prints nothing of its own.
inline Hdf5Handle open_hdf5_file(const char* path) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  return {H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose};
}

}  // namespace tetfusion
