// What a simplification did to a mesh.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "compare/fields.h"
#include "compare/point.h"
#include "compare/topology.h"
#include "io/source/mesh_source.h"
#include "mesh/geometry.h"

namespace tetfusion {

struct RegionVolume {
  double value = 0;                     // of the array
  double original = 0, simplified = 0;  // volumes
};

// As shares of the diagonal.
struct SurfaceShares {
  double max = 0, mean = 0;
  Point max_at{};
};

// Of the surfaces between the regions that an array says.
struct InterfaceShares {
  bool identical = false;
  SurfaceShares to_simplified, to_original;

  double max() const { return std::max(to_simplified.max, to_original.max); }
};

// One array that both meshes have. Shares are of the range of the original's values: the diagonal
// of the box of the components, or where that is 0 the largest absolute value; infinite if that is
// 0, too, and there is an error.
struct ArrayComparison {
  ArrayInfo info;  // the original's
  Association association = Association::kPoint;
  bool integer = false;
  double range = 0;
  std::vector<double> component_ranges;
  std::uint64_t non_finite = 0;  // points or cells that were left out
  std::uint64_t undefined = 0;   // those where the simplified mesh alone has no finite value
  Point undefined_at{};          // the first of these
  // Of the simplified mesh: its points or tetrahedra with a value that is not finite.
  std::uint64_t simplified_non_finite = 0;

  // Point arrays: at the original's points. Cell arrays: at the centres of its cells, the rms over
  // the volume.
  double rms = 0, max = 0;
  Point max_at{};
  double differing = 0;  // share of these points, or of the volume, where the values differ
  // Of cell arrays named like materials, by value; none of floating-point numbers with more than
  // 4096 values.
  std::vector<RegionVolume> regions;
  // Where there are several of these, after add_interfaces() (interfaces.h).
  std::optional<InterfaceShares> interfaces;
  double rounding = 0;  // how much of an error may come from writing values in the array's type

  // The rest is for floating-point arrays.
  double integral_change = 0;    // as share of the integral of the absolute value; of vectors the
                                 // length of the change
  double integral_rounding = 0;  // how much of that rounding of the cells' volumes may be
  // Point arrays: at the centres of the original's cells, over the volume.
  double cell_rms = 0, cell_max = 0;
  double gradient_rms = 0;  // as share of the rms of the gradient
  // Cell arrays:
  double l1_change = 0;  // of the integral of the absolute value
  double l1_error = 0;   // integral of the absolute difference; as share of that
};

struct MeshSize {
  std::uint64_t points = 0;  // that a tetrahedron uses
  std::uint64_t tets = 0;
  std::uint64_t boundary_triangles = 0;
  double volume = 0;
  SurfaceTopology boundary;
};

// Points that reading joined with others, as in Geometry.
struct JoinedCopies {
  std::uint64_t points = 0;
  std::uint64_t differing = 0;
  LargestDifference largest;
};

struct Comparison {
  MeshSize original, simplified;
  double diagonal = 0;               // of the original's box
  double rounding = 0;               // of coordinates, as share of the diagonal; see locator.h
  double volume_change = 0;          // as share of the original's volume
  double volume_error = 0;           // of both volumes together, by rounding, at most
  double volume_between = 0;         // the surfaces, at most: their areas times their distances
  std::uint64_t outside_points = 0;  // points of the original outside the simplified mesh
  double outside_max = 0;            // how far they are at most, as share of the diagonal
  std::uint64_t outside_cells = 0;   // cells of the original whose centre is outside
  bool identical_surface = false;
  Point surface_differs_at{};  // if it is not identical: a triangle that only one of them has
  SurfaceShares to_simplified, to_original;  // from the original's boundary, and from the other
  std::vector<ArrayComparison> arrays;       // points, then cells, in the order of the file
  std::vector<std::string> missing_arrays;
  std::vector<RetypedArray> retyped_arrays;
  JoinedCopies joined;  // of the original: the values that were taken are those that are compared
  // Floating-point arrays of points that are missing, or have another number of components.
  std::vector<std::string> lost_fields;
  // Such cell arrays that are named like materials; after add_interfaces() those of them that say
  // several regions of the original.
  std::vector<std::string> lost_regions;
};

// Reads the original in windows; the simplified mesh, and the boundary of the original, lie in
// memory. The sources must be two. Deterministic for any number of threads. Throws what reading
// throws, and Error(kBadInput) for a mesh without boundary.
//
// `sides` is the memory, in bytes, for sides of triangles while the original's boundary is looked
// for; with less its cells are read more often, and the results are the same. No less than
// kLeastSideBytes is taken; 0: as much as for four sides a tetrahedron of the simplified mesh.
Comparison compare_meshes(MeshSource* original, MeshSource* simplified, const RunContext& context,
                          std::uint64_t sides = 0);

struct Bounds {
  std::optional<double> max_rms, max_error, surface;  // shares
  // Arrays for max_rms and max_error, of cells as "cell:NAME"; empty: all floating-point ones of
  // points.
  std::vector<std::string> arrays;
  std::optional<double> interfaces = {};  // of each array that has some
};

struct BoundResult {
  std::string bound;  // "max_rms", "max_error", "surface", "interfaces"
  std::string array;  // empty for the boundary
  double limit = 0, value = 0;
  bool broken = false;
  std::string sentence;  // if it is broken
};

// Throws Error(kUsage) for a name of bounds.arrays that is no numeric array of the original; and
// where none is named, nothing but cell arrays could be held against the bounds, and there are
// such.
void require_arrays(const Bounds& bounds, const MeshDescription& original);

// Leaves those of the arrays that are named; of cells as "cell:NAME".
void keep_arrays(const std::vector<std::string>& names, Comparison* comparison);

// What rounding to the type of the array or the coordinates can do is not held against them. A
// bound is broken, too, where the original's value is finite and the simplified mesh's is not, or
// where no value of the original is finite, but some of the simplified mesh's; and by an array that
// the simplified mesh lacks, or has with another number of components, of interfaces, too.
std::vector<BoundResult> judge_bounds(const Comparison& comparison, const Bounds& bounds);

}  // namespace tetfusion
