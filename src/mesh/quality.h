// How well shaped the tetrahedra of a mesh are.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>

#include "base/sums.h"
#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

// One tetrahedron's measures.
struct Shape {
  double mean_ratio;  // 12 (3 V)^(2/3) / sum of the squared edges: 1 for a regular one, 0 for a
                      // flat one, negative where the volume is
  double min_dihedral_cosine;  // of its smallest dihedral angle; 1 for one with a face without area
  double longest;              // edges
  double shortest;
  double aspect;  // the ratio of these; infinite at an edge without length
};

// A measure over all cells.
struct Distribution {
  double min = 0;
  double p1 = 0;  // one cell in a hundred is below it, about
  double mean = 0;
  double max = 0;
};

inline constexpr std::size_t kQualityBins = 18;

struct Quality {
  Distribution mean_ratio;
  Distribution min_dihedral_deg;  // of each cell's smallest dihedral angle; at most 70.53
  // Cells by mean ratio, in equal bins over 0..1, and by smallest dihedral angle in bins of 5
  // degrees. A value on the border of two bins is in the upper one.
  std::array<std::uint64_t, kQualityBins> mean_ratio_bins{};
  std::array<std::uint64_t, kQualityBins> dihedral_bins{};
  double longest_edge = 0;
  double shortest_edge = 0;
  double max_aspect = 0;  // the largest ratio of longest to shortest edge in one cell; infinite at
                          // an edge without length
};

// Measures a mesh part by part. A part's hundredth is known to within a bin: 1/8192 of a mean
// ratio, 1/90 of a degree.
class QualityMeter {
 public:
  QualityMeter();

  // Starts no threads. The corners index the points.
  void add(const Points& points, std::span<const Tet> tets);
  // What another one has measured. The same order of parts gives the same bits.
  void add(const QualityMeter& other);

  // All zero without cells.
  Quality quality() const;

 private:
  // One measure of all cells.
  struct Values {
    static constexpr std::size_t kBins = 1 << 14;
    double low = 0, width = 0;  // of all bins together
    CompensatedSum sum;
    double max = -std::numeric_limits<double>::infinity();
    Vector<std::uint64_t> cells;  // one a bin
    Vector<float> least;          // the smallest value of each bin

    void add(double value);
    void add(const Values& other);
    Distribution distribution(std::uint64_t count) const;
  };
  template <class Real>
  void measure(const Vector<Vec3<Real>>& points, std::span<const Tet> tets);

  std::uint64_t cells_ = 0;
  Values ratios_, angles_;
  Quality extremes_;  // the coarse bins, lengths and the aspect
};

// Of the whole mesh, on as many threads as there are. Deterministic for any number of them.
Quality measure_quality(const Geometry& geometry);

template <class Real>
Shape measure_shape(const Vec3<Real>& a, const Vec3<Real>& b, const Vec3<Real>& c,
                    const Vec3<Real>& d);

}  // namespace tetfusion
