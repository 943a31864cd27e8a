#include "mesh/quality.h"

#include <variant>
#include <vector>

#include "mesh/blocks.h"
#include "mesh/sums.h"

namespace tetfusion {

namespace {

constexpr std::size_t kBlock = 1 << 16;

using Vector3 = Vec3<double>;

template <class Real>
Vector3 difference(const Vec3<Real>& a, const Vec3<Real>& b) {
  return {double{a.x} - b.x, double{a.y} - b.y, double{a.z} - b.z};
}
double dot(const Vector3& a, const Vector3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

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

struct BlockFindings {
  CompensatedSum mean_ratio, dihedral;
  double longest_squared = 0;
  double shortest_squared = std::numeric_limits<double>::infinity();
  double max_aspect_squared = 0;
};

Distribution distribution(Vector<float>* values, double mean) {
  const std::size_t hundredth = values->size() / 100;
  const auto at = values->begin() + static_cast<std::ptrdiff_t>(hundredth);
  std::nth_element(values->begin(), at, values->end());
  return {*std::min_element(values->begin(), at + 1), *at, mean,
          *std::max_element(at, values->end())};
}

std::array<std::uint64_t, kQualityBins> histogram(const Vector<float>& values, double bin_width) {
  std::array<std::uint64_t, kQualityBins> bins{};
  for (const float x : values) {
    const double bin = std::clamp(x / bin_width, 0.0, kQualityBins - 1.0);
    ++bins[static_cast<std::size_t>(bin)];
  }
  return bins;
}

template <class Real>
Quality measure(const Vector<Vec3<Real>>& points, const Vector<Tet>& tets) {
  Quality quality;
  if (tets.empty()) return quality;
  Vector<float> ratios(tets.size()), angles(tets.size());
  std::vector<BlockFindings> blocks(block_count(tets.size(), kBlock));
  for_each_block(tets.size(), kBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
    BlockFindings& found = blocks[b];
    for (std::size_t i = begin; i < end; ++i) {
      const Tet& t = tets[i];
      const Shape s = measure_shape(points[t[0]], points[t[1]], points[t[2]], points[t[3]]);
      const double angle = std::acos(s.min_dihedral_cosine) * (180 / std::numbers::pi);
      found.mean_ratio.add(s.mean_ratio);
      found.dihedral.add(angle);
      ratios[i] = static_cast<float>(s.mean_ratio);
      angles[i] = static_cast<float>(angle);
      found.longest_squared = std::max(found.longest_squared, s.longest_squared);
      found.shortest_squared = std::min(found.shortest_squared, s.shortest_squared);
      const double aspect = s.shortest_squared > 0 ? s.longest_squared / s.shortest_squared
                                                   : std::numeric_limits<double>::infinity();
      found.max_aspect_squared = std::max(found.max_aspect_squared, aspect);
    }
  });
  BlockFindings all;
  for (const BlockFindings& found : blocks) {
    all.mean_ratio.add(found.mean_ratio);
    all.dihedral.add(found.dihedral);
    all.longest_squared = std::max(all.longest_squared, found.longest_squared);
    all.shortest_squared = std::min(all.shortest_squared, found.shortest_squared);
    all.max_aspect_squared = std::max(all.max_aspect_squared, found.max_aspect_squared);
  }
  const auto cells = static_cast<double>(tets.size());
  quality.mean_ratio_bins = histogram(ratios, 1.0 / kQualityBins);
  quality.dihedral_bins = histogram(angles, 5);
  quality.mean_ratio = distribution(&ratios, all.mean_ratio.value() / cells);
  quality.min_dihedral_deg = distribution(&angles, all.dihedral.value() / cells);
  quality.longest_edge = std::sqrt(all.longest_squared);
  quality.shortest_edge = std::sqrt(all.shortest_squared);
  quality.max_aspect = std::sqrt(all.max_aspect_squared);
  return quality;
}

}  // namespace

template <class Real>
Shape measure_shape(const Vec3<Real>& a, const Vec3<Real>& b, const Vec3<Real>& c,
                    const Vec3<Real>& d) {
  const Vector3 ab = difference(b, a), ac = difference(c, a), ad = difference(d, a);
  const Vector3 bc = difference(c, b), bd = difference(d, b), cd = difference(d, c);
  const std::array<double, 6> squares{dot(ab, ab), dot(ac, ac), dot(ad, ad),
                                      dot(bc, bc), dot(bd, bd), dot(cd, cd)};
  const auto [shortest, longest] = std::minmax_element(squares.begin(), squares.end());
  const double sum = squares[0] + squares[1] + squares[2] + squares[3] + squares[4] + squares[5];
  const double half_volume3 = dot(ad, cross(ab, ac)) / 2;  // three volumes
  const double root = std::cbrt(half_volume3);
  const double ratio = sum > 0 ? std::copysign(12 * root * root, half_volume3) / sum : 0;
  const double cosine =
      largest_cosine({cross(bc, bd), cross(ad, ac), cross(ab, ad), cross(ac, ab)});
  return {ratio, cosine, *longest, *shortest};
}

template Shape measure_shape(const Vec3<float>&, const Vec3<float>&, const Vec3<float>&,
                             const Vec3<float>&);
template Shape measure_shape(const Vec3<double>&, const Vec3<double>&, const Vec3<double>&,
                             const Vec3<double>&);

Quality measure_quality(const Geometry& geometry) {
  return std::visit([&](const auto& points) { return measure(points, geometry.tets); },
                    geometry.points);
}

}  // namespace tetfusion
