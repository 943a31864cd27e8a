#include "refine/write_level.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <vector>

#include "base/blocks.h"
#include "io/mesh_output.h"
#include "io/vtk/vtu_writer.h"

namespace tetfusion {

namespace {

// Points or cells that are gathered at once, after which somebody looks at the memory, and of wide
// rows fewer; blocks of these that threads take; and looks after which the numbers go.
constexpr std::size_t kWindow = std::size_t{1} << 15;
constexpr std::size_t kWindowBytes = std::size_t{4} << 20;
constexpr std::size_t kBlocks = 8;
constexpr std::size_t kNumbersKept = 8;

std::size_t window_for(std::size_t row_bytes) {
  return std::clamp<std::size_t>(kWindowBytes / std::max<std::size_t>(row_bytes, 1), kBlocks,
                                 kWindow);
}
std::size_t in_blocks(std::size_t window) { return window / kBlocks; }

class LevelWriter {
 public:
  LevelWriter(const RefinableMesh& mesh, const ProgressiveFile& file, const std::string& folder,
              const std::function<void()>& keep)
      : mesh_(mesh), file_(file), keep_(keep), numbers_(folder, file.counts().points) {
    std::int64_t next = 0;
    for (std::size_t v = 0; v < numbers_.size(); ++v) {
      numbers_[v] = mesh.has_point(v) ? next++ : -1;
      if (v % kWindow == 0) this->keep();
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
    for (const ArrayInfo& info : d.point_data.arrays)
      at += put_points(at, info.row_bytes(), &writer);
    at = 0;
    for (const ArrayInfo& info : d.cell_data.arrays) at += put_cells(at, info.row_bytes(), &writer);
    put_points(0, coordinates, &writer);
    put_corners(&writer);
    put_ends_and_types(&writer);
    writer.finish();
    output.commit(options.progress, options.tell);
  }

 private:
  void keep() const {
    keep_();
    if (++kept_ % kNumbersKept == 0) numbers_.let_go();
  }

  VtuLayout layout(Encoding encoding) const {
    const ProgressiveDescription& d = file_.description();
    VtuLayout out;
    out.points = mesh_.points();
    out.cells = mesh_.cells();
    for (std::size_t c = 0; c < file_.counts().cells; ++c) {
      if (mesh_.type_of(c) != 0) out.corners += mesh_.corners_of(c).size();
      if (c % kWindow == 0) keep();
    }
    out.point_type = d.point_type;
    out.point_data = d.point_data;
    out.cell_data = d.cell_data;
    out.field_data = d.field_data;
    out.encoding = encoding;
    return out;
  }

  // Bytes from `at` on of each point's row. Returns how many.
  std::size_t put_points(std::size_t at, std::size_t bytes, VtuWriter* writer) {
    const std::size_t window = window_for(file_.description().point_row_bytes());
    put(
        numbers_.size(), window, in_blocks(window),
        [&](std::size_t v) { return numbers_[v] >= 0 ? bytes : 0; },
        [&](std::size_t v, std::byte* out) { std::memcpy(out, mesh_.point_row(v) + at, bytes); },
        writer);
    return bytes;
  }

  std::size_t put_cells(std::size_t at, std::size_t bytes, VtuWriter* writer) {
    const std::size_t window = window_for(file_.description().cell_row_bytes());
    put_of_cells(
        window, in_blocks(window), bytes,
        [&](std::size_t c, std::byte* out) { std::memcpy(out, mesh_.cell_row(c) + at, bytes); },
        writer);
    return bytes;
  }

  void put_corners(VtuWriter* writer) {
    put(
        file_.counts().cells, kWindow, in_blocks(kWindow),
        [&](std::size_t c) {
          return mesh_.type_of(c) != 0 ? mesh_.corners_of(c).size() * sizeof(std::int64_t) : 0;
        },
        [&](std::size_t c, std::byte* out) {
          for (const VertexId v : mesh_.corners_of(c)) {
            std::memcpy(out, &numbers_[v], sizeof numbers_[v]);
            out += sizeof numbers_[v];
          }
        },
        writer);
  }

  void put_ends_and_types(VtuWriter* writer) {
    std::int64_t end = 0;
    put_of_cells(
        kWindow, kWindow, sizeof end,  // one block after the other
        [&](std::size_t c, std::byte* out) {
          end += static_cast<std::int64_t>(mesh_.corners_of(c).size());
          std::memcpy(out, &end, sizeof end);
        },
        writer);
    put_of_cells(
        kWindow, in_blocks(kWindow), 1,
        [&](std::size_t c, std::byte* out) { *out = static_cast<std::byte>(mesh_.type_of(c)); },
        writer);
  }

  template <class Fill>
  void put_of_cells(std::size_t window, std::size_t block, std::size_t bytes, Fill fill,
                    VtuWriter* writer) {
    put(
        file_.counts().cells, window, block,
        [&](std::size_t c) { return mesh_.type_of(c) != 0 ? bytes : 0; }, fill, writer);
  }

  // An array of the file: fill(item, out) writes bytes_of(item) bytes, 0 of those that are not
  // there. From several threads, but for what is in one block.
  template <class BytesOf, class Fill>
  void put(std::size_t items, std::size_t window, std::size_t block, BytesOf bytes_of, Fill fill,
           VtuWriter* writer) {
    for (std::size_t first = 0; first < items; first += window) {
      const std::size_t count = std::min(window, items - first);
      ends_.assign(block_count(count, block), 0);
      for_each_block(count, block, [&](std::size_t b, std::size_t begin, std::size_t end) {
        std::size_t bytes = 0;
        for (std::size_t i = first + begin; i < first + end; ++i) bytes += bytes_of(i);
        ends_[b] = bytes;
      });
      std::partial_sum(ends_.begin(), ends_.end(), ends_.begin());
      bytes_.resize(ends_.back());
      for_each_block(count, block, [&](std::size_t b, std::size_t begin, std::size_t end) {
        std::byte* out = bytes_.data() + (b == 0 ? 0 : ends_[b - 1]);
        for (std::size_t i = first + begin; i < first + end; ++i) {
          const std::size_t bytes = bytes_of(i);
          if (bytes == 0) continue;
          fill(i, out);
          out += bytes;
        }
      });
      if (!bytes_.empty()) writer->put(bytes_);
      keep();
    }
  }

  const RefinableMesh& mesh_;
  const ProgressiveFile& file_;
  const std::function<void()>& keep_;
  mutable std::uint64_t kept_ = 0;
  Vector<std::byte> bytes_;           // of the window in hand
  std::vector<std::size_t> ends_;     // of its blocks, in these
  PagedArray<std::int64_t> numbers_;  // in the file that is written, of each point; -1: not there
};

}  // namespace

void write_level(const RefinableMesh& mesh, const ProgressiveFile& file, const std::string& path,
                 const WriteOptions& options, const std::string& folder,
                 const std::function<void()>& keep) {
  LevelWriter(mesh, file, folder, keep).run(path, options);
}

}  // namespace tetfusion
