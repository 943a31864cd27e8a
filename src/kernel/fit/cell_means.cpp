#include "kernel/fit/cell_means.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "base/mix.h"
#include "base/running_mean.h"
#include "mesh/predicates.h"
#include "mesh/regions/region_numbers.h"

namespace tetfusion {

namespace {

// Cells that are a smaller share of a tetrahedron say little of it. They may be beside it, too: a
// sliver's centre is rounded.
constexpr double kEnough = 1.0 / 8;

double mean_of_ascending(std::array<double, 4> x) {
  std::ranges::sort(x);
  return ((x[0] + x[1]) + (x[2] + x[3])) / 4;
}

std::uint32_t tag_of(std::uint64_t hash) { return static_cast<std::uint32_t>(hash >> 32); }

}  // namespace

template <class Real>
Vec3<double> centre_of(const Vector<Vec3<Real>>& positions, const Tet& tet) {
  const Vec3<Real>&a = positions[tet[0]], &b = positions[tet[1]];
  const Vec3<Real>&c = positions[tet[2]], &d = positions[tet[3]];
  return {mean_of_ascending({a.x, b.x, c.x, d.x}), mean_of_ascending({a.y, b.y, c.y, d.y}),
          mean_of_ascending({a.z, b.z, c.z, d.z})};
}

template <class Real>
std::uint64_t corners_hash(const Vector<Vec3<Real>>& positions, const Tet& tet) {
  std::uint64_t sum = 0;
  for (const VertexId v : tet) {
    const Vec3<Real>& p = positions[v];
    std::uint64_t hash = 0;
    for (const double x : {double{p.x}, double{p.y}, double{p.z}}) {
      hash = mix(hash ^ std::bit_cast<std::uint64_t>(x));
    }
    sum += hash;
  }
  return sum;
}

template <class Real>
double volume_of(const Vector<Vec3<Real>>& positions, const Tet& tet) {
  const Determinant volume = determinant(positions, tet);
  return volume.sign() > 0 ? volume.value : 0;
}

template Vec3<double> centre_of(const Vector<Vec3<float>>&, const Tet&);
template Vec3<double> centre_of(const Vector<Vec3<double>>&, const Tet&);
template std::uint64_t corners_hash(const Vector<Vec3<float>>&, const Tet&);
template std::uint64_t corners_hash(const Vector<Vec3<double>>&, const Tet&);
template double volume_of(const Vector<Vec3<float>>&, const Tet&);
template double volume_of(const Vector<Vec3<double>>&, const Tet&);

template <class Real>
std::uint64_t CellMeans<Real>::memory(std::uint64_t cells, std::uint64_t tets) {
  return cells * sizeof(TetId) + tets * (sizeof(double) + 4 * sizeof(Slot) + sizeof(Mean));
}

// What has no volume is left as it is: it is an odd cell, or lies over others.
template <class Real>
void CellMeans<Real>::begin(WorkMesh<Real>* mesh, std::span<const std::uint32_t> columns,
                            std::span<const std::uint32_t> labels, TetWalk<Real>* walk) {
  mesh_ = mesh;
  walk_ = walk;
  columns_.assign(columns.begin(), columns.end());
  labels_.assign(labels.begin(), labels.end());
  enough_.resize(mesh->tets.size());
  keys_.clear();
  for (const std::uint32_t c : labels_) {
    keys_.push_back(region_keys(mesh->cell_columns[c].type, mesh->cell_columns[c].rows));
  }
  tet_of_.clear();
  added_.clear();
  list_tets();
}

// Of two in one place, both stay.
template <class Real>
void CellMeans<Real>::list_tets() {
  slots_.assign(std::bit_ceil(2 * enough_.size() + 1), {});
  for (TetId t = 0; t < enough_.size(); ++t) {
    const double volume = volume_of(mesh_->positions, mesh_->tets[t]);
    enough_[t] = volume > 0 ? kEnough * volume : kNever;
    if (!(volume > 0)) continue;
    const std::uint64_t hash = corners_hash(mesh_->positions, mesh_->tets[t]);
    Slot& slot = slot_of(hash);
    if (slot.tet == kNoTet) {
      slot = {t, tag_of(hash)};
    } else {
      enough_[slot.tet] = enough_[t] = kNever;
    }
  }
}

// That of the tetrahedron with these corners, or where it would be.
template <class Real>
auto CellMeans<Real>::slot_of(std::uint64_t hash) -> Slot& {
  for (std::uint64_t i = hash;; ++i) {
    Slot& slot = slots_[i & (slots_.size() - 1)];
    if (slot.tet == kNoTet) return slot;
    if (slot.tag != tag_of(hash)) continue;
    if (corners_hash(mesh_->positions, mesh_->tets[slot.tet]) == hash) return slot;
  }
}

// Is the cell one of the tetrahedra? Wherever a walk would find it: meshes may overlap themselves.
template <class Real>
bool CellMeans<Real>::is_left(std::uint64_t hash) {
  const TetId tet = slot_of(hash).tet;
  if (tet == kNoTet) return false;
  keep(tet);
  return true;
}

template <class Real>
void CellMeans<Real>::add(const CellsToAverage& cells, std::uint64_t first, std::uint64_t step) {
  added_.push_back({first, step, cells.centres.size()});
  Keys keys;
  for (std::size_t k = 0; k < labels_.size(); ++k) {
    const Column& label = mesh_->cell_columns[labels_[k]];
    keys.push_back(
        region_keys(label.type, {cells.labels[k], cells.centres.size() * label.stride()}));
  }
  std::uint64_t next = first;
  for (std::uint64_t i = 0; i < cells.centres.size(); ++i) {
    const bool is_left_itself = is_left(cells.hashes[i]);
    if (i != next) continue;
    next += step;
    const bool counts = !is_left_itself && walk_->find(cells.centres[i]) &&
                        is_in_region_of(walk_->place().tet, keys, i);
    tet_of_.push_back(counts ? walk_->place().tet : kNoTet);
  }
}

template <class Real>
bool CellMeans<Real>::is_in_region_of(TetId tet, const Keys& keys, std::uint64_t cell) const {
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (keys_[k][tet] != keys[k][cell]) return false;
  }
  return true;
}

