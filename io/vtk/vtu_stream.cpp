#include "io/vtk/vtu_stream.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/bit_set.h"
#include "base/error.h"
#include "io/source/cell_kinds.h"
#include "io/source/cell_windows.h"
#include "io/vtk/vtu_cell_arrays.h"
#include "io/vtk/vtu_points.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kMaxChunkBytes = std::uint64_t{16} << 20;
// Of cells or points that are looked at when the stream is opened.
constexpr std::uint64_t kScanned = std::uint64_t{1} << 20;

// What the types and ghost flags of all cells say.
struct CellSurvey {
  bool tets_only = true;    // ghosts too
  bool as_they_are = true;  // none is to be split or linearized
  std::uint64_t tets = 0;
  std::uint64_t ghosts = 0;
  LowerCount lower;  // if all are as they are
};

// What is read of a stream.
enum class Wanted { kAll, kRows };

class VtuStream final : public MeshStream {
 public:
  // The readers are opened and the arrays looked at in the order of read_geometry(), so that the
  // same fault is found first.
  VtuStream(const VtuInput& input, std::size_t piece, const MeshDescription& description,
            const OpenOptions& options, Wanted wanted)
      : input_(input),
        piece_(piece),
        description_(description),
        options_(options),
        wanted_(wanted),
        coordinates_(open_coordinates(input, piece)),
        bad_points_(find_bad_points()),
        arrays_(input, piece),
        types_(arrays_.open_types()),
        ghosts_(arrays_.open_ghosts()),
        survey_(survey()),
        offsets_(arrays_.open_offsets()),
        connectivity_(arrays_.open_connectivity()),
        point_readers_(description.point_data.arrays.size()),
        cell_readers_(description.cell_data.arrays.size()) {
    if (!can_stream() || wanted == Wanted::kRows) return;
    if (survey_.tets_only) {
      arrays_.check_tet_offsets(offsets_);
      arrays_.check_length(connectivity_, 4 * cells());
    }
  }

  // False: the mesh must be read whole, and this object is of no use.
  bool can_stream() const {
    return survey_.as_they_are && connectivity_.chunk_bytes() <= kMaxChunkBytes;
  }

  std::uint64_t tets() const { return survey_.tets; }  // no ghosts
  std::uint64_t points() const override { return description_.points; }
  std::uint64_t cells() const override { return description_.cells; }
  LowerCount lower_cells() const override { return survey_.lower; }
  std::uint64_t ghost_cells() const override { return survey_.ghosts; }
  std::uint64_t merged_points() const override { return 0; }
  std::uint64_t dropped_points() const override { return 0; }
  bool streams_from_disk() const override { return true; }

  void read_points(std::uint64_t first, std::uint64_t count,
                   std::span<std::byte> out) const override {
    check_window(first, count, points());
    input_.guarded(
        [&] { read_coordinates(coordinates_, description_.point_type, first, count, out.data()); });
  }

  void read_cells(std::uint64_t first, std::uint64_t count, CellWindow* out) const override {
    check_window(first, count, cells());
    if (wanted_ != Wanted::kAll) throw std::logic_error("cells of a stream of rows");
    clear(out);
    if (count == 0) return;
    input_.guarded([&] {
      if (survey_.tets_only) {
        read_tets(first, count, out);
      } else {
        read_mixed(first, count, out);
      }
      if (!bad_points_.empty()) check_finite(*out);
    });
  }

  void read_rows(Association association, std::size_t index, std::uint64_t first,
                 std::uint64_t count, std::span<std::byte> out) const override {
    const bool of_points = association == Association::kPoint;
    check_window(first, count, of_points ? points() : cells());
    const AttributeSet& set = of_points ? description_.point_data : description_.cell_data;
    const ArrayInfo& info = set.arrays.at(index);
    input_.guarded([&] {
      const ArrayReader& reader = attribute(of_points, index);
      reader.read(first * info.components, count * info.components, out.data());
    });
    forget_ghosts(association, info, out.first(count * info.row_bytes()));
  }

 private:
  // ---- opening ----

