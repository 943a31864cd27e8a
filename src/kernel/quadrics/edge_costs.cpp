#include "kernel/quadrics/edge_costs.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace tetfusion {

namespace {

// best_position(): enough to keep a vertex between its two where the fields are flat, and too
// little to draw it out of a plane or line in which a field bends, as that would cost something
// where it need not. Below some 1e-6 it drowns in what rounding does to quadrics.
constexpr float kPull = 2e-5F;
constexpr float kReachSquared = 0.25F;  // half the edge

// What between_lanes() works on: quadrics and what lies behind them, sums, differences.
constexpr std::size_t lanes_for(std::size_t width) { return 2 * quadric_size(width) + 1 + width; }

// Best on an edge from the origin to d.
template <class F>
OffsetOf<F> best_on(const ReducedOf<F>& reduced, const OffsetOf<F>& d) {
  const OffsetOf<F> home{0.5F * d[0], 0.5F * d[1], 0.5F * d[2]};
  return best_position(reduced, home, kPull, kReachSquared * dot(d.data(), d));
}

// Best on the edge itself.
Offset best_on_line(const Reduced& r, const Offset& d) {
  const Offset home{0.5F * d[0], 0.5F * d[1], 0.5F * d[2]};
  const Offset mh = times(r.m.data(), home), md = times(r.m.data(), d);
  const Offset g{mh[0] + r.n[0], mh[1] + r.n[1], mh[2] + r.n[2]};
  const float curvature = dot(md.data(), d) + kPull * (r.m[0] + r.m[3] + r.m[5]) * dot(d.data(), d);
  const float t =
      0.5F + (curvature > 0 ? std::clamp(-dot(g.data(), d) / curvature, -0.5F, 0.5F) : 0);
  return {t * d[0], t * d[1], t * d[2]};
}

// The cost of a sum of squares with this weight, at one end of an edge of this length.
template <class F>
F cost_of(F squares, F weight, F length_squared, std::size_t width) {
  // What is less than nothing is so by rounding; what is no number stays that.
  const F mean = select(weight > 0.0F, select(squares <= 0.0F, F{}, squares) / weight, F{});
  return mean + length_cost(width > 0) * length_squared;
}

}  // namespace

template <class Real>
void EdgeCosts<Real>::begin(const WorkMesh<Real>* mesh, std::span<const SteeringField> fields,
                            double unit, double sheet_weight) {
  mesh_ = mesh;
  unit_ = unit;
  sheet_weight_ = static_cast<float>(sheet_weight);
  width_ = mesh->steering_width;
  scale_.resize(width_);
  for (const SteeringField& f : fields) {
    for (std::uint32_t k = 0; k < f.count; ++k) {
      scale_[f.first + k] = static_cast<float>(1 / f.range);
    }
  }
  differences_.resize(width_);
  sum_.resize(quadric_size(width_));
  lanes_.resize(lanes_for(width_));
}

template <class Real>
Offset EdgeCosts<Real>::offset(const Vec3<Real>& from, const Vec3<Real>& to) const {
  return {static_cast<float>((double{to.x} - from.x) * unit_),
          static_cast<float>((double{to.y} - from.y) * unit_),
          static_cast<float>((double{to.z} - from.z) * unit_)};
}

template <class Real>
Vec3<Real> EdgeCosts<Real>::position_at(VertexId from, const Offset& u) const {
  const Vec3<Real>& p = mesh_->positions[from];
  const double length = 1 / unit_;
  return {static_cast<Real>(p.x + u[0] * length), static_cast<Real>(p.y + u[1] * length),
          static_cast<Real>(p.z + u[2] * length)};
}

// Of fields' values, as shares of their ranges.
template <class Real>
const float* EdgeCosts<Real>::differences(const double* from, const double* to) {
  for (std::size_t k = 0; k < width_; ++k) {
    differences_[k] = static_cast<float>(to[k] - from[k]) * scale_[k];
  }
  return differences_.data();
}

