// What a simplification is asked to do.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "io/mesh_format.h"
#include "kernel/fuse/fuse_limits.h"
#include "kernel/greedy_pass.h"

namespace tetfusion {

inline constexpr double kDefaultMinQuality = 0.22;
inline constexpr double kDefaultScalarTolerance = 0.025;
inline constexpr double kDefaultStretchFactor = 5;
inline constexpr double kDefaultMaxError = 0.01;

// Of a chunk: FuseVertices counts events in 32 bits, a chunk may turn out three times as large as
// it is asked for (more only where cells are smaller than a millionth of the mesh), and LiveBalls
// packs a tetrahedron and its corner into 32 bits.
inline constexpr std::uint64_t kMaxChunkTets = std::uint64_t{1} << 27;

// What may become of the boundary surface, and of surfaces between regions.
enum class Boundary : std::uint8_t {
  kExact,   // every triangle stays
  kPlanar,  // the same surface: flat parts and straight edges get new triangles
  kWithin,  // it may move by a distance
};

// May change the result.
struct BehaviourOptions {
  Method method = Method::kFuse;
  BoundaryRule boundary_rule = BoundaryRule::kVertices;

  // The goal, at most one of the two: the share of the tetrahedra that is to go, in [0, 1), or how
  // many are to be left, at least 1. Without a goal kTetFuse goes on until nothing fuses, kFuse as
  // far as max_error allows.
  std::optional<double> reduction;
  std::optional<std::uint64_t> tets;

  // The paper's criteria, for each fusion: one value a macroLoD, the last one repeated. Infinity is
  // off. Tolerances are shares of the field's range over the whole original mesh, > 0; the stretch
  // factor and aspect ratio are >= 1. Empty: off with kFuse; with kTetFuse kDefaultScalarTolerance
  // and kDefaultStretchFactor, the values that the paper's Table 1 uses most.
  std::vector<double> scalar_tolerance;
  std::vector<double> stretch_factor;
  double aspect_ratio = std::numeric_limits<double>::infinity();
  // Of a tetrahedron, in the unit of the mesh, > 0: none that is larger grows, and none grows
  // beyond.
  double max_volume = std::numeric_limits<double>::infinity();

  // With kFuse: no new tetrahedron has a lower mean ratio, or, where the input has one below it,
  // one that is lower than that by more than a twentieth; in [0, 1). Absent: kDefaultMinQuality.
  std::optional<double> min_quality;
  // With kFuse: what a fusion may do to the steering fields, in the mean of squares, as a share of
  // their range; > 0. Absent: anything.
  std::optional<double> max_rms;
  // With kFuse and a goal: where a fusion would have to do more, in the same terms, the run ends
  // with OutOfReach; > 0. Absent: it goes on.
  std::optional<double> give_up_rms;
  // With kFuse: no steering field deviates by more from the original's at any of the original's
  // points, as a share of its range; > 0. Absent: anything with a goal, another bound, or a
  // tolerance of an array; else kDefaultMaxError.
  std::optional<double> max_error;

  // With kFuse, and a boundary that is not kWithin: the integrals of all floating-point arrays
  // stay.
  bool conserve = false;

  // With kFuse; kWithin: by this share of the diagonal of the bounding box, > 0.
  Boundary boundary = Boundary::kExact;
  double boundary_distance = 0;
  // With a boundary that is not kExact: where two triangles of a surface meet whose normals are so
  // many degrees apart, or more, it has a sharp edge, which stays; in (0, 180], of which the last
  // is none but the tip of a crack. Absent: kFeatureAngle.
  std::optional<double> feature_angle;

  // Steering arrays as the user names them: "NAME", "NAME:0.5%", "cell:NAME". The share
  // stands in the place of scalar_tolerance or max_error. Empty: the active scalars, else the first
  // floating-point point array, of these the first that is not the same everywhere.
  std::vector<std::string> arrays;

  // Cell arrays of numbers of one component whose interfaces stay. Absent: those of integers named
  // like materials. Empty: none.
  std::optional<std::vector<std::string>> regions;

  // Where the mesh stays as it is (mesh/regions/region_of_interest.h).
  std::vector<std::string> interest;

  // In the end values are fitted to the original's, where nothing else is promised
  // (columns_to_fit()).
  bool fit_values = true;

  // With kFuse: a point array, or "cell:NAME", >= 0; errors count so many times as much there.
  // Empty: all count alike.
  std::string weight;

  // Levels to write on the way: reductions in [0, 1), ascending. The output's name then holds
  // "{lod}".
  std::vector<double> lods;

  // Tetrahedra a chunk, at least 1. Small enough for a core's cache, large enough that few vertices
  // lie on interfaces. The result depends on it, so it is never derived from threads or memory.
  std::uint64_t chunk_tets = 200'000;

  // The result has an array of points, kOriginalIds: the input's number of a point that stayed, -1
  // of one that is new.
  bool original_ids = false;

  // As in OpenOptions.
  bool tetrahedralize = false;
  bool linearize = false;
  bool merge_points = false;
  bool drop_patches = false;
  std::vector<std::string> dropped_patches;
  std::optional<std::uint64_t> time_step;
};

// BehaviourOptions::give_up_rms was not enough.
class OutOfReach : public Error {
 public:
  OutOfReach() : Error(ErrorCode::kBroken, "the goal is out of reach of the error") {}
};

inline constexpr const char* kOriginalIds = "OriginalPointIds";

// May not change the result.
struct PerformanceOptions {
  int threads = 0;  // as set_thread_count() takes them; fewer where the memory is too little

  // Bytes that the process may have resident, mapped pages counted. 0: half of what the machine or
  // its control group allows (memory_to_use()), so that the page cache and others have the rest.
  std::uint64_t memory = 0;

  // The folder for what does not fit into memory. Empty: the output's name and ".tetfusion".
  std::string scratch;

  bool on_disk = false;   // keep the mesh in the scratch folder even where it fits into memory
  bool resume = false;    // go on from what an interrupted run left in the scratch folder
  bool keep_work = true;  // what an interrupted run leaves in the scratch folder, to go on from
  // Bytes that whoever has asked for the run will need when it is over: less memory is too little.
  std::uint64_t memory_afterwards = 0;
};

struct SimplifyRequest {
  std::string input;
  std::string output;
  BehaviourOptions behaviour;
  PerformanceOptions performance;
  Encoding encoding = Encoding::kRaw;
  std::uint32_t pieces = 0;  // of an output that is called .pvtu, at most 65536; 0: by its size
  // Each result is checked and compared with the input before it gets its name (verify/verify.h).
  bool verify = false;
  // A file that says where the input's points went (io/progressive/map_file.h), one for each level:
  // its name holds "{lod}" if the output's does. Empty: none.
  std::string map;
  bool map_homes = true;  // MapHome; without, no cell of the result gets means
  // A file from which every level up to the original can be had
  // (io/progressive/progressive_file.h). Empty: none.
  std::string progressive;
  // Another file that the caller will write, as a report: refused where the input consists of it.
  std::string also_written;
  // One of several that are simplified by themselves: where the arrays that steer by default are
  // the same everywhere in this one, the run goes as far as it can, as if they had been named, and
  // does not ask for a goal.
  bool is_step = false;
};

}  // namespace tetfusion
