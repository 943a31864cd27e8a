// What a run must remember, besides the pieces of its macroLoD, to go on where it was killed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "driver/import/import.h"
#include "driver/request/report.h"
#include "driver/rounds/round_plan.h"

namespace tetfusion {

// Raised whenever a state of before would be read as something else, or be gone on with to another
// result: a run goes on with its own kind only.
inline constexpr int kStateFormat = 8;

template <class Real>
struct RunState : RoundsState {
  MacroLod<Real> mesh;  // as it is now; its pieces apart
  ImportedInput<Real> input;
  std::vector<SteeringField> fields;
  std::vector<std::string> field_names;
  std::uint32_t steering_width = 0;
  std::vector<MeshSummary> outputs;              // what is written already: one a stage
  std::vector<std::uint32_t> log_slices;         // of the rounds whose fusions are kept
  KeptValues kept_values;                        // OriginalValues::keep()
  std::unique_ptr<OriginalValues<Real>> values;  // apart, too; null: nobody wants to know
};

// The mesh must be in pieces.
template <class Real>
Vector<std::byte> save(const RunState<Real>& state);

// Throws Error(kIo) for bytes that are not such a state.
template <class Real>
void load(std::span<const std::byte> bytes, RunState<Real>* state);

}  // namespace tetfusion
