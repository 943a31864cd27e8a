// What differs between an original and the simplified mesh, summed up.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "base/blocks.h"
#include "base/sums.h"
#include "compare/fields.h"
#include "compare/hilbert_curve.h"
#include "compare/locator.h"
#include "compare/original_mesh.h"
#include "compare/simplified_mesh.h"
#include "compare/sorted_by_key.h"
#include "mesh/statistics.h"

namespace tetfusion {

// Differences of a field at places in space.
struct Errors {
  // Of what is never negative, so that rounding takes no more than it adds up to block by block.
  double squares = 0;  // of the Euclidean differences, times the weights
  double weights = 0;
  double differing = 0;  // weights of the places where the values differ at all
  double max_squared = 0;
  Point max_at{};                // the first place where the difference is that large
  std::uint64_t non_finite = 0;  // places left out: the original's value is not finite there
  std::uint64_t undefined = 0;   // places left out: only the simplified mesh's value is not finite
  Point undefined_at{};          // the first of these

  void add(double weight, double squared, const Point& at) {
    squares += weight * squared;
    weights += weight;
    if (squared > 0) differing += weight;
    if (squared > max_squared) {
      max_squared = squared;
      max_at = at;
    }
  }
  void add_undefined(const Point& at) {
    if (undefined++ == 0) undefined_at = at;
  }
  void add(const Errors& other);
  double rms() const;
  double max() const;
};

// Integrals over a domain: of each component, and of the length of the vector. Cells with a value
// that is not finite are left out.
struct Integral {
  std::vector<CompensatedSum> components;
  CompensatedSum length;

  // Of a cell: weight * value(component), weight * size.
  template <class Value>
  void add(double weight, double size, Value value) {
    for (std::size_t c = 0; c < components.size(); ++c) components[c].add(weight * value(c));
    length.add(weight * size);
  }
  void add(const Integral& other);
};

// The volume that has each value of a field of regions; what is not finite is left out.
using RegionVolumes = std::map<double, CompensatedSum>;
// What says regions has few values. Of a field with more only some of them are added up, and nobody
// wants to know.
inline std::size_t most_regions(const Field& field) { return field.integer ? 1 << 16 : 1 << 12; }
inline bool has_too_many(const Field& field, const RegionVolumes& volumes) {
  return volumes.size() > most_regions(field);
}

struct FieldValues {
  std::vector<Range> ranges;  // of the components
  double largest = 0;         // absolute value of a component

  void add(const double* row);  // all finite
  void add(const FieldValues& other);
  double diagonal() const;
};

// At the original's points, each with weight 1.
struct PointMeasures {
  PointMeasures() = default;
  explicit PointMeasures(const FieldSet& fields);
  void add(const PointMeasures& other);

  std::vector<Errors> errors;       // one a point field
  std::vector<FieldValues> values;  // the original's
  std::uint64_t outside = 0;
  double farthest = 0;  // of those outside
  PointBox box;         // of all points
};

// At the centres of the original's tetrahedra, weighted by volume.
struct CellMeasures {
  CellMeasures() = default;
  CellMeasures(const FieldSet& point_fields, const FieldSet& cell_fields);
  void add(const CellMeasures& other);

  CompensatedSum volume;
  CompensatedSum volume_error;  // what rounding may have done to it at most
  std::uint64_t outside = 0;
  std::vector<Errors> errors;  // one a point field; integer fields have none
  std::vector<Integral> integrals;
  // Squares of the lengths, times volume: that of the cell there, or of the simplified mesh's cell
  // if it is smaller, so that a sliver does not count for more than it is.
  std::vector<double> gradient_squares, gradient_errors;
  // One a cell field:
  std::vector<Errors> cell_errors;
  std::vector<FieldValues> cell_values;
  std::vector<Integral> cell_integrals;
  std::vector<CompensatedSum> cell_differences;  // lengths of the differences, times volume
  std::vector<RegionVolumes> cell_regions;       // empty for fields that are no regions
  std::vector<std::size_t> region_limits;        // values of each that are added up
};

struct Meshes {
  const OriginalMesh& original;
  const SimplifiedMesh& simplified;
  const Locator& locator;
  const FieldSet& point_fields;
  const FieldSet& cell_fields;
};

inline bool all_finite(const double* row, std::size_t components) {
  for (std::size_t c = 0; c < components; ++c) {
    if (!std::isfinite(row[c])) return false;
  }
  return true;
}

// The rows of the point fields at the corners of a tetrahedron.
using CornerRows = std::array<const double*, 4>;
inline CornerRows corner_rows(const Vector<double>& rows, std::size_t width, const Tet& tet) {
  CornerRows corners;
  for (std::size_t i = 0; i < 4; ++i) corners[i] = rows.data() + tet[i] * width;
  return corners;
}
// The sum of the lengths of a field's values there; NaN if one of them is not finite.
inline double lengths_at(const CornerRows& rows, const Field& field) {
  return (rows[0][field.length] + rows[1][field.length]) +
         (rows[2][field.length] + rows[3][field.length]);
}
// What is at that place in the rows, between the corners. A corner without weight has no influence,
// nor has one without a number that has no more weight than rounding gives it.
inline double interpolate(const CornerRows& rows, const std::array<double, 4>& weights,
                          std::size_t place) {
  constexpr double kRounding = 1e-6;
  const auto sum_above = [&](double least) {
    double value = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      if (weights[i] > least) value += weights[i] * rows[i][place];
    }
    return value;
  };
  const double value = sum_above(0);
  return std::isfinite(value) ? value : sum_above(kRounding);
}
VertexId nearest_corner(const SimplifiedMesh& mesh, const Place& place);

// The square of the Euclidean distance between a row of a field and value(component).
template <class Value>
double squared_difference(const Field& field, const double* row, Value value) {
  double sum = 0;
  for (std::size_t c = 0; c < field.info.components; ++c) {
    const double d = value(c) - row[c];
    sum += d * d;
  }
  return sum;
}

// So many places are taken together.
inline constexpr std::size_t kPlaces = std::size_t{1} << 14;
// An order in which one place is near the last one, all of them in the box; at(i) is called from
// several threads.
template <class At>
Vector<std::uint32_t> curve_order(std::size_t places, const PointBox& box, At at) {
  constexpr int kBits = 8;  // enough for a window
  const HilbertCurve curve(box, kBits);
  Vector<std::uint32_t> keys(places);
  for_each_block(places, kPlaces, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) keys[i] = curve.key(at(i));
  });
  return sorted_by_key(keys, curve.key_bits());
}
Vector<std::uint32_t> curve_order(std::span<const Point> points);

// Deterministic for any number of threads. `report` is called with a share from 0 to 1; it may
// throw.
PointMeasures measure_points(const Meshes& meshes, const std::function<void(double)>& report);
CellMeasures measure_cells(const Meshes& meshes, const std::function<void(double)>& report);

// Over the simplified mesh, one for each field.
std::vector<Integral> integrate_points(const SimplifiedMesh& mesh, const FieldSet& fields);
std::vector<Integral> integrate_cells(const SimplifiedMesh& mesh, const FieldSet& fields);
RegionVolumes measure_regions(const SimplifiedMesh& mesh, const FieldSet& fields,
                              const Field& field);

}  // namespace tetfusion
