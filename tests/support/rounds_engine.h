// Rounds over a mesh, without files.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "driver/rounds/rounds.h"
#include "support/cut_meshes.h"

namespace tetfusion::testing {

// What an import would have made of a mesh.
MacroLod<double> macro_lod(const WorkMesh<double>& mesh, std::uint64_t chunk_tets,
                           Scratch* scratch);

// The whole of it.
WorkMesh<double> joined(const MacroLod<double>& lod, const WorkMesh<double>& layout);

class RoundsEngine {
 public:
  RoundsEngine(const WorkMesh<double>& mesh, std::uint64_t chunk_tets, int threads = 2,
               std::unique_ptr<Scratch> own_scratch = memory_scratch(),
               std::uint64_t memory = std::uint64_t{1} << 30);

  // The next round, for the settings below.
  RoundStatistics run(const RunContext& context = {});
  void run(int rounds) {
    for (int i = 0; i < rounds; ++i) run();
  }
  WorkMesh<double> mesh() const { return joined(lod, layout_); }
  WorkMesh<double> chunk(std::uint32_t c) const;

  // Takes from the mesh what it remembers of refused flips.
  void forget_flips();

  RoundSettings settings;
  std::span<const SteeringField> fields;

 private:
  MemoryBudget budget_;
  std::unique_ptr<Scratch> scratch_;
  WorkMesh<double> layout_;

 public:
  MacroLod<double> lod;

 private:
  Rounds<double> rounds_;
};

}  // namespace tetfusion::testing
