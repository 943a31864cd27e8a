#include "series/step_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <span>
#include <string>

#include "base/error.h"
#include "base/numbers.h"
#include "base/resources.h"
#include "io/files/checksum.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kPrintWindow = std::uint64_t{1} << 16;

std::uint64_t count_in(std::uint64_t first, std::uint64_t all) {
  return std::min(kPrintWindow, all - first);
}

void read_points(const MeshStream& stream, ValueType type, std::uint64_t first,
                 Vector<std::byte>* rows) {
  const std::uint64_t count = count_in(first, stream.points());
  rows->resize(count * 3 * size_of(type));
  stream.read_points(first, count, *rows);
}

template <class T>
std::uint64_t add_to(std::uint64_t sum, const Vector<T>& values) {
  return checksum(std::as_bytes(std::span(values)), sum);
}

class Difference {
 public:
  Difference(const OpenMesh& first, const MeshDescription& step, const MeshStream& stream)
      : open_first_(first), stream_(stream), step_(step) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: {}, so that this step has another mesh than {}: with --series "
                            "each every step is simplified by itself",
                            step_.path, what, open_first_()->description().path));
  }

  [[noreturn]] void fail_in_points(std::uint64_t first) const {
    const ValueType type = step_.point_type;
    Vector<std::byte> before, now;
    const auto source = open_first_();
    read_points(*open_stream(source.get()), type, first, &before);
    read_points(stream_, type, first, &now);
    const std::size_t row = 3 * size_of(type);
    std::size_t p = 0;
    while (p + row < now.size() && std::memcmp(&before[p], &now[p], row) == 0) p += row;
    const auto place = [&](const Vector<std::byte>& rows) {
      return visit_type(type, [&](auto zero) {
        std::array<decltype(zero), 3> x;
        std::memcpy(x.data(), &rows[p], sizeof x);
        return fmt::format("({}, {}, {})", x[0], x[1], x[2]);
      });
    };
    fail(fmt::format("point {} lies at {}, not at {}", first + p / row, place(now), place(before)));
  }

  [[noreturn]] void fail_in_cells(std::uint64_t first) const {
    CellWindow before, now;
    const std::uint64_t count = count_in(first, stream_.cells());
    const auto source = open_first_();
    open_stream(source.get())->read_cells(first, count, &before);
    stream_.read_cells(first, count, &now);
    const std::size_t same = static_cast<std::size_t>(
        std::mismatch(before.tets.begin(), before.tets.end(), now.tets.begin(), now.tets.end())
            .first -
        before.tets.begin());
    if (same == now.tets.size() || same == before.tets.size()) {
      fail(fmt::format("cells from {} to {} are other ones", first, first + count - 1));
    }
    const auto row = [&](const CellWindow& window) {
      return window.tet_rows.empty() ? first + same : window.tet_rows[same];
    };
    if (row(now) != row(before)) {
      fail(
          fmt::format("cell {} is a tetrahedron, and no ghost (vtkGhostType), in one of them alone",
                      std::min(row(now), row(before))));
    }
    fail(fmt::format("cell {} has the points {}, not {}", row(now), fmt::join(now.tets[same], " "),
                     fmt::join(before.tets[same], " ")));
  }

 private:
  const OpenMesh& open_first_;
  const MeshStream& stream_;
  const MeshDescription& step_;
};

// The place of the first window that differs, or the number of windows.
std::size_t first_difference(const Vector<std::uint64_t>& a, const Vector<std::uint64_t>& b) {
  return static_cast<std::size_t>(std::mismatch(a.begin(), a.end(), b.begin()).first - a.begin());
}

}  // namespace

MeshPrint print_of(const MeshDescription& mesh, const MeshStream& stream, const RunContext& context,
                   PointSet* used) {
  MeshPrint print{stream.points(), stream.cells(), mesh.point_type, {}, {}};
  Vector<std::byte> rows;
  for (std::uint64_t first = 0; first < print.points; first += kPrintWindow) {
    context.check();
    read_points(stream, mesh.point_type, first, &rows);
    print.point_windows.push_back(checksum(rows));
  }
  CellWindow window;
  for (std::uint64_t first = 0; first < print.cells; first += kPrintWindow) {
    context.check();
    stream.read_cells(first, count_in(first, print.cells), &window);
    std::uint64_t sum = add_to(window.ghost_cells, window.tets);
    sum = add_to(add_to(sum, window.tet_rows), window.lower.types);
    sum = add_to(add_to(sum, window.lower.connectivity), window.lower_rows);
    print.cell_windows.push_back(sum);
    if (used == nullptr) continue;
    for (const Tet& tet : window.tets) {
      for (const VertexId v : tet) used->add(v);
    }
  }
  return print;
}

void require_same_size(const MeshPrint& first_print, const OpenMesh& first,
                       const MeshDescription& step, const MeshStream& stream) {
  const Difference difference(first, step, stream);
  if (stream.points() != first_print.points) {
    difference.fail(fmt::format("it has {}, not {}", format_count(stream.points(), "point"),
                                format_count(first_print.points)));
  }
  if (stream.cells() != first_print.cells) {
    difference.fail(fmt::format("it has {}, not {}", format_count(stream.cells(), "cell"),
                                format_count(first_print.cells)));
  }
  if (step.point_type != first_print.point_type) {
    difference.fail(fmt::format("its coordinates are {}, not {}", vtk_name(step.point_type),
                                vtk_name(first_print.point_type)));
  }
}

void require_same_mesh(const MeshPrint& first_print, const OpenMesh& first,
                       const MeshPrint& step_print, const MeshDescription& step,
                       const MeshStream& stream) {
  require_same_size(first_print, first, step, stream);
  const Difference difference(first, step, stream);
  const std::size_t points = first_difference(first_print.point_windows, step_print.point_windows);
  if (points < step_print.point_windows.size()) difference.fail_in_points(points * kPrintWindow);
  const std::size_t cells = first_difference(first_print.cell_windows, step_print.cell_windows);
  if (cells < step_print.cell_windows.size()) difference.fail_in_cells(cells * kPrintWindow);
}

void require_same_meshes(const MeshPrint& first_print, std::size_t steps, const OpenStep& open,
                         const RunContext& context) {
  const LoopThreads one(1);
  const auto in_file = open(0)->mesh_checksum(context);
  for (std::size_t i = 1; i < steps; ++i) {
    context.check();
    const auto source = open(i);
    if (in_file && source->mesh_checksum(context) == in_file) continue;
    const auto stream = open_stream(source.get());
    const MeshDescription& mesh = source->description();
    const auto first = [&] { return open(0); };
    require_same_mesh(first_print, first, print_of(mesh, *stream, context), mesh, *stream);
  }
}

}  // namespace tetfusion
