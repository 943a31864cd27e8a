#include "io/vtk/pieces_stream.h"

#include <algorithm>
#include <mutex>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

#include "base/blocks.h"
#include "io/source/differing_copies.h"
#include "io/source/merge_pieces.h"
#include "io/source/piece_numbers.h"
#include "io/vtk/vtu_points.h"
#include "io/vtk/vtu_stream.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kCells = std::uint64_t{1} << 18;   // looked at at once
constexpr std::uint64_t kPoints = std::uint64_t{1} << 16;  // read at once
constexpr std::size_t kBlock = 16384;
// For the search for copies: no less, and no more than an import takes for its table of points.
constexpr std::uint64_t kLeastMemory = std::uint64_t{16} << 20;
constexpr std::uint64_t kMemoryPerPoint = 4;

class PiecesStream final : public MeshStream {
 public:
  PiecesStream(const std::vector<StreamPiece>& pieces, const MeshDescription& description,
               const OpenOptions& options)
      : description_(description), numbers_(description.points) {
    open(pieces, options);
    if (!can_stream_) return;
    find_used_points();
    find_copies(options.merge_points);
  }

  bool can_stream() const { return can_stream_; }

  std::uint64_t points() const override { return numbers_.points(); }
  std::uint64_t cells() const override { return description_.cells; }
  LowerCount lower_cells() const override { return lower_; }
  std::uint64_t ghost_cells() const override { return ghosts_; }
  std::uint64_t merged_points() const override { return numbers_.merged(); }
  std::uint64_t differing_points() const override { return differences().points; }
  LargestDifference largest_difference() const override { return differences().largest; }
  std::uint64_t dropped_points() const override { return numbers_.unused(); }
  bool streams_from_disk() const override { return true; }
  std::uint64_t bytes() const override { return numbers_.bytes(); }

  void read_points(std::uint64_t first, std::uint64_t count,
                   std::span<std::byte> out) const override {
    read_numbered(first, count, 3 * size_of(description_.point_type), out,
                  [](const Part& part, std::uint64_t begin, std::uint64_t n,
                     std::span<std::byte> to) { part.stream->read_points(begin, n, to); });
  }

  void read_cells(std::uint64_t first, std::uint64_t count, CellWindow* out) const override;

  void read_rows(Association association, std::size_t index, std::uint64_t first,
                 std::uint64_t count, std::span<std::byte> out) const override {
    const bool of_points = association == Association::kPoint;
    const AttributeSet& set = of_points ? description_.point_data : description_.cell_data;
    const ArrayInfo& info = set.arrays.at(index);
    const std::size_t stride = info.row_bytes();
    if (of_points) {
      read_numbered(
          first, count, stride, out,
          [&](const Part& part, std::uint64_t begin, std::uint64_t n, std::span<std::byte> to) {
            part.stream->read_rows(association, index, begin, n, to);
          });
      return;
    }
    check_window(first, count, cells());
    for_each_part(first, count, &Part::first_cell,
                  [&](const Part& part, std::uint64_t begin, std::uint64_t n) {
                    const std::uint64_t at = part.first_cell + begin - first;
                    part.stream->read_rows(association, index, begin, n,
                                           out.subspan(at * stride, n * stride));
                  });
  }

 private:
  // A piece with cells. The points and cells of the parts ascend, but for points of pieces without
  // cells, which nobody uses.
  struct Part {
    MeshDescription description;
    std::unique_ptr<MeshStream> stream;
    std::uint64_t first_point = 0;
    std::uint64_t first_cell = 0;
  };

  void open(const std::vector<StreamPiece>& pieces, const OpenOptions& options);
  void find_used_points();
  void find_copies(bool merge_points);
  void match(bool by_ids, bool also_within);
  const CopyDifferences& differences() const;

