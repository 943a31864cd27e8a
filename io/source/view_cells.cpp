#include "io/source/view_cells.h"

#include "base/error.h"
#include "mesh/split_cells.h"

namespace tetfusion {

ViewCells::ViewCells(const MeshView& view, const OpenOptions& options)
    : view_(view), options_(options), points_(view.points.size() / 3) {
  if (points_ > kMaxPoints) {
    throw Error(ErrorCode::kMemory, view.name + ": " + std::to_string(points_) +
                                        " points are more than can be held in memory at once (" +
                                        std::to_string(kMaxPoints) + ")");
  }
  is_wide() ? look_at_all<std::int64_t>() : look_at_all<std::int32_t>();
  if (tets_ == 0 && as_they_are_) {
    throw Error(ErrorCode::kBadInput, view.name + ": the mesh has no tetrahedra");
  }
  if (tets_ > kMaxTets) fail_too_many_tets(view.name, tets_);
}

bool ViewCells::is_ghost(std::uint64_t cell) const {
  return !view_.ghosts.empty() && (view_.ghosts[cell] & kGhostDropped) != 0;
}

bool ViewCells::is_left_out(std::uint64_t cell) const {
  return is_ghost(cell) || is_dropped_patch(type_of(cell), options_);
}

std::uint8_t ViewCells::type_of(std::uint64_t cell) const {
  if (view_.tets_only) return kVtkTetra;
  const std::uint8_t type = view_.types[cell];
  if (!is_of_any_order(type)) return type;
  const std::uint64_t ids = is_wide() ? ids_of<std::int64_t>(cell) : ids_of<std::int32_t>(cell);
  return settled_type(type, ids);
}

void ViewCells::fail(std::uint64_t cell, const std::string& what) const {
  throw Error(ErrorCode::kBadInput, view_.name + ": cell " + std::to_string(cell) + " " + what);
}

template <class Id>
void ViewCells::look_at_all() {
  const std::uint64_t ids = view_.connectivity.size();
  if (!view_.tets_only && begin_of<Id>(0) != 0) {
    throw Error(ErrorCode::kBadInput, view_.name + ": the first offset is not 0");
  }
  for (std::uint64_t c = 0; c < size(); ++c) look_at<Id>(c);
  const std::uint64_t end = begin_of<Id>(size());
  if (end == ids) return;
  throw Error(ErrorCode::kBadInput, view_.name + ": the connectivity has " + std::to_string(ids) +
                                        " values, but the cells end at " + std::to_string(end));
}

template <class Id>
void ViewCells::look_at(std::uint64_t cell) {
  const std::uint64_t begin = begin_of<Id>(cell);
  const std::uint64_t end = begin_of<Id>(cell + 1);
  const std::uint64_t limit = view_.connectivity.size();
  if (end < begin || end > limit) {
    fail(cell, "goes from " + std::to_string(begin) + " to " +
                   std::to_string(static_cast<std::int64_t>(end)) + ", but there are " +
                   std::to_string(limit) + " vertex ids");
  }
  const std::span<const Id> ids = numbers<Id>(view_.connectivity).subspan(begin, end - begin);
  for (const Id id : ids) {
    if (static_cast<std::uint64_t>(id) < points_) continue;  // negative ones are too large
    throw InvalidMesh(view_.name + ": cell " + std::to_string(cell) + " " +
                      wrong_vertex(std::to_string(id), points_));
  }
  if (is_ghost(cell)) {
    ++ghosts_;
    return;
  }
  const std::uint8_t type = type_of(cell);
  if (is_dropped_patch(type, options_)) return;
  if (kept_vertices(type, options_) < 0) fail(cell, refusal(type, options_, true));
  if (!may_have_vertices(type, ids.size())) {
    fail(cell, wrong_vertex_count(type, ids.size()));
  }
  if (type == kVtkTetra) {
    ++tets_;
    return;
  }
  ++lower_.cells;
  lower_.corners += ids.size();
  as_they_are_ = as_they_are_ && (type == kVtkVertex || type == kVtkLine || type == kVtkTriangle);
}

void ViewCells::read(std::uint64_t first, std::uint64_t count, CellWindow* out) const {
  out->tets.clear();
  out->tet_rows.clear();
  out->lower.types.clear();
  out->lower.offsets.clear();
  out->lower.connectivity.clear();
  out->lower_rows.clear();
  out->ghost_cells = 0;
  is_wide() ? read_as<std::int64_t>(first, count, out) : read_as<std::int32_t>(first, count, out);
}

template <class Id>
void ViewCells::read_as(std::uint64_t first, std::uint64_t count, CellWindow* out) const {
  const std::span<const Id> ids = numbers<Id>(view_.connectivity);
  const bool all_tets = ghosts_ == 0 && tets_ == size();
  out->tets.reserve(count);
  LowerCells& lower = out->lower;
  for (std::uint64_t c = first; c < first + count; ++c) {
    if (is_left_out(c)) {
      out->ghost_cells += is_ghost(c) ? 1 : 0;
      continue;
    }
    const std::uint64_t begin = begin_of<Id>(c);
    const auto id = [&](std::uint64_t k) { return static_cast<VertexId>(ids[begin + k]); };
    if (type_of(c) == kVtkTetra) {
      out->tets.push_back({id(0), id(1), id(2), id(3)});
      if (!all_tets) out->tet_rows.push_back(c);
      continue;
    }
    if (lower.offsets.empty()) lower.offsets.push_back(0);
    const std::uint64_t corners = begin_of<Id>(c + 1) - begin;
    for (std::uint64_t k = 0; k < corners; ++k) lower.connectivity.push_back(id(k));
    lower.types.push_back(type_of(c));
    lower.offsets.push_back(lower.connectivity.size());
    out->lower_rows.push_back(c);
  }
}

FileCells ViewCells::all() const {
  FileCells cells;
  cells.ghosts = ghosts_;
  cells.types.resize(size());
  for (std::uint64_t c = 0; c < size(); ++c) {
    cells.types[c] = is_left_out(c) ? kLeftOut : type_of(c);
  }
  const auto copy = [&](auto zero) {
    using Id = decltype(zero);
    cells.offsets.resize(size() + 1);
    for (std::uint64_t c = 0; c <= size(); ++c) cells.offsets[c] = begin_of<Id>(c);
    const std::span<const Id> ids = numbers<Id>(view_.connectivity);
    cells.connectivity.resize(ids.size());
    for (std::size_t k = 0; k < ids.size(); ++k) {
      cells.connectivity[k] = static_cast<VertexId>(ids[k]);
    }
  };
  is_wide() ? copy(std::int64_t{}) : copy(std::int32_t{});
  return cells;
}

}  // namespace tetfusion
