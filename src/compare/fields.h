// Which arrays two meshes have in common, and their values as rows of numbers.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "base/vector.h"
#include "io/source/mesh_source.h"
#include "mesh/data_array.h"

namespace tetfusion {

// All integers of 64 bits, and their differences.
__extension__ using WideInteger = __int128;

// An array that both meshes have, with the same number of components.
struct Field {
  ArrayInfo info;                    // the original's
  std::size_t original, simplified;  // its index in their attributes
  bool integer;                      // in both
  bool region;                       // an array of cells that is named like a material
  std::size_t offset;                // of its first component in a row
  std::size_t length = 0;            // where a row of a point has the Euclidean length of the value
  // Of integers of 64 bits, which doubles may not hold: values are counted from here.
  WideInteger base = 0;
  // Of floating-point values, which are multiplied by 2^exponent: see exponent_for().
  int exponent = 0;
  double factor() const { return std::ldexp(1.0, exponent); }
};

// The exponent for values of which that is the largest, in absolute value: 0, unless their squares
// could be too large or too small for a double. Nothing is rounded but what is next to nothing
// beside the largest.
int exponent_for(double largest);

// All arrays of points, or of cells. A row has the components of one point or cell, as doubles:
// integers more than 2^53 from their field's base are rounded. Those of points have the fields'
// lengths behind them.
struct FieldSet {
  std::vector<Field> fields;
  std::size_t components = 0;
  std::size_t width = 0;  // of a row
};

struct RetypedArray {
  std::string name;                  // as in ArrayMatch::missing
  std::string original, simplified;  // "Float32", or with several components "Float32 x 3"
};

struct ArrayMatch {
  FieldSet points, cells;
  // Of the original; cell arrays as "cell:NAME", field arrays as "field:NAME".
  std::vector<std::string> missing;
  std::vector<RetypedArray> retyped;  // other type or number of components
  // Floating-point arrays of points that are missing, or have another number of components.
  std::vector<std::string> lost_fields, lost_regions;
};

ArrayMatch match_arrays(const MeshDescription& original, const MeshDescription& simplified);

// Where values go: row i of `out` gets tuple row_of[i] of the array, or i where row_of is empty; of
// integers their difference from `base`. All is multiplied by `factor`.
struct RowTarget {
  std::size_t width;
  std::size_t offset;
  std::size_t rows;
  std::span<const std::uint64_t> row_of;
  double* out;
  WideInteger base = 0;
  double factor = 1;
};
void spread_values(const ArrayInfo& info, std::span<const std::byte> tuples,
                   const RowTarget& target);

// The length of a field's values in a row; NaN if one of them is not finite.
inline double length_of(const Field& field, const double* values) {
  double squared = 0;
  for (std::size_t c = 0; c < field.info.components; ++c) {
    if (!std::isfinite(values[c])) return std::numeric_limits<double>::quiet_NaN();
    squared += values[c] * values[c];
  }
  return field.info.components == 1 ? std::abs(*values) : std::sqrt(squared);
}
// Puts it where the rows of points have it.
void fill_lengths(const FieldSet& fields, std::size_t rows, double* out);

// What rounding may have done to a value written in that type: four units in the last place, as a
// share of the array's largest one. 0 of integers.
double rounding_of(ValueType type);

}  // namespace tetfusion