  // f(part, first within it, count) for each part that has some of a range.
  template <class F>
  void for_each_part(std::uint64_t first, std::uint64_t count, std::uint64_t Part::*begin_of,
                     F f) const {
    const bool of_points = begin_of == &Part::first_point;
    auto part =
        std::upper_bound(parts_.begin(), parts_.end(), first,
                         [&](std::uint64_t at, const auto& p) { return at < *p.*begin_of; });
    if (part != parts_.begin()) --part;
    for (const std::uint64_t end = first + count; part != parts_.end(); ++part) {
      const Part& p = **part;
      const std::uint64_t from = p.*begin_of;
      if (from >= end) return;
      const std::uint64_t size = of_points ? p.stream->points() : p.stream->cells();
      const std::uint64_t lo = std::max(first, from), hi = std::min(end, from + size);
      if (lo < hi) f(p, lo - from, hi - lo);
    }
  }

  template <class Read>
  void read_numbered(std::uint64_t first, std::uint64_t count, std::size_t stride,
                     std::span<std::byte> out, Read read) const;
  void number_points(CellWindow* window, std::uint64_t first_point) const;
  static void append(CellWindow&& window, std::uint64_t first, CellWindow* out);

  const MeshDescription& description_;
  bool can_stream_ = true;
  std::vector<std::unique_ptr<Part>> parts_;
  PieceNumbers numbers_;
  std::uint64_t ghosts_ = 0;
  LowerCount lower_;
  mutable std::mutex mutex_;
  mutable std::optional<CopyDifferences> differences_;  // once somebody has asked
};

MeshDescription describe_piece(const MeshDescription& mesh, const VtuPiece& piece) {
  MeshDescription d;
  d.path = mesh.path;
  d.points = piece.points;
  d.cells = piece.cells;
  d.point_type = mesh.point_type;
  d.point_data = mesh.point_data;
  d.cell_data = mesh.cell_data;
  for (ArrayInfo& info : d.point_data.arrays) info.tuples = piece.points;
  for (ArrayInfo& info : d.cell_data.arrays) info.tuples = piece.cells;
  return d;
}

void PiecesStream::open(const std::vector<StreamPiece>& pieces, const OpenOptions& options) {
  check_point_count(*pieces.front().input, description_.points);
  std::uint64_t points = 0, cells = 0, tets = 0;
  for (const StreamPiece& p : pieces) {
    const VtuPiece& piece = p.input->head.pieces[p.piece];
    if (piece.cells > 0) {
      if (piece.points == 0) {  // reading it whole says best what is wrong with it
        can_stream_ = false;
        return;
      }
      auto part = std::make_unique<Part>();
      part->description = describe_piece(description_, piece);
      part->first_point = points;
      part->first_cell = cells;
      std::uint64_t own = 0;
      part->stream = open_piece_stream(*p.input, p.piece, part->description, options, &own);
      if (!part->stream) {
        can_stream_ = false;
        return;
      }
      tets += own;
      ghosts_ += part->stream->ghost_cells();
      lower_.cells += part->stream->lower_cells().cells;
      lower_.corners += part->stream->lower_cells().corners;
      parts_.push_back(std::move(part));
    }
    points += piece.points;
    cells += piece.cells;
  }
  if (tets == 0) {
    throw Error(ErrorCode::kBadInput, description_.path + ": the mesh has no tetrahedra");
  }
}

void PiecesStream::find_used_points() {
  CellWindow window;
  for (const auto& part : parts_) {
    const auto use = [&](VertexId v) {
      numbers_.use(static_cast<VertexId>(part->first_point + v));
    };
    for (std::uint64_t first = 0; first < part->stream->cells(); first += kCells) {
      const std::uint64_t count = std::min(kCells, part->stream->cells() - first);
      part->stream->read_cells(first, count, &window);
      for_each_block(window.tets.size(), kBlock,
                     [&](std::size_t, std::size_t begin, std::size_t end) {
                       for (std::size_t t = begin; t < end; ++t) {
                         for (const VertexId v : window.tets[t]) use(v);
                       }
                     });
      for (const VertexId v : window.lower.connectivity) use(v);
    }
  }
}

