#include "refine/refinable_mesh.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

// Points or tetrahedra that are added before somebody looks at the memory.
constexpr std::size_t kAtOnce = 256;

}  // namespace

RefinableMesh::RefinableMesh(const ProgressiveCounts& counts, std::size_t point_row_bytes,
                             std::size_t cell_row_bytes, Fail fail, const std::string& folder)
    : point_row_(point_row_bytes),
      cell_row_(cell_row_bytes),
      fail_(std::move(fail)),
      point_rows_(folder, counts.points * point_row_),
      cell_rows_(folder, counts.cells * cell_row_),
      types_(folder, counts.cells),
      corners_(folder, counts.cells),
      stars_(folder, counts.points, counts.tets),
      shares_(kMaxGone + 1) {}

// Of each tetrahedron four entries of lists that have a quarter of room, and what was left.
std::uint64_t RefinableMesh::bytes_for(const ProgressiveCounts& counts, std::size_t point_row_bytes,
                                       std::size_t cell_row_bytes) {
  return counts.points * (point_row_bytes + 16) +
         counts.cells * (cell_row_bytes + 1 + sizeof(Tet)) + counts.tets * 6 * sizeof(TetId);
}

void RefinableMesh::expect(std::span<const VertexId> kept, std::span<const TetId> tets) const {
  const auto is_there = [this](VertexId v) { return v < stars_.size(); };
  const std::size_t n = kept.size();
  if (n > 3 && is_there(kept[3])) stars_.expect(kept[3]);
  if (n > 2 && is_there(kept[2])) stars_.expect_entries(kept[2]);
  if (n > 1 && is_there(kept[1])) {
    for (const TetId t : stars_.of(kept[1])) __builtin_prefetch(&corners_[t]);
    __builtin_prefetch(point_row(kept[1]), 1);
  }
  if (n > 0 && is_there(kept[0])) {
    for (const TetId t : stars_.of(kept[0])) {
      for (const VertexId v : corners_[t]) stars_.expect(v);
    }
  }
  for (const TetId t : tets) {
    if (t >= types_.size()) continue;
    __builtin_prefetch(&corners_[t], 1);
    __builtin_prefetch(&types_[t], 1);
  }
}

void RefinableMesh::let_go() const {
  point_rows_.let_go();
  cell_rows_.let_go();
  types_.let_go();
  corners_.let_go();
  stars_.let_go();
}

std::span<const VertexId> RefinableMesh::corners_of(std::size_t cell) const {
  if (types_[cell] == kVtkTetra) return corners_[cell];
  const std::size_t i = corners_[cell][0];
  return lower_.corners(i);
}

void RefinableMesh::add_point(VertexId v, const std::byte* row) {
  require(v < stars_.size() && stars_.stamp(v) == 0, "a point comes twice, or has a wrong number");
  stars_.stamp(v) = 1;
  ++points_;
  std::memcpy(point_rows_.data() + v * point_row_, row, point_row_);
}

void RefinableMesh::add_points(const PointRows& points, const std::function<void()>& keep) {
  for (std::size_t i = 0; i < points.numbers.size(); ++i) {
    if (keep && i % kAtOnce == 0) keep();
    add_point(points.numbers[i], points.rows.data() + i * point_row_);
  }
}

void RefinableMesh::add_tet(TetId number, const Tet& corners, const std::byte* row) {
  require(number < types_.size() && types_[number] == 0,
          "a cell comes twice, or has a wrong number");
  types_[number] = kVtkTetra;
  corners_[number] = corners;
  if (cell_row_ > 0) std::memcpy(cell_rows_.data() + number * cell_row_, row, cell_row_);
  for (std::size_t c = 0; c < 4; ++c) {
    require(is_point(corners[c]), "a tetrahedron names a point that there is not");
    // A broken one of the original may name a point twice.
    const auto end = corners.begin() + static_cast<std::ptrdiff_t>(c);
    if (std::find(corners.begin(), end, corners[c]) == end) stars_.add(corners[c], number);
  }
  ++tets_;
  ++cells_;
}

void RefinableMesh::add_tets(const TetRows& tets, const std::function<void()>& keep) {
  for (std::size_t i = 0; i < tets.numbers.size(); ++i) {
    if (keep && i % kAtOnce == 0) keep();
    add_tet(tets.numbers[i], tets.corners[i], tets.rows.data() + i * cell_row_);
  }
}

