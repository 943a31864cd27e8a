// Where the file of a VtuWriter goes: under its name; or, where the name says another format, to a
// file without a name, from which that of the other format is made.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "io/files/output_file.h"
#include "io/mesh_format.h"
#include "io/write_mesh.h"

namespace tetfusion {

class MeshOutput {
 public:
  // `is_read`: file()->path_to_read() will be called, also where the output is a stream. `label` is
  // that of WriteOptions.
  MeshOutput(const std::string& path, Encoding encoding, bool is_read = false,
             std::string label = {});

  OutputFile* file() { return &file_; }
  // The .vtu's: raw where it is not what is wanted.
  Encoding encoding() const { return is_vtu_ ? encoding_ : Encoding::kRaw; }
  // How much of the work is done when the .vtu is written.
  double vtu_share() const { return is_vtu_ ? 1 : 0.5; }

  // Call once, last, when the .vtu is complete. `progress` is called with shares from vtu_share()
  // on; `tell` and `before_name` as those of WriteOptions.
  void commit(const std::function<void(double)>& progress = {},
              const std::function<void(std::string_view)>& tell = {},
              const std::function<void()>& before_name = {});

 private:
  std::string path_;
  Encoding encoding_;
  bool is_vtu_;
  std::string label_;
  OutputFile file_;
};

}  // namespace tetfusion
