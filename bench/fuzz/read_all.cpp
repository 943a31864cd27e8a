#include "fuzz/read_all.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "base/error.h"
#include "io/files/file_system.h"
#include "io/source/mesh_stream.h"

namespace tetfusion::fuzz {

namespace {

[[noreturn]] void differ(const std::string& what) {
  throw std::logic_error("whole and in windows: " + what);
}

struct Arrays {
  std::vector<DataArray> points, cells;
};

Arrays read_arrays(MeshSource* source) {
  Arrays arrays;
  const MeshDescription& d = source->description();
  for (std::size_t i = 0; i < d.point_data.arrays.size(); ++i) {
    arrays.points.push_back(source->read_array(Association::kPoint, i));
  }
  for (std::size_t i = 0; i < d.cell_data.arrays.size(); ++i) {
    arrays.cells.push_back(source->read_array(Association::kCell, i));
  }
  for (std::size_t i = 0; i < d.field_data.arrays.size(); ++i) {
    source->read_array(Association::kField, i);
  }
  return arrays;
}

// Holds the windows of a stream against the whole mesh.
class Windows {
 public:
  Windows(const MeshStream& stream, const MeshDescription& description, const Geometry& mesh,
          const Arrays& arrays)
      : stream_(stream), mesh_(mesh), arrays_(arrays) {
    const std::size_t point_bytes = 3 * size_of(description.point_type);
    points_.resize(stream.points() * point_bytes);
    stream.read_points(0, stream.points(), points_);
    for (std::size_t i = 0; i < arrays.points.size(); ++i) {
      point_rows_.push_back(
          rows(Association::kPoint, i, arrays.points[i].info, 0, stream.points()));
    }
  }

  // Of so many cells each.
  void compare(std::uint64_t step) {
    CellWindow window;
    for (std::uint64_t first = 0; first < stream_.cells(); first += step) {
      const std::uint64_t count = std::min(step, stream_.cells() - first);
      stream_.read_cells(first, count, &window);
      ghosts_ += window.ghost_cells;
      compare_tets(window, first, count);
      lower_ += window.lower.size();
    }
    if (tets_ != mesh_.tets.size()) differ("number of tetrahedra");
    if (lower_ != mesh_.lower.size()) differ("number of cells of lower dimension");
    if (ghosts_ != mesh_.ghost_cells || stream_.ghost_cells() != mesh_.ghost_cells)
      differ("ghost cells");
  }

 private:
  std::vector<std::byte> rows(Association of, std::size_t index, const ArrayInfo& info,
                              std::uint64_t first, std::uint64_t count) const {
    std::vector<std::byte> bytes(count * info.components * size_of(info.type));
    stream_.read_rows(of, index, first, count, bytes);
    return bytes;
  }

  void compare_tets(const CellWindow& window, std::uint64_t first, std::uint64_t count) {
    if (tets_ + window.tets.size() > mesh_.tets.size()) differ("more tetrahedra in windows");
    std::vector<std::vector<std::byte>> cell_rows;
    for (std::size_t i = 0; i < arrays_.cells.size(); ++i) {
      cell_rows.push_back(rows(Association::kCell, i, arrays_.cells[i].info, first, count));
    }
    for (std::size_t i = 0; i < window.tets.size(); ++i, ++tets_) {
      for (std::size_t k = 0; k < 4; ++k) compare_corner(window.tets[i][k], mesh_.tets[tets_][k]);
      const std::uint64_t row = window.tet_rows.empty() ? first + i : window.tet_rows[i];
      if (row - first >= count) differ("a row outside its window");
      const std::uint64_t source = mesh_.tet_source.empty() ? tets_ : mesh_.tet_source[tets_];
      for (std::size_t a = 0; a < cell_rows.size(); ++a) {
        compare_row(arrays_.cells[a], source, cell_rows[a], row - first);
      }
    }
  }

  void compare_corner(VertexId streamed, VertexId whole) const {
    std::visit(
        [&](const auto& points) {
          constexpr std::size_t kBytes = sizeof(points[0]);
          if ((std::uint64_t{streamed} + 1) * kBytes > points_.size())
            differ("a point that is not there");
          if (std::memcmp(&points[whole], points_.data() + streamed * kBytes, kBytes) != 0)
            differ("coordinates");
        },
        mesh_.points);
    const std::uint64_t source = mesh_.point_source.empty() ? whole : mesh_.point_source[whole];
    for (std::size_t a = 0; a < point_rows_.size(); ++a) {
      compare_row(arrays_.points[a], source, point_rows_[a], streamed);
    }
  }

  static void compare_row(const DataArray& array, std::uint64_t row,
                          const std::vector<std::byte>& rows, std::uint64_t at) {
    const std::size_t bytes = array.info.components * size_of(array.info.type);
    if (bytes == 0) return;
    if ((row + 1) * bytes > array.bytes.size() || (at + 1) * bytes > rows.size())
      differ("a row that is not there");
    if (std::memcmp(array.bytes.data() + row * bytes, rows.data() + at * bytes, bytes) != 0) {
      differ("array " + array.info.name);
    }
  }

  const MeshStream& stream_;
  const Geometry& mesh_;
  const Arrays& arrays_;
  std::vector<std::byte> points_;
  std::vector<std::vector<std::byte>> point_rows_;
  std::uint64_t tets_ = 0;
  std::uint64_t lower_ = 0;
  std::uint64_t ghosts_ = 0;
};

// What a call was refused with, or nothing.
template <class F>
std::optional<Error> refusal(F f) {
  try {
    f();
  } catch (const Error& e) {
    return e;
  }
  return std::nullopt;
}

}  // namespace

OpenOptions options_of(Input input) {
  const auto bit = [&](std::size_t b) { return (input.size() & b) != 0; };
  return {.tetrahedralize = bit(1), .linearize = bit(2), .drop_patches = bit(4)};
}

MappedFile memory_file(Input input, const char* name) {
  Descriptor fd(::memfd_create(name, MFD_CLOEXEC));
  if (!fd || write_all(fd.get(), input.data(), input.size()) != 0) {
    throw std::runtime_error("no file in memory can be made");
  }
  return MappedFile::of_descriptor(fd.release(), name);
}

void read_all(MeshSource* source) {
  source->memory_to_read();
  Geometry mesh;
  Arrays arrays;
  const auto refused_whole = refusal([&] {
    mesh = source->read_geometry();
    arrays = read_arrays(source);
  });
  std::unique_ptr<MeshStream> stream;
  bool in_windows = true;
  const auto refused_in_windows = refusal([&] {
    stream = source->stream();
    if (!stream) {
      in_windows = false;
      return;
    }
    Windows windows(*stream, source->description(), mesh, arrays);
    if (!refused_whole) {
      // Few of them, and none that is aligned to anything.
      windows.compare(std::max<std::uint64_t>(stream->cells() / 3, 1));
      return;
    }
    CellWindow window;
    stream->read_cells(0, stream->cells(), &window);
    read_arrays(source);
  });
  if (in_windows && refused_whole.has_value() != refused_in_windows.has_value()) {
    differ(refused_whole ? std::string("only the whole is refused: ") + refused_whole->what()
                         : std::string("only windows are refused: ") + refused_in_windows->what());
  }
  if (refused_whole) throw Error(*refused_whole);
}

}  // namespace tetfusion::fuzz
