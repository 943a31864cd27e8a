// What a run promises of its result: what --verify holds it against.
#pragma once

#include <string>
#include <vector>

#include "base/memory_budget.h"
#include "driver/arrays/steering.h"
#include "driver/request/input_facts.h"
#include "driver/request/options.h"
#include "driver/request/report.h"
#include "mesh/geometry.h"
#include "verify/verify.h"

namespace tetfusion {

// What the options mean for a mesh.
struct RunChoices {
  const MeshDescription& mesh;
  const std::vector<SteeringChoice>& steering;
  const std::vector<std::size_t>& regions;  // of the description's cell data
};

Promise promise_of(const BehaviourOptions& behaviour, const RunChoices& choices,
                   const InputFacts& facts, const LowerCells& lower, const MeshSummary& written);

// Throws Error(kBadInput) for an input that nothing can be compared with.
void require_boundary(const std::string& input, const InputFacts& facts);

struct WrittenOutput {
  std::string name;  // that it will have
  std::string path;  // where it can be read
};

// Throws Error(kBroken), with what is wrong and what to do, if the promise is not kept;
// Error(kMemory) if the budget does not hold what it takes.
Verification verify_output(const WrittenOutput& output, const Promise& promise,
                           MeshSource* original, const RunContext& context, MemoryBudget* budget);

}  // namespace tetfusion
