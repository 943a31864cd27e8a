// What a run would reach, and how long it would take: estimated by running it on a part of the
// mesh.
#pragma once

#include <cstdint>
#include <optional>

namespace tetfusion {

struct Run;
class Steering;

// Tetrahedra of the part that is tried out.
inline constexpr std::uint64_t kSampleTets = 200'000;

// Where the boundary may move, so many times as many tetrahedra as told may be left, as what ends
// it in the middle may end it sooner elsewhere. Or far fewer: cells may become so large that none
// is out of the cut's reach (remainder.h).
inline constexpr double kRoughFactor = 4;

struct RunEstimate {
  std::uint64_t tets = 0;         // of the mesh
  std::uint64_t sample_tets = 0;  // that were simplified; all of them where the mesh is small
  double sample_seconds = 0;      // that took
  double boundary_share = 0;      // of the points
  double reduction = 0;        // what can be reached with the limits that were given, but no goal
  std::optional<double> goal;  // the share that is to go
  double seconds = 0;          // of the run, to its goal where that can be reached
  bool is_rough = false;       // the boundary moves, in a part that is not the whole

  bool is_whole() const { return sample_tets == tets; }
  // The reduction, or, where it is rough, that with kRoughFactor times as many left.
  double low_reduction() const;
  // None where there is no goal, or where that cannot be told.
  std::optional<bool> reaches_goal() const;
};

// Reads the input once, as an import does, keeps one chunk of about sample_tets tetrahedra, from
// the middle of the mesh, and runs the rounds of the method over it, to the goal and then until
// nothing fuses. What lies between it and other chunks stays, as in a first round; in a run it
// would be another's turn in the next. So what counts is how many of the sample's free vertices go,
// and how many vertices the mesh has inside, by a sample of its own
// (mesh/inspection/boundary_sample.h). Where the boundary may move so little can be left that the
// cut has most of it; there counts what the sample has become away from the cut (remainder.h). Time
// is what reading took, from `start` (wall_seconds()) on, and what the sample took for as many
// tetrahedra as there are; not the waiting for disks. The ranges of *steering become those of the
// points that tetrahedra use.
RunEstimate estimate_run(const Run& run, Steering* steering, std::uint64_t sample_tets,
                         double start);

}  // namespace tetfusion