template <class Real>
void EdgeCosts<Real>::between(VertexId v, std::span<const VertexId> partners, float* costs) {
  for (std::size_t i = 0; i < partners.size(); i += kLanes) {
    const auto group = partners.subspan(i, std::min(kLanes, partners.size() - i));
    // A scalar, a vector, and the sums of a series are worth their own code.
    switch (width_) {
      case 1:
        between_lanes<1>(v, group, costs + i);
        break;
      case 3:
        between_lanes<3>(v, group, costs + i);
        break;
      case 4:
        between_lanes<4>(v, group, costs + i);
        break;
      case 6:
        between_lanes<6>(v, group, costs + i);
        break;
      case 8:
        between_lanes<8>(v, group, costs + i);
        break;
      default:
        between_lanes<0>(v, group, costs + i);
    }
  }
}

// So many partners as there are lanes, or fewer. kWidth is the number of steering values, or 0 for
// any.
template <class Real>
template <std::size_t kWidth>
void EdgeCosts<Real>::between_lanes(VertexId v, std::span<const VertexId> partners, float* costs) {
  const std::size_t width = kWidth != 0 ? kWidth : width_;
  const std::size_t size = quadric_size(width);
  std::array<Lanes, kWidth != 0 ? lanes_for(kWidth) : 1> small;
  Lanes* from = kWidth != 0 ? small.data() : lanes_.data();
  Lanes* sum = from + size + 1;
  Lanes* t = sum + size;
  std::array<VertexId, kLanes> u;
  for (std::size_t i = 0; i < kLanes; ++i) u[i] = partners[std::min(i, partners.size() - 1)];
  // Behind a quadric a row has a number more.
  static_assert((quadric_size(0) + 1) % kLanes == 0);
  std::array<Lanes, kLanes> rows;
  for (std::size_t j = 0; j < size; j += kLanes) {
    for (std::size_t i = 0; i < kLanes; ++i)
      std::memcpy(&rows[i], quadric(u[i]) + j, sizeof rows[i]);
    const auto columns = transposed(rows);
    std::copy(columns.begin(), columns.end(), from + j);
  }
  for (std::size_t i = 0; i < kLanes; ++i) {
    const Offset edge = offset(mesh_->positions[v], mesh_->positions[u[i]]);
    rows[i] = Lanes{edge[0], edge[1], edge[2], 0};
  }
  const auto [x, y, z, none] = transposed(rows);
  const OffsetOf<Lanes> d{x, y, z};
  for (std::size_t k = 0; k < width; ++k) {
    const auto difference = [&](std::size_t i) {
      return static_cast<float>(values(v)[k] - values(u[i])[k]) * scale_[k];
    };
    t[k] = Lanes{difference(0), difference(1), difference(2), difference(3)};
  }
  for (std::size_t j = 0; j < size; ++j) sum[j] = Lanes{} + quadric(v)[j];
  add_shifted(from, {-d[0], -d[1], -d[2]}, t, width, sum);
  const ReducedOf<Lanes> reduced = reduce(sum, width);
  const Lanes squares = value_at(reduced, best_on(reduced, d));
  const Lanes all = cost_of(squares, sum[kQuadricW], dot(d.data(), d), width);
  for (std::size_t i = 0; i < partners.size(); ++i) costs[i] = all[i];
}

template <class Real>
float EdgeCosts<Real>::onto(VertexId v, VertexId partner) {
  const Offset d = offset(mesh_->positions[v], mesh_->positions[partner]);
  std::copy_n(quadric(partner), sum_.size(), sum_.begin());
  add_shifted(quadric(v), d, differences(values(v), values(partner)), width_, sum_.data());
  return cost_of(sum_[kQuadricC], sum_[kQuadricW], dot(d.data(), d), width_);
}

