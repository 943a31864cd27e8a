// What a run must remember, besides the pieces of its macroLoD, to go on where it was killed.
#pragma once

#include <span>
#include <vector>

#include "base/serialize.h"
#include "driver/import.h"
#include "driver/report.h"
#include "driver/thresholds.h"

namespace tetfusion {

// How the stage in hand has ended.
enum class StageEnd : std::uint8_t {
  kOpen,       // not yet
  kGoal,       // as near to its goal as can be
  kSaturated,  // nothing fuses any more
};

template <class Real>
struct RunState {
  ImportedMesh<Real> input;  // `mesh` is the current macroLoD, its pieces apart
  std::vector<SteeringField> fields;
  std::vector<std::string> field_names;
  std::uint32_t steering_width = 0;
  std::vector<LodSummary> lods;      // of the rounds so far
  std::vector<std::string> outputs;  // files that are written already: one a stage
  std::uint64_t chunk_tets = 0;      // of the next round
  double shrink = 1;                 // what the last round has left of the mesh
  std::uint8_t spread = 1;
  CostHistogram costs{};  // with Method::kFuse
  Threshold threshold;    // of the last round
  StageEnd end = StageEnd::kOpen;
};

// The mesh must be in pieces.
template <class Real>
Vector<std::byte> save(const RunState<Real>& state);

// Throws Error(kIo) for bytes that are not such a state.
template <class Real>
void load(std::span<const std::byte> bytes, RunState<Real>* state);

}  // namespace tetfusion
