#include "repair/repair.h"

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "base/blocks.h"
#include "compare/original_mesh.h"
#include "io/source/stream_around.h"
#include "io/source/stream_windows.h"
#include "mesh/predicates.h"

namespace tetfusion {

namespace {

constexpr std::size_t kBlock = 8192;
constexpr std::uint64_t kDuplicateBytes = std::uint64_t{64} << 20;  // at a time

// What is to be done, by the stream's numbers of points and rows of cells.
struct Plan {
  explicit Plan(const MeshStream& stream) : used(stream.points()), rewind(stream.cells()) {}

  PointSet used;
  std::vector<bool> rewind;
  Vector<std::uint64_t> duplicates;  // ascending

  bool drops_points() const { return used.size() < used.points(); }
  bool drops(std::uint64_t row) const {
    return std::binary_search(duplicates.begin(), duplicates.end(), row);
  }
};

// Calls f(window, row of its tetrahedron i) for all windows of cells.
template <class F>
void for_each_window_of_cells(const MeshStream& stream, const RunContext& context, F f) {
  CellWindow window;
  for_each_window(stream.cells(), context, [&](std::uint64_t first, std::uint64_t count) {
    stream.read_cells(first, count, &window);
    f(window,
      [&](std::size_t i) { return window.tet_rows.empty() ? first + i : window.tet_rows[i]; });
  });
}

class Planner {
 public:
  Planner(MeshSource* source, const RunContext& context)
      : source_(source), context_(context), stream_(open_stream(source)), plan_(*stream_) {}

  Plan run(bool has_duplicates, Repairs* repairs) {
    find_used();
    repairs->unused_points = plan_.used.points() - plan_.used.size() + stream_->dropped_points();
    if (has_duplicates) find_duplicates();
    repairs->duplicate_tets = plan_.duplicates.size();
    repairs->rewound = find_rewound();
    return std::move(plan_);
  }

 private:
  void find_used() {
    for_each_window_of_cells(*stream_, context_, [&](const CellWindow& window, auto) {
      for (const Tet& t : window.tets) {
        for (const VertexId v : t) plan_.used.add(v);
      }
      for (const VertexId v : window.lower.connectivity) plan_.used.add(v);
    });
    plan_.used.number();
  }

  // Cells with the same points have the same smallest one: as many of these at a time as fit.
  void find_duplicates() {
    struct Cell {
      Tet corners;
      std::uint64_t row;
      auto operator<=>(const Cell&) const = default;
    };
    const std::uint64_t turns = block_count(stream_->cells() * sizeof(Cell), kDuplicateBytes);
    Vector<Cell> cells;
    for (std::uint64_t turn = 0; turn < turns; ++turn) {
      cells.clear();
      for_each_window_of_cells(*stream_, context_, [&](const CellWindow& window, auto row_of) {
        for (std::size_t i = 0; i < window.tets.size(); ++i) {
          Cell cell{window.tets[i], row_of(i)};
          std::sort(cell.corners.begin(), cell.corners.end());
          if (cell.corners[0] % turns == turn) cells.push_back(cell);
        }
      });
      std::sort(cells.begin(), cells.end());
      for (std::size_t i = 1; i < cells.size(); ++i) {
        if (cells[i].corners == cells[i - 1].corners) plan_.duplicates.push_back(cells[i].row);
      }
    }
    std::sort(plan_.duplicates.begin(), plan_.duplicates.end());
  }

  // Of cells that stay.
  std::uint64_t find_rewound() {
    const FieldSet nothing{};
    const OriginalMesh mesh(source_, nothing, nothing);
    std::uint64_t count = 0;
    Vector<std::uint8_t> negative;
    mesh.for_each_cells([&](const OriginalCells& window, double share) {
      context_.check();
      context_.report("repairing", 0.5 * share);
      negative.resize(window.tets.size());
      for_each_block(window.tets.size(), kBlock,
                     [&](std::size_t, std::size_t begin, std::size_t end) {
                       for (std::size_t t = begin; t < end; ++t) {
                         const auto d = determinant(window.points.points, window.tets[t]);
                         negative[t] = d.sign() < 0 ? 1 : 0;
                       }
                     });
      for (std::size_t t = 0; t < negative.size(); ++t) {
        if (negative[t] == 0 || plan_.drops(window.row(t))) continue;
        plan_.rewind[window.row(t)] = true;
        ++count;
      }
    });
    return count;
  }

  MeshSource* source_;
  const RunContext& context_;
  std::unique_ptr<MeshStream> stream_;
  Plan plan_;
};

class RepairedStream final : public StreamAround {
 public:
  RepairedStream(MeshSource* source, const Plan& plan)
      : StreamAround(open_stream(source)), description_(source->description()), plan_(plan) {}

  std::uint64_t points() const override { return plan_.used.size(); }
  std::uint64_t dropped_points() const override { return 0; }

  void read_points(std::uint64_t first, std::uint64_t count,
                   std::span<std::byte> out) const override {
    gather(first, count, 3 * size_of(description_.point_type), out,
           [&](std::uint64_t from, std::uint64_t n, std::span<std::byte> to) {
             inner().read_points(from, n, to);
           });
  }

