// A case of the corpus, from its number: a mesh, and what is asked for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "mesh.h"

namespace corpus {

enum class Surface { kExact, kPlanar, kWithin };

struct Options {
  bool fuse = true;
  bool boundary_tets = false;  // with tetfuse: those stay, too
  std::optional<std::uint64_t> tets;
  std::optional<double> max_error, max_rms;
  std::optional<double> scalar_tolerance, stretch_factor, aspect_ratio;
  double min_quality = 0.22;
  Surface surface = Surface::kExact;
  double distance = 0;  // kWithin: share of the diagonal
  std::optional<double> feature_angle;
  bool conserve = false;
  bool regions = true;  // false: none
  std::uint64_t chunk_tets = 200'000;
  int threads = 1;
  bool on_disk = false;
  bool verify = false;
  bool twice = false;  // again, with other threads and another place for the chunks

  std::string command() const;  // as it would be typed
};

struct Case {
  std::size_t kind = 0;  // of kinds()
  std::string place;
  Mesh mesh;
  Options options;
};

// The region array of every mesh that has regions, and the arrays that number its cells and points.
inline constexpr const char* kRegions = "Material";
inline constexpr const char* kCellNumber = "cell";
inline constexpr const char* kPointNumber = "point";
// A linear field: slope . x + offset.
inline constexpr const char* kLinear = "linear";
inline constexpr Point kSlope{0.75, -1.25, 0.5};
inline constexpr double kOffset = 2;

Case make_case(std::uint64_t number);

}  // namespace corpus
