#include "partition/curve_cut.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "mesh/hilbert.h"

namespace tetfusion {

namespace {

// Multiples of these fill the cube evenly (Roberts' generalisation of the golden ratio to three
// dimensions).
constexpr Vec3<double> kStep{0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double fraction(double x) { return x - std::floor(x); }

Vector<std::uint64_t> first_keys_of(std::uint32_t chunks, Vector<std::uint64_t> samples) {
  Vector<std::uint64_t> first_keys;
  if (samples.empty()) return first_keys;
  std::sort(samples.begin(), samples.end());
  for (std::uint64_t c = 1; c < chunks; ++c) {
    first_keys.push_back(samples[c * samples.size() / chunks]);
  }
  return first_keys;
}

}  // namespace

Box::Box() : lo{kInfinity, kInfinity, kInfinity}, hi{-kInfinity, -kInfinity, -kInfinity} {}

void Box::add(const Vec3<double>& p) {
  if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) return;
  Box point;
  point.lo = point.hi = p;
  add(point);
}

void Box::add(const Box& other) {
  lo = {std::min(lo.x, other.lo.x), std::min(lo.y, other.lo.y), std::min(lo.z, other.lo.z)};
  hi = {std::max(hi.x, other.hi.x), std::max(hi.y, other.hi.y), std::max(hi.z, other.hi.z)};
}

template <class Real>
Box without_outliers(const Box& box, std::span<const Vec3<Real>> samples) {
  constexpr double kReach = 64;
  constexpr std::size_t kOneIn = 100;  // may be far away, on each side
  Box out = box;
  const auto clip = [&](auto axis) {
    std::vector<double> values;
    for (const Vec3<Real>& p : samples) {
      if (std::isfinite(p.*axis.first)) values.push_back(p.*axis.first);
    }
    if (values.empty()) return;
    const auto value_at = [&](std::size_t rank) {
      const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
      std::nth_element(values.begin(), at, values.end());
      return *at;
    };
    const double low = value_at(values.size() / kOneIn);
    const double high = value_at(values.size() - 1 - values.size() / kOneIn);
    if (!(high > low)) return;
    const double reach = kReach * (high - low);
    out.lo.*axis.second = std::max(out.lo.*axis.second, low - reach);
    out.hi.*axis.second = std::min(out.hi.*axis.second, high + reach);
  };
  clip(std::pair(&Vec3<Real>::x, &Vec3<double>::x));
  clip(std::pair(&Vec3<Real>::y, &Vec3<double>::y));
  clip(std::pair(&Vec3<Real>::z, &Vec3<double>::z));
  return out;
}

template Box without_outliers(const Box&, std::span<const Vec3<float>>);
template Box without_outliers(const Box&, std::span<const Vec3<double>>);

ShiftedCurve::ShiftedCurve(const Box& box, std::uint32_t round) {
  if (!(box.lo.x <= box.hi.x)) return;
  // Halves cannot overflow.
  const double half_extent = std::max(
      {box.hi.x / 2 - box.lo.x / 2, box.hi.y / 2 - box.lo.y / 2, box.hi.z / 2 - box.lo.z / 2});
  lo_ = box.lo;
  scale_ = half_extent > 0 ? half_extent : 1;
  shift_ = {fraction(round * kStep.x) / 2, fraction(round * kStep.y) / 2,
            fraction(round * kStep.z) / 2};
}

std::uint32_t ShiftedCurve::cell(double value, double low, double shift) const {
  constexpr double kLast = (1 << kHilbertBits) - 1;
  const double inside = (value / 2 - low / 2) / scale_;  // 0 to 1
  const double place = (inside / 2 + shift) * kLast;
  return place >= 0 ? static_cast<std::uint32_t>(std::min(place, kLast)) : 0;  // 0 for no number
}

template <class Real>
std::uint64_t ShiftedCurve::key(const Vec3<Real>& p) const {
  return hilbert_key(cell(p.x, lo_.x, shift_.x), cell(p.y, lo_.y, shift_.y),
                     cell(p.z, lo_.z, shift_.z));
}

CurveCut::CurveCut(const ShiftedCurve& curve, std::uint32_t chunks, Vector<std::uint64_t> samples)
    : CurveCut(curve, first_keys_of(chunks, std::move(samples))) {}

CurveCut::CurveCut(const ShiftedCurve& curve, Vector<std::uint64_t> first_keys)
    : curve_(curve), first_keys_(std::move(first_keys)) {
  if (first_keys_.empty()) return;
  std::uint32_t chunk = 0;
  for (std::uint64_t i = 0; i <= std::uint64_t{1} << kTableBits; ++i) {
    const std::uint64_t key = i << (3 * kHilbertBits - kTableBits);
    while (chunk < first_keys_.size() && first_keys_[chunk] <= key) ++chunk;
    table_.push_back(chunk);
  }
}

std::uint32_t CurveCut::chunk_of_key(std::uint64_t key) const {
  if (first_keys_.empty()) return 0;
  const std::uint64_t slot = key >> (3 * kHilbertBits - kTableBits);
  // The cuts in this part of the curve: mostly none.
  const auto* begin = first_keys_.data() + table_[slot];
  const auto* end = first_keys_.data() + table_[slot + 1];
  return static_cast<std::uint32_t>(std::upper_bound(begin, end, key) - first_keys_.data());
}

template std::uint64_t ShiftedCurve::key(const Vec3<float>&) const;
template std::uint64_t ShiftedCurve::key(const Vec3<double>&) const;

}  // namespace tetfusion
