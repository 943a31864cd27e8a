#include "kernel/fields/field_integrals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>

#include "mesh/predicates.h"

namespace tetfusion {

namespace {

// What an integral over a cavity may change by where nothing can be chosen, as a share of that of
// the absolute values: a point is in some ten cavities, and the sum is to be right to 1e-12, or
// 1e-6 in single precision.
template <class T>
constexpr double kExactness = std::is_same_v<T, float> ? 1e-7 : 1e-13;

template <class T>
bool all_finite(const Column& column) {
  const T* const rows = reinterpret_cast<const T*>(column.rows.data());
  return std::all_of(rows, rows + column.rows.size() / sizeof(T),
                     [](T value) { return std::isfinite(value); });
}

}  // namespace

template <class Real>
void FieldIntegrals<Real>::begin(bool stay, std::span<const SteeringField> fields,
                                 std::span<const std::uint32_t> regions, WorkMesh<Real>* mesh) {
  stay_ = stay;
  transfer_.reset();
  fields_ = fields;
  mesh_ = mesh;
  steers_.assign(mesh->point_columns.size(), 0);
  for (const SteeringField& f : fields) {
    if (is_column(f, *mesh)) steers_[f.column] = 1;
  }
  mixed_columns_.clear();
  gap_columns_.clear();
  for (std::uint32_t c = 0; c < mesh->cell_columns.size(); ++c) {
    const Column& column = mesh->cell_columns[c];
    if (!is_float(column.type)) continue;
    if (std::find(regions.begin(), regions.end(), c) != regions.end()) continue;
    mixed_columns_.push_back(c);
    const bool finite =
        column.type == ValueType::kFloat32 ? all_finite<float>(column) : all_finite<double>(column);
    if (!finite) gap_columns_.push_back(c);
  }
}

// Volumes, six times.
template <class Real>
void FieldIntegrals<Real>::measure() {
  const auto& p = mesh_->positions;
  old_tets_.clear();
  before_.clear();
  after_.clear();
  sum_ = 0;
  for (const std::uint32_t entry : joining_.affected) {
    const Tet& tet = mesh_->tets[entry >> 2];
    const auto& order = kCornerFirst[entry & 3u];
    old_tets_.push_back(entry >> 2);
    after_.push_back(
        determinant(joining_.position, p[tet[order[1]]], p[tet[order[2]]], p[tet[order[3]]]).value);
    sum_ += after_.back();
  }
  old_tets_.insert(old_tets_.end(), joining_.deleted.begin(), joining_.deleted.end());
  for (const TetId t : old_tets_) before_.push_back(determinant(p, mesh_->tets[t]).value);
}

// Of the cavity as it is.
template <class Real>
template <class T>
auto FieldIntegrals<Real>::range_of(const T* rows, const Values& of) const -> Range {
  Range range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const TetId t : old_tets_) {
    for (const VertexId v : mesh_->tets[t]) {
      const double value{rows[v * of.width + of.k]};
      range.least = std::min(range.least, value);
      range.most = std::max(range.most, value);
    }
  }
  return range;
}

// The integral over a tetrahedron is its volume times the mean of its corners. All values are taken
// relative to one of them, so that a constant stays one to the bit.
template <class Real>
template <class T>
bool FieldIntegrals<Real>::solve(const T* rows, const Values& of, double* value) const {
  const auto at = [&](VertexId v) { return double{rows[v * of.width + of.k]}; };
  const double origin = at(joining_.fixed ? joining_.partner : joining_.v);
  double missing = 0, all = 0;
  for (std::size_t i = 0; i < old_tets_.size(); ++i) {
    double sum = 0, absolute = 0;
    for (const VertexId v : mesh_->tets[old_tets_[i]]) {
      sum += at(v) - origin;
      absolute += std::abs(at(v));
    }
    missing += before_[i] * sum;
    all += before_[i] * absolute;
    if (i >= after_.size()) continue;
    const std::uint32_t entry = joining_.affected[i];
    missing -= after_[i] * (sum - (at(mesh_->tets[entry >> 2][entry & 3u]) - origin));
  }
  if (!std::isfinite(all)) {
    *value = std::numeric_limits<double>::quiet_NaN();
    return true;
  }
  *value = origin;
  if (joining_.fixed) return std::abs(missing) <= of.exactness * all;
  const double wanted = origin + missing / sum_;
  const Range range = range_of(rows, of);
  const double rounding = of.exactness * std::max(std::abs(range.least), std::abs(range.most));
  *value = std::clamp(wanted, range.least, range.most);
  return std::abs(wanted - *value) <= rounding;
}

