#include "mesh/quality.h"

#include <utility>
#include <variant>

#include "base/blocks.h"
#include "base/resources.h"
#include "base/tasks.h"
#include "mesh/vectors.h"

namespace tetfusion {

namespace {

constexpr std::size_t kTetsPerBlock = 1 << 17;

using Vector3 = Vec3<double>;

// Cosine of the smallest dihedral angle, from the normals of the four faces, all outwards or all
// inwards. A face without area counts as an angle of nothing.
double largest_cosine(const std::array<Vector3, 4>& normals) {
  std::array<double, 4> lengths{};
  for (std::size_t i = 0; i < 4; ++i) lengths[i] = std::sqrt(dot(normals[i], normals[i]));
  double largest = -1;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      const double scale = lengths[i] * lengths[j];
      const double cosine = scale > 0 ? -dot(normals[i], normals[j]) / scale : 1;
      largest = std::max(largest, cosine);
    }
  }
  return std::min(largest, 1.0);
}

std::size_t coarse_bin(double value, double bin_width) {
  return static_cast<std::size_t>(std::clamp(value / bin_width, 0.0, kQualityBins - 1.0));
}

}  // namespace

namespace {

using Edges = std::array<Vector3, 6>;  // ab, ac, ad, bc, bd, cd

Shape shape_of(const Edges& edges) {
  const auto& [ab, ac, ad, bc, bd, cd] = edges;
  const std::array<double, 6> squares{dot(ab, ab), dot(ac, ac), dot(ad, ad),
                                      dot(bc, bc), dot(bd, bd), dot(cd, cd)};
  const auto [shortest, longest] = std::minmax_element(squares.begin(), squares.end());
  const double sum = squares[0] + squares[1] + squares[2] + squares[3] + squares[4] + squares[5];
  const double half_volume3 = dot(ad, cross(ab, ac)) / 2;  // three volumes
  const double root = std::cbrt(half_volume3);
  const double ratio = sum > 0 ? std::copysign(12 * root * root, half_volume3) / sum : 0;
  const double cosine =
      largest_cosine({cross(bc, bd), cross(ad, ac), cross(ab, ad), cross(ac, ab)});
  const double aspect =
      *shortest > 0 ? std::sqrt(*longest / *shortest) : std::numeric_limits<double>::infinity();
  return {ratio, cosine, std::sqrt(*longest), std::sqrt(*shortest), aspect};
}

template <class Real>
Edges edges_of(const Vec3<Real>& a, const Vec3<Real>& b, const Vec3<Real>& c, const Vec3<Real>& d) {
  return {difference(b, a), difference(c, a), difference(d, a),
          difference(c, b), difference(d, b), difference(d, c)};
}

Vector3 times_power(const Vector3& v, int power) {
  return {std::scalbn(v.x, power), std::scalbn(v.y, power), std::scalbn(v.z, power)};
}

// In a unit in which all corners are below one, and then the longest edge is: fourth powers of
// edges would leave the range of double precision.
Shape shape_in_own_unit(std::array<Vector3, 4> corners) {
  const auto power_for = [](const auto& vectors) {
    double largest = 0;
    for (const Vector3& v : vectors) {
      largest = std::max({largest, std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    }
    return largest > 0 && std::isfinite(largest) ? -std::ilogb(largest) - 1 : 0;
  };
  const int first = power_for(corners);
  for (Vector3& p : corners) p = times_power(p, first);
  Edges edges = edges_of(corners[0], corners[1], corners[2], corners[3]);
  const int then = power_for(edges);
  for (Vector3& e : edges) e = times_power(e, then);
  Shape shape = shape_of(edges);
  shape.longest = std::scalbn(shape.longest, -first - then);
  shape.shortest = std::scalbn(shape.shortest, -first - then);
  return shape;
}

}  // namespace

template <class Real>
Shape measure_shape(const Vec3<Real>& a, const Vec3<Real>& b, const Vec3<Real>& c,
                    const Vec3<Real>& d) {
  const Shape shape = shape_of(edges_of(a, b, c, d));
  if (shape.longest > 1e-50 && shape.longest < 1e50) return shape;
  const auto wide = [](const Vec3<Real>& p) { return Vector3{p.x, p.y, p.z}; };
  return shape_in_own_unit({wide(a), wide(b), wide(c), wide(d)});
}

template Shape measure_shape(const Vec3<float>&, const Vec3<float>&, const Vec3<float>&,
                             const Vec3<float>&);
template Shape measure_shape(const Vec3<double>&, const Vec3<double>&, const Vec3<double>&,
                             const Vec3<double>&);

void QualityMeter::Values::add(double value) {
  sum.add(value);
  max = std::max(max, value);
  const double place = std::clamp((value - low) / width * kBins, 0.0, kBins - 1.0);
  const auto bin = static_cast<std::size_t>(place);
  ++cells[bin];
  least[bin] = std::min(least[bin], static_cast<float>(value));
}

void QualityMeter::Values::add(const Values& other) {
  sum.add(other.sum);
  max = std::max(max, other.max);
  for (std::size_t b = 0; b < kBins; ++b) {
    cells[b] += other.cells[b];
    least[b] = std::min(least[b], other.least[b]);
  }
}

Distribution QualityMeter::Values::distribution(std::uint64_t count) const {
  std::uint64_t below = 0;
  std::size_t bin = 0;
  while ((below += cells[bin]) <= count / 100) ++bin;
  const float min = *std::min_element(least.begin(), least.end());
  return {min, least[bin], sum.value() / static_cast<double>(count), static_cast<float>(max)};
}

QualityMeter::QualityMeter() {
  const auto begin = [](double low, double high, Values* values) {
    values->low = low;
    values->width = high - low;
    values->cells.assign(Values::kBins, 0);
    values->least.assign(Values::kBins, std::numeric_limits<float>::infinity());
  };
  begin(-1, 1, &ratios_);
  begin(0, 180, &angles_);
  extremes_.shortest_edge = std::numeric_limits<double>::infinity();
}

template <class Real>
void QualityMeter::measure(const Vector<Vec3<Real>>& points, std::span<const Tet> tets) {
  for (const Tet& t : tets) {
    const Shape s = measure_shape(points[t[0]], points[t[1]], points[t[2]], points[t[3]]);
    const double angle = std::acos(s.min_dihedral_cosine) * (180 / std::numbers::pi);
    ratios_.add(s.mean_ratio);
    angles_.add(angle);
    ++extremes_.mean_ratio_bins[coarse_bin(static_cast<float>(s.mean_ratio), 1.0 / kQualityBins)];
    ++extremes_.dihedral_bins[coarse_bin(static_cast<float>(angle), 5)];
    extremes_.longest_edge = std::max(extremes_.longest_edge, s.longest);
    extremes_.shortest_edge = std::min(extremes_.shortest_edge, s.shortest);
    extremes_.max_aspect = std::max(extremes_.max_aspect, s.aspect);
  }
  cells_ += tets.size();
}

void QualityMeter::add(const Points& points, std::span<const Tet> tets) {
  std::visit([&](const auto& p) { measure(p, tets); }, points);
}

void QualityMeter::add(const QualityMeter& other) {
  cells_ += other.cells_;
  ratios_.add(other.ratios_);
  angles_.add(other.angles_);
  for (std::size_t b = 0; b < kQualityBins; ++b) {
    extremes_.mean_ratio_bins[b] += other.extremes_.mean_ratio_bins[b];
    extremes_.dihedral_bins[b] += other.extremes_.dihedral_bins[b];
  }
  extremes_.longest_edge = std::max(extremes_.longest_edge, other.extremes_.longest_edge);
  extremes_.shortest_edge = std::min(extremes_.shortest_edge, other.extremes_.shortest_edge);
  extremes_.max_aspect = std::max(extremes_.max_aspect, other.extremes_.max_aspect);
}

Quality QualityMeter::quality() const {
  if (cells_ == 0) return {};
  Quality quality = extremes_;
  quality.mean_ratio = ratios_.distribution(cells_);
  quality.min_dihedral_deg = angles_.distribution(cells_);
  return quality;
}

Quality measure_quality(const Geometry& geometry) {
  const std::span<const Tet> tets(geometry.tets);
  QualityMeter all;
  InOrder<QualityMeter> join([&](const QualityMeter& part) { all.add(part); });
  run_tasks(block_count(tets.size(), kTetsPerBlock), thread_count(),
            [&](std::size_t b, std::size_t) {
              QualityMeter part;
              part.add(geometry.points,
                       tets.subspan(b * kTetsPerBlock,
                                    std::min(kTetsPerBlock, tets.size() - b * kTetsPerBlock)));
              join.put(b, std::move(part));
            });
  return all.quality();
}

}  // namespace tetfusion
