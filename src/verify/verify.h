// Holds the result of a simplification against what was promised.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "base/vector.h"
#include "compare/needs.h"  // for those who plan a verification
#include "io/source/mesh_source.h"
#include "mesh/regions/region_of_interest.h"

namespace tetfusion {

struct PromisedError {
  std::string array;  // a floating-point point array
  double share = 0;   // of its range
};

// What the result should be.
struct Promise {
  // As was counted while it was written.
  std::uint64_t points = 0, tets = 0;
  std::uint64_t boundary_triangles = 0;  // about, of both meshes: for the memory
  Vector<std::uint8_t> lower_types;      // of the cells of lower dimension, in order

  // What is wrong with the input: there may be no more of it.
  std::uint64_t inverted = 0, duplicate_tets = 0, nonconforming_faces = 0, degenerate = 0,
                nonmanifold_edges = 0;

  // How far the boundary and the interfaces may move, as a share of the diagonal; absent: they
  // consist of the same triangles.
  std::optional<double> distance;
  std::vector<std::string> regions;  // cell arrays whose interfaces these are
  std::vector<PromisedError> errors;
  // No tetrahedron is larger, unless one of the input's is.
  double max_volume = std::numeric_limits<double>::infinity();
  RegionOfInterest interest;  // tetrahedra of its points alone are still there
  bool integrals = false;     // of all floating-point arrays: they stay

  std::vector<std::string> dropped;  // arrays that are not carried along; "cell:NAME" of cells
  std::vector<std::string> beyond;   // what else was promised and cannot be verified, in words
};

struct VerifiedCheck {
  std::string name;  // "inverted", "boundary", "error:NAME", ...
  double found = 0;  // counts, shares, or 1 for a thing that is not as it should be
  double allowed = 0;
  bool kept = true;
  std::string sentence;  // if it is not kept: what is wrong, and where
};

struct Verification {
  std::string path;  // of the output
  std::vector<VerifiedCheck> checks;
  std::vector<std::string> not_verified;

  bool kept() const;
  // "3 inverted cells ..., and ...": what is not kept.
  std::string complaint() const;
};

// `result` is where the result can be read, a path that no sentence would hold otherwise: it is
// called "the result" there; `sides` as for compare_meshes(). Reads the original in windows. Throws
// what reading the original throws, Error(kIo) and Error(kInterrupted); a result that is no mesh is
// a promise that is broken. The original must have a boundary.
Verification verify_result(MeshSource* original, const std::string& result, const Promise& promise,
                           std::uint64_t sides, const RunContext& context);

}  // namespace tetfusion