void PiecesStream::find_copies(bool merge_points) {
  // Points that are to be merged may have ids of their own.
  if (!merge_points && find_global_ids(description_.point_data) != AttributeSet::npos) {
    match(true, false);
    const bool are_global = lie_together(
        numbers_.joined(), description_.point_type, description_.points,
        [&, rows = Vector<std::byte>()](std::size_t, std::uint64_t first,
                                        std::uint64_t count) mutable {
          const std::uint64_t stride = 3 * size_of(description_.point_type);
          rows.resize(count * stride);
          for_each_part(first, count, &Part::first_point,
                        [&](const Part& part, std::uint64_t begin, std::uint64_t n) {
                          const std::uint64_t at = part.first_point + begin - first;
                          part.stream->read_points(
                              begin, n, std::span(rows).subspan(at * stride, n * stride));
                        });
          return std::span<const std::byte>(rows);
        });
    if (are_global) return;
    numbers_.forget_copies();
  }
  match(false, merge_points);
}

void PiecesStream::match(bool by_ids, bool also_within) {
  std::vector<std::uint64_t> begins;
  for (const auto& part : parts_) begins.push_back(part->first_point);
  begins.push_back(description_.points);
  Vector<std::byte> rows;
  const auto of_ids = [&](const Part& part, std::uint64_t first, std::uint64_t count,
                          PointKey* out) {
    const std::size_t ids = find_global_ids(description_.point_data);
    const ValueType type = description_.point_data.arrays[ids].type;
    rows.resize(count * size_of(type));
    part.stream->read_rows(Association::kPoint, ids, first, count, rows);
    visit_type(type, [&](auto zero) {
      const auto* values = reinterpret_cast<const decltype(zero)*>(rows.data());
      for (std::uint64_t i = 0; i < count; ++i) {
        out[i] = {static_cast<std::uint64_t>(static_cast<std::int64_t>(values[i])), 0, 0};
      }
    });
  };
  const auto of_points = [&](const Part& part, std::uint64_t first, std::uint64_t count,
                             PointKey* out) {
    rows.resize(count * 3 * size_of(description_.point_type));
    part.stream->read_points(first, count, rows);
    visit_type(description_.point_type, [&](auto zero) {
      const auto* xyz = reinterpret_cast<const decltype(zero)*>(rows.data());
      for (std::uint64_t i = 0; i < count; ++i) {
        out[i] =
            key_of_coordinates(static_cast<double>(xyz[3 * i]), static_cast<double>(xyz[3 * i + 1]),
                               static_cast<double>(xyz[3 * i + 2]));
      }
    });
  };
  numbers_.find_copies(
      begins,
      [&](std::uint64_t first, std::uint64_t count, PointKey* out) {
        for_each_part(first, count, &Part::first_point,
                      [&](const Part& part, std::uint64_t begin, std::uint64_t n) {
                        PointKey* const to = out + (part.first_point + begin - first);
                        if (by_ids) {
                          of_ids(part, begin, n, to);
                        } else {
                          of_points(part, begin, n, to);
                        }
                      });
      },
      std::max(kLeastMemory, kMemoryPerPoint * description_.points), also_within);
}

const CopyDifferences& PiecesStream::differences() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (differences_) return *differences_;
  const std::vector<ArrayInfo>& arrays = description_.point_data.arrays;
  Vector<std::byte> rows;
  const auto read = [&](std::size_t array, std::uint64_t first,
                        std::uint64_t count) -> std::span<const std::byte> {
    const std::size_t stride = arrays[array].row_bytes();
    rows.resize(count * stride);
    for_each_part(first, count, &Part::first_point,
                  [&](const Part& part, std::uint64_t begin, std::uint64_t n) {
                    const std::uint64_t at = part.first_point + begin - first;
                    part.stream->read_rows(Association::kPoint, array, begin, n,
                                           std::span(rows).subspan(at * stride, n * stride));
                  });
    return rows;
  };
  differences_ = find_differences(numbers_.joined(), arrays, read);
  return *differences_;
}