  void read_cells(std::uint64_t first, std::uint64_t count, CellWindow* out) const override {
    inner().read_cells(first, count, out);
    const bool has_rows = !out->tet_rows.empty();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < out->tets.size(); ++i) {
      const std::uint64_t row = has_rows ? out->tet_rows[i] : first + i;
      if (plan_.drops(row)) continue;
      Tet tet = out->tets[i];
      if (plan_.rewind[row]) std::swap(tet[2], tet[3]);
      for (VertexId& v : tet) v = number_of(v);
      out->tets[kept] = tet;
      if (has_rows) {
        out->tet_rows[kept] = row;
      } else if (!plan_.duplicates.empty()) {
        out->tet_rows.push_back(row);
      }
      ++kept;
    }
    out->tets.resize(kept);
    if (!out->tet_rows.empty()) out->tet_rows.resize(kept);
    for (VertexId& v : out->lower.connectivity) v = number_of(v);
  }

  void read_rows(Association association, std::size_t index, std::uint64_t first,
                 std::uint64_t count, std::span<std::byte> out) const override {
    if (association != Association::kPoint) {
      inner().read_rows(association, index, first, count, out);
      return;
    }
    const ArrayInfo& info = description_.point_data.arrays[index];
    gather(first, count, info.row_bytes(), out,
           [&](std::uint64_t from, std::uint64_t n, std::span<std::byte> to) {
             inner().read_rows(association, index, from, n, to);
           });
  }

  void read_locks(std::uint64_t first, std::uint64_t count, std::uint8_t* locked) const override {
    for (std::uint64_t i = 0; i < count; ++i) {
      inner().read_locks(plan_.used.id_of(first + i), 1, locked + i);
    }
  }

 private:
  VertexId number_of(VertexId v) const {
    return plan_.drops_points() ? static_cast<VertexId>(plan_.used.number_of(v)) : v;
  }

  // The rows of points that are used, from a range of all, in parts.
  template <class Read>
  void gather(std::uint64_t first, std::uint64_t count, std::size_t stride,
              std::span<std::byte> out, Read read) const {
    if (!plan_.drops_points()) return read(first, count, out);
    if (count == 0) return;
    const std::uint64_t end = plan_.used.id_of(first + count - 1) + 1;
    Vector<std::byte> rows;
    std::byte* to = out.data();
    for (std::uint64_t from = plan_.used.id_of(first); from < end; from += kStreamWindow) {
      const std::uint64_t n = std::min(kStreamWindow, end - from);
      rows.resize(n * stride);
      read(from, n, std::span<std::byte>(rows));
      for (std::uint64_t i = 0; i < n; ++i) {
        if (!plan_.used.has(from + i)) continue;
        std::memcpy(to, rows.data() + i * stride, stride);
        to += stride;
      }
    }
  }

  const MeshDescription& description_;
  const Plan& plan_;
};

class RepairedSource : public MeshSource {
 public:
  RepairedSource(MeshSource* original, Plan plan)
      : original_(original), plan_(std::move(plan)), description_(original->description()) {
    description_.points = plan_.used.size();
  }

  const MeshDescription& description() const override { return description_; }
  std::unique_ptr<MeshStream> stream() override {
    return std::make_unique<RepairedStream>(original_, plan_);
  }
  std::uint64_t memory_to_read() override { return original_->memory_to_read(); }

  Geometry read_geometry() override {
    const auto from = stream();
    Geometry mesh;
    mesh.merged_points = from->merged_points();
    mesh.differing_points = from->differing_points();
    mesh.largest_difference = from->largest_difference();
    mesh.ghost_cells = from->ghost_cells();
    if (description_.point_type == ValueType::kFloat32) {
      mesh.points = Vector<Vec3<float>>(from->points());
    } else {
      mesh.points = Vector<Vec3<double>>(from->points());
    }
    std::visit(
        [&](auto& points) {
          from->read_points(0, points.size(), std::as_writable_bytes(std::span(points)));
        },
        mesh.points);
    for_each_window_of_cells(*from, RunContext(), [&](const CellWindow& window, auto row_of) {
      for (std::size_t i = 0; i < window.tets.size(); ++i) {
        mesh.tets.push_back(window.tets[i]);
        mesh.tet_source.push_back(row_of(i));
      }
      mesh.lower.add(window.lower);
      mesh.lower_source.insert(mesh.lower_source.end(), window.lower_rows.begin(),
                               window.lower_rows.end());
    });
    return mesh;
  }

  DataArray read_array(Association association, std::size_t index) override {
    if (association == Association::kField) return original_->read_array(association, index);
    const auto from = stream();
    const bool of_points = association == Association::kPoint;
    DataArray array;
    array.info = (of_points ? description_.point_data : description_.cell_data).arrays[index];
    array.info.tuples = of_points ? from->points() : from->cells();
    array.bytes.resize(array.info.bytes());
    from->read_rows(association, index, 0, array.info.tuples, array.bytes);
    return array;
  }

 private:
  MeshSource* original_;
  const Plan plan_;
  MeshDescription description_;
};

}  // namespace

RepairedMesh repair(MeshSource* original, bool has_duplicates, const RunContext& context) {
  RepairedMesh mesh;
  Plan plan = Planner(original, context).run(has_duplicates, &mesh.repairs);
  mesh.source = std::make_unique<RepairedSource>(original, std::move(plan));
  return mesh;
}

}  // namespace tetfusion
