#include "io/mesh_output.h"

#include <utility>

#include "io/vtk/vtu_reader.h"
#include "io/vtk/vtu_writer.h"

namespace tetfusion {

MeshOutput::MeshOutput(const std::string& path, Encoding encoding, bool is_read, std::string label)
    : path_(path),
      encoding_(encoding),
      is_vtu_(output_format(path) == MeshFormat::kVtu),
      label_(std::move(label)),
      file_(path, is_read ? OutputFile::Access::kPatch : VtuWriter::access(this->encoding())) {}

void MeshOutput::commit(const std::function<void(double)>& progress,
                        const std::function<void(std::string_view)>& tell,
                        const std::function<void()>& before_name) {
  if (is_vtu_) {
    file_.commit(before_name);
    return;
  }
  const auto source = open_vtu(file_.read_back());
  WriteOptions options;
  options.encoding = encoding_;
  options.label = label_;
  options.tell = tell;
  options.before_name = before_name;
  if (progress) {
    options.progress = [&](double share) { progress(vtu_share() + (1 - vtu_share()) * share); };
  }
  write_mesh(source.get(), path_, options);
}

}  // namespace tetfusion
