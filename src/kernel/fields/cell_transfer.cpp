#include "kernel/fields/cell_transfer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "mesh/predicates.h"

namespace tetfusion {

namespace {

// What may be missing of a tetrahedron's volume, as a share of it, when all that it overlaps has
// been found.
constexpr double kMissing = 1e-13;
// What it overlaps is near what had its number: whoever has looked at so many in vain gives up.
constexpr std::size_t kMostInVain = 100'000;

template <class Real>
Vec3<double> to_double(const Vec3<Real>& p) {
  return {p.x, p.y, p.z};
}

template <class Real>
bool is_same(const Vec3<Real>& a, const Vec3<Real>& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}

}  // namespace

template <class Real>
CellTransfer<Real>::CellTransfer(const WorkMesh<Real>& mesh)
    : tets_(mesh.tets), positions_(mesh.positions) {}

template <class Real>
TetCorners CellTransfer<Real>::old_corners(TetId t) const {
  TetCorners out;
  for (std::size_t i = 0; i < 4; ++i) out[i] = to_double(positions_[tets_[t][i]]);
  return out;
}

template <class Real>
void CellTransfer<Real>::find_changes(const WorkMesh<Real>& mesh) {
  changed_.resize(tets_.size());
  for (TetId t = 0; t < tets_.size(); ++t) {
    changed_[t] = mesh.tets[t] != tets_[t] || !std::ranges::all_of(tets_[t], [&](VertexId v) {
                    return is_same(mesh.positions[v], positions_[v]);
                  });
  }
}

template <class Real>
void CellTransfer<Real>::run(std::span<const std::uint32_t> columns, WorkMesh<Real>* mesh) {
  find_changes(*mesh);
  neighbours_.begin(positions_.size(), tets_);
  stop_for_.assign(tets_.size(), kNoTet);
  std::vector<Vector<std::byte>> rows;
  for (const std::uint32_t c : columns) rows.push_back(mesh->cell_columns[c].rows);
  for (TetId t = 0; t < tets_.size(); ++t) {
    if (changed_[t] == 0 || is_deleted(mesh->tets[t])) continue;
    TetCorners corners;
    for (std::size_t i = 0; i < 4; ++i) corners[i] = to_double(mesh->positions[mesh->tets[t][i]]);
    find_shares(t, corners);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const Column& column = mesh->cell_columns[columns[i]];
      column.type == ValueType::kFloat32 ? mix<float>(t, column, &rows[i])
                                         : mix<double>(t, column, &rows[i]);
    }
  }
  for (std::size_t i = 0; i < columns.size(); ++i) {
    mesh->cell_columns[columns[i]].rows = std::move(rows[i]);
  }
}

// What has not changed keeps what it has.
template <class Real>
void CellTransfer<Real>::add_stop(TetId old) {
  if (old == kNoTet || changed_[old] == 0 || stop_for_[old] == tet_) return;
  stop_for_[old] = tet_;
  stops_.push_back({old});
}

template <class Real>
void CellTransfer<Real>::go_on_from(std::size_t stop, unsigned faces) {
  const TetId old = stops_[stop].old;
  const unsigned through = std::exchange(stops_[stop].open, stops_[stop].open & ~faces) & faces;
  for (std::size_t corner = 0; corner < 4; ++corner) {
    if ((through >> corner & 1u) != 0) add_stop(neighbours_.beyond(old, corner));
  }
}

// From what had the tetrahedron's number round by round to something that it overlaps, and from
// there through all that it does, over faces that it has something beyond. Where rounding, or a
// flat cell, stands between them, the way is through all that is near.
template <class Real>
void CellTransfer<Real>::find_shares(TetId tet, const TetCorners& corners) {
  const OverlapTet shape(corners);
  const double wanted =
      (1 - kMissing) * determinant(corners[0], corners[1], corners[2], corners[3]).value;
  tet_ = tet;
  stops_.clear();
  shares_.clear();
  double found = 0;
  const auto look_at = [&](std::size_t i) {
    const Overlap overlap = shape.with(old_corners(stops_[i].old));
    if (overlap.volume > 0) shares_.push_back({stops_[i].old, overlap.volume});
    found += overlap.volume;
    return overlap;
  };
  add_stop(tet);
  std::size_t looked_at = 0;
  for (; looked_at < stops_.size(); ++looked_at) {
    const Overlap overlap = look_at(looked_at);
    const bool is_in_vain = shares_.empty() && stops_.size() < kMostInVain;
    if (overlap.volume > 0 || is_in_vain) go_on_from(looked_at, overlap.crossed);
  }
  for (std::size_t i = 0; i < stops_.size() && found < wanted; ++i) {
    if (i >= looked_at) look_at(i);
    if (shape.is_near(old_corners(stops_[i].old))) go_on_from(i, stops_[i].open);
  }
  for (Share& share : shares_) share.weight /= found;
}

// All values are taken relative to one of them, so that a constant stays one to the bit. Where one
// is no number all are, but for what rounding has found.
template <class Real>
template <class T>
void CellTransfer<Real>::mix(TetId tet, const Column& column, Vector<std::byte>* rows) const {
  const T* const old = reinterpret_cast<const T*>(column.rows.data());
  T* const out = reinterpret_cast<T*>(rows->data());
  const std::size_t width = column.components;
  for (std::size_t k = 0; k < width; ++k) {
    const double origin{old[tet * width + k]};
    if (!std::isfinite(origin)) continue;
    double value = origin;
    for (const Share& share : shares_) {
      const double other{old[share.old * width + k]};
      if (std::isfinite(other)) value += share.weight * (other - origin);
    }
    out[tet * width + k] = static_cast<T>(value);
  }
}

template class CellTransfer<float>;
template class CellTransfer<double>;

}  // namespace tetfusion