template <class Real>
void CellMeans<Real>::average(const ReadRows& read) {
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    Column& column = mesh_->cell_columns[columns_[c]];
    const auto read_column = [&](const UseRows& use) { read(c, use); };
    column.type == ValueType::kFloat32 ? average_column<float>(&column, read_column)
                                       : average_column<double>(&column, read_column);
  }
}

template <class Real>
template <class T>
void CellMeans<Real>::average_column(Column* column,
                                     const std::function<void(const UseRows& use)>& read) {
  const std::size_t width = column->components;
  T* const values = reinterpret_cast<T*>(column->rows.data());
  for (std::size_t k = 0; k < width; ++k) {
    means_.assign(mesh_->tets.size(), {});
    std::size_t next = 0;
    auto added = added_.begin();
    read([&](const double* volumes, const std::byte* rows) {
      const T* const originals = reinterpret_cast<const T*>(rows);
      for (std::uint64_t i = added->first; i < added->end; i += added->step) {
        const TetId tet = tet_of_[next++];
        if (tet == kNoTet || enough_[tet] == kNever) continue;
        add_up(static_cast<double>(added->step) * volumes[i], originals[i * width + k],
               &means_[tet]);
      }
      ++added;
    });
    for (std::size_t t = 0; t < means_.size(); ++t) {
      const Mean& m = means_[t];
      T& value = values[t * width + k];
      if (!(m.weight + m.lost > 0 && m.weight + m.lost >= enough_[t])) continue;
      if (m.lost > m.weight) {
        if (std::isfinite(value)) value = static_cast<T>(m.other);
        continue;
      }
      value = static_cast<T>(m.mean);
    }
  }
}

template <class Real>
void CellMeans<Real>::add_up(double volume, double value, Mean* mean) const {
  if (!std::isfinite(value)) {
    if (mean->lost == 0) mean->other = value;
    mean->lost += volume;
    return;
  }
  add_to_mean(value, volume, mean->weight, &mean->mean);
  mean->weight += volume;
}

template class CellMeans<float>;
template class CellMeans<double>;

}  // namespace tetfusion
