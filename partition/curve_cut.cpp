#include "partition/curve_cut.h"

#include <cmath>
#include <limits>

#include "partition/hilbert.h"

namespace tetfusion {

namespace {

// So many tetrahedra a chunk are sorted along the curve to find the cuts: the sizes of chunks then
// vary by a few percent.
constexpr std::uint64_t kSamples = 256;

// Multiples of these fill the cube evenly (Roberts' generalisation of the golden ratio to three
// dimensions).
constexpr Vec3<double> kStep{0.8191725133961645, 0.6710436067037893, 0.5497004779019703};

double fraction(double x) { return x - std::floor(x); }

// The curve through a cube of twice the bounding box's extent, in which the box's place depends on
// the round.
template <class Real>
class ShiftedCurve {
 public:
  ShiftedCurve(const Vector<Vec3<Real>>& positions, std::uint32_t round) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    Vec3<double> lo{kInfinity, kInfinity, kInfinity};
    Vec3<double> hi{-kInfinity, -kInfinity, -kInfinity};
    for (const Vec3<Real>& p : positions) {
      lo = {std::min<double>(lo.x, p.x), std::min<double>(lo.y, p.y), std::min<double>(lo.z, p.z)};
      hi = {std::max<double>(hi.x, p.x), std::max<double>(hi.y, p.y), std::max<double>(hi.z, p.z)};
    }
    // Halves cannot overflow.
    const double half_extent =
        std::max({hi.x / 2 - lo.x / 2, hi.y / 2 - lo.y / 2, hi.z / 2 - lo.z / 2});
    lo_ = lo;
    scale_ = half_extent > 0 ? half_extent : 1;
    shift_ = {fraction(round * kStep.x) / 2, fraction(round * kStep.y) / 2,
              fraction(round * kStep.z) / 2};
  }

  std::uint64_t key(const Vec3<Real>& p) const {
    return hilbert_key(cell(p.x, lo_.x, shift_.x), cell(p.y, lo_.y, shift_.y),
                       cell(p.z, lo_.z, shift_.z));
  }

 private:
  std::uint32_t cell(double value, double low, double shift) const {
    constexpr double kLast = (1 << kHilbertBits) - 1;
    const double inside = (value / 2 - low / 2) / scale_;  // 0 to 1
    return static_cast<std::uint32_t>(std::clamp((inside / 2 + shift) * kLast, 0.0, kLast));
  }

  Vec3<double> lo_{};
  double scale_ = 1;
  Vec3<double> shift_{};
};

}  // namespace

template <class Real>
CurveCut cut_curve(const Vector<Vec3<Real>>& positions, std::span<const Tet> tets,
                   std::uint64_t chunk_tets, std::uint32_t round) {
  CurveCut cut;
  cut.chunk_of_vertex.assign(positions.size(), 0);
  const std::uint64_t chunks = (tets.size() + chunk_tets - 1) / chunk_tets;
  if (chunks <= 1) return cut;
  const ShiftedCurve<Real> curve(positions, round);
  Vector<std::uint64_t> keys(positions.size());
  const auto n = static_cast<std::int64_t>(positions.size());
#pragma omp parallel for schedule(static)
  for (std::int64_t i = 0; i < n; ++i) {
    const auto v = static_cast<std::size_t>(i);
    keys[v] = curve.key(positions[v]);
  }

  const std::uint64_t step = std::max<std::uint64_t>(1, chunk_tets / kSamples);
  Vector<std::uint64_t> samples;
  for (std::uint64_t t = 0; t < tets.size(); t += step) {
    const Tet& tet = tets[t];
    samples.push_back(keys[std::min({tet[0], tet[1], tet[2], tet[3]})]);
  }
  std::sort(samples.begin(), samples.end());
  Vector<std::uint64_t> cuts;  // the first key of every chunk but the first
  for (std::uint64_t c = 1; c < chunks; ++c) cuts.push_back(samples[c * samples.size() / chunks]);

  cut.chunks = static_cast<std::uint32_t>(chunks);
#pragma omp parallel for schedule(static)
  for (std::int64_t i = 0; i < n; ++i) {
    const auto v = static_cast<std::size_t>(i);
    cut.chunk_of_vertex[v] = static_cast<std::uint32_t>(
        std::upper_bound(cuts.begin(), cuts.end(), keys[v]) - cuts.begin());
  }
  return cut;
}

template CurveCut cut_curve(const Vector<Vec3<float>>&, std::span<const Tet>, std::uint64_t,
                            std::uint32_t);
template CurveCut cut_curve(const Vector<Vec3<double>>&, std::span<const Tet>, std::uint64_t,
                            std::uint32_t);

}  // namespace tetfusion