  BitSet find_bad_points() const {
    check_point_count(input_, points());
    BitSet bad;
    if (wanted_ == Wanted::kRows || all_finite(coordinates_)) return bad;
    bad.resize(points());
    Vector<Vec3<double>> window(std::min(points(), kScanned));
    for (std::uint64_t first = 0; first < points(); first += kScanned) {
      const std::uint64_t count = std::min(kScanned, points() - first);
      std::byte* const to = reinterpret_cast<std::byte*>(window.data());
      if (read_coordinates(coordinates_, ValueType::kFloat64, first, count, to)) continue;
      for (std::uint64_t i = 0; i < count; ++i) {
        const Vec3<double>& p = window[i];
        if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) continue;
        bad.set(first + i);
      }
    }
    return bad;
  }

  CellSurvey survey() const {
    CellSurvey found;
    Vector<std::uint8_t> types(std::min(cells(), kScanned));
    for (std::uint64_t first = 0; first < cells(); first += kScanned) {
      const std::uint64_t count = std::min(kScanned, cells() - first);
      arrays_.read_types(types_, first, count, types.data());
      const auto end = types.begin() + static_cast<std::ptrdiff_t>(count);
      const auto tets = static_cast<std::uint64_t>(std::count(types.begin(), end, kVtkTetra));
      found.tets_only = found.tets_only && tets == count;
      const std::uint64_t ghosts = arrays_.mark_ghosts(ghosts_, first, count, types.data());
      found.ghosts += ghosts;
      if (tets == count) {
        found.tets += tets - ghosts;
        continue;
      }
      for (std::uint64_t i = 0; i < count; ++i) look_at(first + i, types[i], &found);
    }
    return found;
  }

  void look_at(std::uint64_t cell, std::uint8_t type, CellSurvey* found) const {
    if (type == kVtkTetra) ++found->tets;
    if (type == kVtkTetra || type == kLeftOut || is_dropped_patch(type, options_)) return;
    const int kept = kept_vertices(type, options_);
    if (kept < 0) arrays_.refuse(cell, type, options_);
    const bool lower = type == kVtkVertex || type == kVtkLine || type == kVtkTriangle;
    found->as_they_are = found->as_they_are && lower;
    ++found->lower.cells;
    found->lower.corners += static_cast<std::uint64_t>(kept);
  }

  // Opened when it is first asked for.
  const ArrayReader& attribute(bool of_points, std::size_t index) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::unique_ptr<ArrayReader>& reader = (of_points ? point_readers_ : cell_readers_)[index];
    if (reader == nullptr) {
      const VtuPiece& piece = input_.head.pieces[piece_];
      const VtuArray& array = (of_points ? piece.point_data : piece.cell_data)[index];
      reader = std::make_unique<ArrayReader>(
          input_.open(array, std::string(of_points ? "point" : "cell") + " array \"" +
                                 array.info.name + "\"" + input_.of_piece(piece_)));
    }
    return *reader;
  }

  // ---- cells ----

  void read_tets(std::uint64_t first, std::uint64_t count, CellWindow* out) const {
    out->tets.resize(count);
    arrays_.read_ids(
        connectivity_, {4 * first, 4 * count, 0}, [](std::uint64_t value) { return value / 4; },
        nullptr, out->tets.data()->data());
    if (survey_.ghosts == 0) return;
    const Vector<std::uint8_t> types = read_types(first, count, out);
    if (out->ghost_cells == 0) return;
    std::size_t kept = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
      if (types[i] == kLeftOut) continue;
      out->tets[kept++] = out->tets[i];
      out->tet_rows.push_back(first + i);
    }
    out->tets.resize(kept);
  }

  Vector<std::uint8_t> read_types(std::uint64_t first, std::uint64_t count, CellWindow* out) const {
    Vector<std::uint8_t> types(count);
    arrays_.read_types(types_, first, count, types.data());
    out->ghost_cells = arrays_.mark_ghosts(ghosts_, first, count, types.data());
    leave_out_patches(options_, types);
    return types;
  }

  void read_mixed(std::uint64_t first, std::uint64_t count, CellWindow* out) const {
    const Vector<std::uint8_t> types = read_types(first, count, out);
    Vector<std::uint64_t> ends(count + 1);
    arrays_.read_ends(offsets_, first, count, ends.data());
    arrays_.check_cells(offsets_, options_, first, count, types.data(), ends.data(),
                        connectivity_.values());
    if (first + count == cells()) arrays_.check_length(connectivity_, ends[count]);
    Vector<VertexId> ids(ends[count] - ends[0]);
    arrays_.read_ids(
        connectivity_, {ends[0], ids.size(), 0},
        [&](std::uint64_t value) {
          const auto next = std::upper_bound(ends.begin() + 1, ends.end(), value);
          return first + static_cast<std::uint64_t>(next - (ends.begin() + 1));
        },
        nullptr, ids.data());
    sort_cells({first, types, ends, ids}, out);
  }

  // Throws InvalidMesh for the lowest point of a cell that is not finite.
  void check_finite(const CellWindow& window) const {
    const VertexId lowest = lowest_vertex(window, [&](VertexId v) { return bad_points_.has(v); });
    if (lowest != kNoVertex) fail_not_finite(coordinates_, lowest);
  }

  const VtuInput& input_;
  std::size_t piece_;
  const MeshDescription& description_;
  const OpenOptions& options_;
  const Wanted wanted_;
  ArrayReader coordinates_;
  BitSet bad_points_;  // those that are not finite; empty when all are
  VtuCellArrays arrays_;
  VtuCellArrays::TypeArray types_;
  std::vector<VtuCellArrays::GhostArray> ghosts_;
  CellSurvey survey_;
  ArrayReader offsets_;
  ArrayReader connectivity_;
  mutable std::mutex mutex_;
  mutable std::vector<std::unique_ptr<ArrayReader>> point_readers_;
  mutable std::vector<std::unique_ptr<ArrayReader>> cell_readers_;
};

// Nothing where the mesh must be read whole.
std::unique_ptr<VtuStream> open(const VtuInput& input, std::size_t piece,
                                const MeshDescription& description, const OpenOptions& options,
                                Wanted wanted) {
  std::unique_ptr<VtuStream> stream;
  input.guarded(
      [&] { stream = std::make_unique<VtuStream>(input, piece, description, options, wanted); });
  if (!stream->can_stream()) return nullptr;
  return stream;
}

}  // namespace

std::unique_ptr<MeshStream> open_piece_stream(const VtuInput& input, std::size_t piece,
                                              const MeshDescription& description,
                                              const OpenOptions& options, std::uint64_t* tets) {
  auto stream = open(input, piece, description, options, Wanted::kAll);
  if (stream) *tets = stream->tets();
  return stream;
}

std::unique_ptr<MeshStream> open_vtu_stream(const VtuInput& input,
                                            const MeshDescription& description,
                                            const OpenOptions& options) {
  std::uint64_t tets = 0;
  auto stream = open_piece_stream(input, 0, description, options, &tets);
  if (stream && tets == 0) input.fail(ErrorCode::kBadInput, "the mesh has no tetrahedra");
  return stream;
}

std::unique_ptr<MeshStream> open_vtu_rows(const VtuInput& input, const MeshDescription& description,
                                          const OpenOptions& options) {
  return open(input, 0, description, options, Wanted::kRows);
}

}  // namespace tetfusion