template <class Real>
void EdgeCosts<Real>::merge(VertexId v, VertexId partner, MergedQuadric* out) {
  MergedQuadric& m = *out;
  m.sum.resize(quadric_size(width_));
  m.edge = offset(mesh_->positions[v], mesh_->positions[partner]);
  std::copy_n(quadric(v), m.sum.size(), m.sum.begin());
  add_shifted(quadric(partner), {-m.edge[0], -m.edge[1], -m.edge[2]},
              differences(values(partner), values(v)), width_, m.sum.data());
  m.reduced = reduce(m.sum.data(), width_);
  m.best = best_on(m.reduced, m.edge);
}

// The mean of the fields' squares, and the weighted mean of the sheet's.
template <class Real>
void EdgeCosts<Real>::merge_on_sheet(VertexId v, VertexId partner, Along along,
                                     MergedQuadric* out) {
  merge(v, partner, out);
  MergedQuadric& m = *out;
  std::copy_n(sheet_quadric(v), m.sheet.size(), m.sheet.begin());
  add_shifted(sheet_quadric(partner), {-m.edge[0], -m.edge[1], -m.edge[2]}, nullptr, 0,
              m.sheet.data());
  const float area = m.sheet[kQuadricW];
  const float weight = m.sum[kQuadricW];
  const float of_fields = weight > 0 ? 1 / weight : 0.0F;
  const float of_sheet = area > 0 ? sheet_weight_ / area : 0.0F;
  for (std::size_t i = 0; i < 6; ++i) {
    m.reduced.m[i] = of_fields * m.reduced.m[i] + of_sheet * m.sheet[i];
  }
  for (std::size_t i = 0; i < 3; ++i) {
    m.reduced.n[i] = of_fields * m.reduced.n[i] + of_sheet * m.sheet[kQuadricL + i];
  }
  m.reduced.k = of_fields * m.reduced.k + of_sheet * m.sheet[kQuadricC];
  m.best = along == Along::kLine ? best_on_line(m.reduced, m.edge) : best_on(m.reduced, m.edge);
}

template <class Real>
float EdgeCosts<Real>::between_on_sheet(VertexId v, VertexId partner, Along along) {
  merge_on_sheet(v, partner, along, &on_sheet_);
  const MergedQuadric& m = on_sheet_;
  return cost_of(value_at(m.reduced, m.best), 1.0F, dot(m.edge.data(), m.edge), width_);
}

template <class Real>
float EdgeCosts<Real>::onto_on_sheet(VertexId v, VertexId partner) {
  const float of_fields = onto(v, partner);
  const Offset d = offset(mesh_->positions[v], mesh_->positions[partner]);
  std::array<float, quadric_size(0)> sheet{};
  std::copy_n(sheet_quadric(partner), sheet.size(), sheet.begin());
  add_shifted(sheet_quadric(v), d, nullptr, 0, sheet.data());
  const float area = sheet[kQuadricW];
  return of_fields + (area > 0 ? sheet_weight_ * std::max(sheet[kQuadricC], 0.0F) / area : 0.0F);
}

template <class Real>
void EdgeCosts<Real>::add(VertexId v, const Vec3<Real>& position, const double* at, float* row) {
  add_shifted(quadric(v), offset(mesh_->positions[v], position), differences(values(v), at), width_,
              row);
}

// Which is about v.
template <class Real>
void EdgeCosts<Real>::add(const MergedQuadric& merged, VertexId v, const Vec3<Real>& position,
                          const double* at, float* row) {
  add_shifted(merged.sum.data(), offset(mesh_->positions[v], position), differences(values(v), at),
              width_, row);
}

template <class Real>
void EdgeCosts<Real>::add_sheet(VertexId v, const Vec3<Real>& position, float* row) {
  add_shifted(sheet_quadric(v), offset(mesh_->positions[v], position), nullptr, 0,
              row + quadric_size(width_));
}

template <class Real>
void EdgeCosts<Real>::add_sheet(const MergedQuadric& merged, VertexId v, const Vec3<Real>& position,
                                float* row) {
  add_shifted(merged.sheet.data(), offset(mesh_->positions[v], position), nullptr, 0,
              row + quadric_size(width_));
}

template class EdgeCosts<float>;
template class EdgeCosts<double>;

}  // namespace tetfusion
