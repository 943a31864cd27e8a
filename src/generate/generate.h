// Test meshes of any size, written in constant memory: every point and every tetrahedron is
// computed from its number when its turn in the file comes.
#pragma once

#include <cstdint>
#include <string>

#include "generate/lattice.h"
#include "io/write_mesh.h"

namespace tetfusion {

// The largest mesh that can be asked for, for which every number still fits everywhere.
inline constexpr std::uint64_t kMaxGeneratedTets = std::uint64_t{1} << 40;

struct GenerateOptions {
  LatticeKind kind = LatticeKind::kFive;
  std::uint64_t tets = 1'000'000;  // about; see choose_cubes()
  double jitter = 0;               // [0, 1), see LatticeOptions
  double grading = 1;              // >= 1, see LatticeOptions
  bool shuffle = false;            // points and tetrahedra in pseudo-random order
  std::uint64_t seed = 0;          // of jitter and order
  double time = 0;                 // where the field `front` stands, and the file's TimeValue
  bool double_precision = false;   // Float64 points instead of Float32
};

struct GeneratedSize {
  std::uint64_t points;
  std::uint64_t tets;
};

// Writes the mesh to `path`, a .vtu or "-". The box is [0, 1]^3. Point arrays: `temperature`,
// `front` (0 behind to 1 ahead of a sphere round the origin of radius 0.2 + 0.1 time; Float32),
// `velocity` (three components); cell array: `region` (Int32, 1 to 4 from bottom to top). The same
// options give the same bytes for any number of threads. Throws Error(kUsage) for options out of
// range, or points that Float32 cannot tell apart well enough; Error(kIo).
GeneratedSize generate_mesh(const GenerateOptions& options, const std::string& path,
                            const WriteOptions& write = {});

}  // namespace tetfusion