void RefinableMesh::add_lower(const LowerRows& lower) {
  for (std::size_t i = 0; i < lower.numbers.size(); ++i) {
    const TetId number = lower.numbers[i];
    const std::uint8_t type = lower.cells.types[i];
    require(number < types_.size() && types_[number] == 0,
            "a cell comes twice, or has a wrong number");
    const std::span<const VertexId> corners = lower.cells.corners(i);
    const bool is_lower = (type == kVtkVertex && corners.size() == 1) ||
                          (type == kVtkLine && corners.size() == 2) ||
                          (type == kVtkTriangle && corners.size() == 3);
    require(is_lower, "a cell is of no type that it may be of");
    require(std::all_of(corners.begin(), corners.end(), [&](VertexId v) { return is_point(v); }),
            "a cell names a point that there is not");
    types_[number] = type;
    corners_[number][0] = static_cast<VertexId>(lower_.types.size());
    lower_.add(type, corners);
    if (cell_row_ > 0) {
      std::memcpy(cell_rows_.data() + number * cell_row_, lower.rows.data() + i * cell_row_,
                  cell_row_);
    }
    ++cells_;
  }
}

void RefinableMesh::undo(const FusionRecord& record) {
  require(is_point(record.kept), "a fusion is of a point that there is not");
  const std::span<const TetId> star = stars_.of(record.kept);
  star_.assign(star.begin(), star.end());
  std::sort(star_.begin(), star_.end());
  require(star_.size() == record.star.size(),
          "a fusion has not as many tetrahedra as it says to have");
  bring_points(record);
  find_codes(record);
  share_star(record);
  bring_tets(record);
}

void RefinableMesh::rewind(std::span<const TetId> tets) {
  for (const TetId t : tets) {
    require(t < types_.size() && types_[t] == kVtkTetra, "a cell to be rewound is no tetrahedron");
    std::swap(corners_[t][2], corners_[t][3]);
  }
}

void RefinableMesh::bring_points(const FusionRecord& record) {
  std::byte* kept = point_rows_.data() + record.kept * point_row_;
  kept_row_.assign(kept, kept + point_row_);
  row_.resize(point_row_);
  const std::byte* from = record.rows.data();
  const auto next_row = [&] {
    for (std::size_t b = 0; b < point_row_; ++b) row_[b] = from[b] ^ kept_row_[b];
    from += point_row_;
  };
  if (record.row_changed(point_row_)) {
    next_row();
    std::copy(row_.begin(), row_.end(), kept);
  }
  for (const VertexId v : record.points) {
    next_row();
    add_point(v, row_.data());
  }
}

// As the kernel's notes have it: the kept vertex, the points that come back, the ring.
void RefinableMesh::find_codes(const FusionRecord& record) {
  ++stamped_;
  codes_.clear();
  const auto add = [&](VertexId v) {
    if (stars_.stamp(v) == stamped_) return;
    stars_.stamp(v) = stamped_;
    stars_.expect_end(v);
    codes_.push_back(v);
  };
  add(record.kept);
  for (const VertexId v : record.points) add(v);
  for (const TetId t : star_) {
    for (const VertexId v : corners_[t]) add(v);
  }
}

void RefinableMesh::share_star(const FusionRecord& record) {
  for (std::vector<TetId>& share : shares_) share.clear();
  for (std::size_t i = 0; i < star_.size(); ++i) {
    const std::uint8_t whose = record.star[i];
    shares_[whose].push_back(star_[i]);
    if (whose == 0) continue;
    Tet& tet = corners_[star_[i]];
    *std::find(tet.begin(), tet.end(), record.kept) = record.points[whose - 1];
  }
  stars_.replace(record.kept, shares_[0]);
  for (std::uint32_t i = 0; i < record.gone; ++i) stars_.replace(record.points[i], shares_[i + 1]);
}

void RefinableMesh::bring_tets(const FusionRecord& record) {
  std::size_t elsewhere = 0;
  for (std::size_t i = 0; i < record.tets.size(); ++i) {
    Tet tet{};
    for (std::size_t c = 0; c < 4; ++c) {
      const CornerCode code = record.corners[i][c];
      if (code == kNoCode) {
        tet[c] = record.elsewhere[elsewhere++];
      } else {
        require(code < codes_.size(), "a tetrahedron names a point that there is not");
        tet[c] = codes_[code];
      }
    }
    add_tet(record.tets[i], tet, record.tet_rows.data() + i * cell_row_);
  }
}

}  // namespace tetfusion