template <class Real>
bool FieldIntegrals<Real>::find(const Joining<Real>& joining, std::span<double> values) {
  joining_ = joining;
  measure();
  for (const SteeringField& f : fields_) {
    if (!is_column(f, *mesh_)) continue;
    const bool is_single = mesh_->point_columns[f.column].type == ValueType::kFloat32;
    const double exactness = is_single ? kExactness<float> : kExactness<double>;
    for (std::size_t k = f.first; k < f.first + f.count; ++k) {
      const Values of{mesh_->steering_width, k, exactness};
      if (!solve(mesh_->steering.data(), of, &values[k]) || !std::isfinite(values[k])) return false;
    }
  }
  rows_.clear();
  bool stays = true;
  for (std::size_t c = 0; c < steers_.size() && stays; ++c) {
    const Column& column = mesh_->point_columns[c];
    if (steers_[c] != 0) continue;
    visit_type(column.type, [&](auto zero) {
      using T = decltype(zero);
      if constexpr (std::is_floating_point_v<T>) {
        const T* rows = reinterpret_cast<const T*>(column.rows.data());
        for (std::size_t k = 0; k < column.components && stays; ++k) {
          stays = solve(rows, {column.components, k, kExactness<T>}, &rows_.emplace_back());
        }
      }
    });
  }
  return stays && can_mix_cells();
}

template <class Real>
bool FieldIntegrals<Real>::can_mix_cells() const {
  return std::ranges::all_of(gap_columns_, [&](std::uint32_t c) {
    const Column& column = mesh_->cell_columns[c];
    return column.type == ValueType::kFloat32 ? can_mix<float>(column) : can_mix<double>(column);
  });
}

// What is not finite would spread to every tetrahedron that overlaps its own: only what is the same
// in all of the cavity may be there.
template <class Real>
template <class T>
bool FieldIntegrals<Real>::can_mix(const Column& column) const {
  const T* const rows = reinterpret_cast<const T*>(column.rows.data());
  const std::size_t width = column.components;
  for (std::size_t k = 0; k < width; ++k) {
    const auto at = [&](TetId t) { return rows[t * width + k]; };
    const T first = at(old_tets_[0]);
    const bool is_number = std::isfinite(first);
    for (const TetId t : old_tets_) {
      const bool is_same = at(t) == first || (std::isnan(at(t)) && std::isnan(first));
      if (is_number ? !std::isfinite(at(t)) : !is_same) return false;
    }
  }
  return true;
}

template <class Real>
void FieldIntegrals<Real>::apply(VertexId kept, const Interpolation& interpolation) {
  if (!mixed_columns_.empty() && !transfer_) transfer_.emplace(*mesh_);
  const double* found = rows_.data();
  for (std::size_t c = 0; c < steers_.size() && !joining_.fixed; ++c) {
    Column& column = mesh_->point_columns[c];
    if (steers_[c] != 0) continue;
    visit_type(column.type, [&](auto zero) {
      using T = decltype(zero);
      T* rows = reinterpret_cast<T*>(column.rows.data());
      const std::size_t width = column.components;
      if constexpr (std::is_floating_point_v<T>) {
        for (std::size_t k = 0; k < width; ++k, ++found) {
          rows[kept * width + k] = static_cast<T>(
              std::isfinite(*found) ? *found : interpolate(interpolation, rows, width, k));
        }
      } else {
        std::copy_n(rows + interpolation.nearest * width, width, rows + kept * width);
      }
    });
  }
}

template <class Real>
void FieldIntegrals<Real>::finish() {
  if (transfer_) transfer_->run(mixed_columns_, mesh_);
  transfer_.reset();
}

template class FieldIntegrals<float>;
template class FieldIntegrals<double>;

}  // namespace tetfusion
