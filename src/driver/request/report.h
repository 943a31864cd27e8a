// What a simplification did, for people and as JSON.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "driver/request/input_facts.h"
#include "driver/request/options.h"
#include "kernel/fuse/fuse_limits.h"
#include "verify/verify.h"

namespace tetfusion {

struct MeshSummary {
  std::string path;
  std::uint64_t points = 0;
  std::uint64_t tets = 0;
  std::uint64_t boundary_triangles = 0;
  double volume = 0;

  friend bool operator==(const MeshSummary&, const MeshSummary&) = default;
};

struct RoundSummary {
  PassStatistics pass;
  double scalar_tolerance = 0;
  double stretch_factor = 0;
  std::uint64_t chunks = 1;
  double seconds = 0;
  double deviation = 0;  // how far surfaces may have moved so far: a bound, share of the diagonal
};

enum class StopReason : std::uint8_t {
  kGoal,       // the goal was reached, within one fusion
  kSaturated,  // no fusion is allowed any more
};

struct SimplifyReport {
  Method method = Method::kFuse;
  MeshSummary input;
  MeshSummary output;
  std::vector<MeshSummary> outputs;  // all that were written, `output` the last of them
  std::vector<std::string> steering;
  std::vector<std::string> regions;
  InputFacts facts;             // what is odd about the input, and was left alone or out
  std::string differing_array;  // has the facts' largest difference; empty: none that is known
  bool has_interest = false;    // the user has named a region of interest
  StopReason stop_reason = StopReason::kSaturated;
  bool has_goal = false;
  Boundary boundary = Boundary::kExact;
  double boundary_distance = 0;  // of kWithin
  double feature_angle = kFeatureAngle;
  std::vector<RoundSummary> rounds;
  std::vector<Verification> verified;     // of the outputs that were verified
  std::map<std::string, double> seconds;  // by phase
  double total_seconds = 0;
  double cpu_seconds = 0;
  std::uint64_t peak_rss_bytes = 0;
  std::uint64_t scratch_bytes = 0;  // of the disk, at most at once; 0: the mesh was in memory
  int threads = 1;

  double reduction() const;  // share of the tetrahedra that went
  // Which limit ended the run, in plain words.
  std::string stop_sentence() const;

 private:
  std::string reason_of_locks() const;  // as far as it is known
  // A larger feature angle may help with it.
  bool is_for_sharp_edges(Reject reason) const;
  std::string in_words(Reject reason) const;
  // What was in the way, of a round of fuse, and of a pass of tetfuse.
  std::string reasons_of_vertices(const PassStatistics& last) const;
  std::string reasons_of_tets(const PassStatistics& last) const;
};

std::string to_json(const SimplifyReport& report);

}  // namespace tetfusion
