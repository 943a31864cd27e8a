#include "refine/write_level.h"

#include "io/mesh_output.h"
#include "io/vtu_writer.h"

namespace tetfusion {

namespace {

constexpr std::size_t kRunBytes = std::size_t{1} << 20;
// Points or cells after which somebody looks at the memory; and looks after which the numbers go.
constexpr std::size_t kCellsAtOnce = std::size_t{1} << 12;
constexpr std::size_t kNumbersKept = 64;

class LevelWriter {
 public:
  LevelWriter(const RefinableMesh& mesh, const ProgressiveFile& file, const std::string& folder,
              const std::function<void()>& keep)
      : mesh_(mesh), file_(file), keep_(keep), numbers_(folder, file.counts().points) {
    std::int64_t next = 0;
    for (std::size_t v = 0; v < numbers_.size(); ++v) {
      numbers_[v] = mesh.has_point(v) ? next++ : -1;
      if (v % kCellsAtOnce == 0) this->keep();
    }
  }

  void run(const std::string& path, const WriteOptions& options) {
    MeshOutput output(path, options.encoding);
    const double share = output.vtu_share();
    VtuWriter writer(output.file(), layout(output.encoding()), [&](double done) {
      if (options.progress) options.progress(share * done);
    });
    const ProgressiveDescription& d = file_.description();
    const std::size_t coordinates = 3 * size_of(d.point_type);
    std::size_t at = coordinates;
    for (const ArrayInfo& info : d.point_data.arrays) at += put_points(at, stride(info), &writer);
    at = 0;
    for (const ArrayInfo& info : d.cell_data.arrays) at += put_cells(at, stride(info), &writer);
    put_points(0, coordinates, &writer);
    put_corners(&writer);
    put_ends_and_types(&writer);
    writer.finish();
    output.commit(options.progress);
  }

 private:
  static std::size_t stride(const ArrayInfo& info) { return info.components * size_of(info.type); }

  template <class F>
  void for_each_cell(F f) const {
    for (std::size_t c = 0; c < file_.counts().cells; ++c) {
      if (mesh_.type_of(c) != 0) f(c);
      if (c % kCellsAtOnce == 0) keep();
    }
  }

  void keep() const {
    keep_();
    if (++kept_ % kNumbersKept == 0) numbers_.let_go();
  }

  VtuLayout layout(Encoding encoding) const {
    const ProgressiveDescription& d = file_.description();
    VtuLayout out;
    out.points = mesh_.points();
    out.cells = mesh_.cells();
    for_each_cell([&](std::size_t c) { out.corners += mesh_.corners_of(c).size(); });
    out.point_type = d.point_type;
    out.point_data = d.point_data;
    out.cell_data = d.cell_data;
    out.field_data = d.field_data;
    out.encoding = encoding;
    return out;
  }

  // Bytes from `at` on of each point's row. Returns how many.
  std::size_t put_points(std::size_t at, std::size_t bytes, VtuWriter* writer) {
    Run run(writer);
    for (std::size_t v = 0; v < numbers_.size(); ++v) {
      if (numbers_[v] >= 0) run.put(mesh_.point_row(v) + at, bytes);
      if (v % kCellsAtOnce == 0) keep();
    }
    run.end();
    return bytes;
  }

  std::size_t put_cells(std::size_t at, std::size_t bytes, VtuWriter* writer) {
    Run run(writer);
    for_each_cell([&](std::size_t c) { run.put(mesh_.cell_row(c) + at, bytes); });
    run.end();
    return bytes;
  }

  void put_corners(VtuWriter* writer) {
    Run run(writer);
    for_each_cell([&](std::size_t c) {
      for (const VertexId v : mesh_.corners_of(c)) run.put(&numbers_[v], sizeof numbers_[v]);
    });
    run.end();
  }

  void put_ends_and_types(VtuWriter* writer) {
    Run run(writer);
    std::int64_t end = 0;
    for_each_cell([&](std::size_t c) {
      end += static_cast<std::int64_t>(mesh_.corners_of(c).size());
      run.put(&end, sizeof end);
    });
    run.end();
    for_each_cell([&](std::size_t c) {
      const std::uint8_t type = mesh_.type_of(c);
      run.put(&type, sizeof type);
    });
    run.end();
  }

  // Gathers values of the writer's current array.
  class Run {
   public:
    explicit Run(VtuWriter* writer) : writer_(writer) {}
    void put(const void* value, std::size_t count) {
      const auto* begin = static_cast<const std::byte*>(value);
      bytes_.insert(bytes_.end(), begin, begin + count);
      if (bytes_.size() >= kRunBytes) end();
    }
    // To be called last.
    void end() {
      if (!bytes_.empty()) writer_->put(bytes_);
      bytes_.clear();
    }

   private:
    VtuWriter* writer_;
    Vector<std::byte> bytes_;
  };

  const RefinableMesh& mesh_;
  const ProgressiveFile& file_;
  const std::function<void()>& keep_;
  mutable std::uint64_t kept_ = 0;
  PagedArray<std::int64_t> numbers_;  // in the file that is written, of each point; -1: not there
};

}  // namespace

void write_level(const RefinableMesh& mesh, const ProgressiveFile& file, const std::string& path,
                 const WriteOptions& options, const std::string& folder,
                 const std::function<void()>& keep) {
  LevelWriter(mesh, file, folder, keep).run(path, options);
}

}  // namespace tetfusion