// Reads the points that lie between the window's, and keeps those that have numbers.
template <class Read>
void PiecesStream::read_numbered(std::uint64_t first, std::uint64_t count, std::size_t stride,
                                 std::span<std::byte> out, Read read) const {
  check_window(first, count, points());
  if (count == 0) return;
  const std::uint64_t begin = numbers_.point_of(first);
  const std::uint64_t end = numbers_.point_of(first + count - 1) + 1;
  Vector<std::byte> rows;
  std::byte* to = out.data();
  for (std::uint64_t at = begin; at < end; at += kPoints) {
    for_each_part(at, std::min(kPoints, end - at), &Part::first_point,
                  [&](const Part& part, std::uint64_t from, std::uint64_t n) {
                    rows.resize(n * stride);
                    read(part, from, n, rows);
                    for (std::uint64_t i = 0; i < n; ++i) {
                      if (!numbers_.stays(part.first_point + from + i)) continue;
                      std::copy_n(rows.data() + i * stride, stride, to);
                      to += stride;
                    }
                  });
  }
}

void PiecesStream::read_cells(std::uint64_t first, std::uint64_t count, CellWindow* out) const {
  check_window(first, count, cells());
  bool is_first = true;
  for_each_part(first, count, &Part::first_cell,
                [&](const Part& part, std::uint64_t begin, std::uint64_t n) {
                  CellWindow window;
                  CellWindow* const to = is_first ? out : &window;
                  part.stream->read_cells(begin, n, to);
                  number_points(to, part.first_point);
                  for (std::uint64_t& row : to->tet_rows) row += part.first_cell;
                  for (std::uint64_t& row : to->lower_rows) row += part.first_cell;
                  if (!is_first) append(std::move(window), part.first_cell + begin, out);
                  if (is_first && to->tet_rows.empty() && n < count) {
                    // The parts that follow may have rows of their own.
                    for (std::uint64_t i = 0; i < to->tets.size(); ++i) {
                      to->tet_rows.push_back(first + i);
                    }
                  }
                  is_first = false;
                });
  if (is_first) *out = {};
  if (out->tets.size() == count) out->tet_rows.clear();
}

void PiecesStream::number_points(CellWindow* window, std::uint64_t first_point) const {
  const auto number = [&](VertexId v) {
    return numbers_.number(static_cast<VertexId>(first_point + v));
  };
  for_each_block(window->tets.size(), kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      for (VertexId& v : window->tets[t]) v = number(v);
    }
  });
  for (VertexId& v : window->lower.connectivity) v = number(v);
}

// `first` is the row of the window's first cell.
void PiecesStream::append(CellWindow&& window, std::uint64_t first, CellWindow* out) {
  if (window.tet_rows.empty()) {
    for (std::uint64_t i = 0; i < window.tets.size(); ++i) window.tet_rows.push_back(first + i);
  }
  const auto add = [](auto* to, const auto& from) {
    to->insert(to->end(), from.begin(), from.end());
  };
  add(&out->tets, window.tets);
  add(&out->tet_rows, window.tet_rows);
  add(&out->lower_rows, window.lower_rows);
  out->lower.add(window.lower);
  out->ghost_cells += window.ghost_cells;
}

}  // namespace

std::unique_ptr<MeshStream> open_pieces_stream(const std::vector<StreamPiece>& pieces,
                                               const MeshDescription& description,
                                               const OpenOptions& options) {
  auto stream = std::make_unique<PiecesStream>(pieces, description, options);
  if (!stream->can_stream()) return nullptr;
  return stream;
}

}  // namespace tetfusion
