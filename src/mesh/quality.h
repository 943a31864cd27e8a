// How well shaped the tetrahedra of a mesh are.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "mesh/geometry.h"

namespace tetfusion {

// One tetrahedron's measures.
struct Shape {
  double mean_ratio;  // 12 (3 V)^(2/3) / sum of the squared edges: 1 for a regular one, 0 for a
                      // flat one, negative where the volume is
  double min_dihedral_cosine;  // of its smallest dihedral angle; 1 for one with a face without area
  double longest_squared;      // edges
  double shortest_squared;
};

// A measure over all cells.
struct Distribution {
  double min = 0;
  double p1 = 0;  // one cell in a hundred is below it
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

// All zero for a mesh without cells. Deterministic for any number of threads.
Quality measure_quality(const Geometry& geometry);

template <class Real>
Shape measure_shape(const Vec3<Real>& a, const Vec3<Real>& b, const Vec3<Real>& c,
                    const Vec3<Real>& d);

}  // namespace tetfusion
