#include "driver/import.h"

#include <algorithm>
#include <utility>

#include "driver/assemble.h"
#include "driver/rounds.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

std::vector<Column> columns_like(const AttributeSet& set) {
  std::vector<Column> columns;
  for (const ArrayInfo& info : set.arrays) columns.push_back({info.type, info.components, {}});
  return columns;
}

// The chunks, and with them the first round where it can be done. Chunks that were worked on, in
// vain as it turns out, are not there any more: `scatter_again` makes `from` anew.
template <class Real, class Scatter>
Assembly<Real> assemble(const WorkMesh<Real>& layout, const ImportSettings& settings,
                        const FirstRound<Real>& first_round, const RunContext& context,
                        std::uint64_t cells, MemoryBudget* budget, Scratch* scratch,
                        const Scatter& scatter_again, ScatteredMesh<Real>* from,
                        bool* first_round_done) {
  const auto chunks_to = [&](const ChunkWork<Real>& work) {
    return assemble_chunks<Real>(layout, from->box, from->chunks, settings.regions,
                                 settings.keeps_numbers ? cells : 0, *from->tets, *from->points,
                                 work, context, budget, scratch);
  };
  if (from->all_chunks > 1 && first_round.begin) {
    std::vector<std::uint64_t> shares{0};
    for (std::uint32_t c = 0; c < from->all_chunks; ++c) {
      shares.push_back(shares.back() + from->tets->bytes(c));
    }
    if (from->has_excerpt) {
      const std::uint32_t chunk = from->all_chunks;
      const auto memory =
          budget->wait_for(chunk_memory(from->tets->bytes(chunk) + from->points->bytes(chunk)),
                           "an excerpt of the mesh");
      WorkMesh<Real> excerpt =
          assemble_excerpt(layout, from->box, chunk, settings.regions, *from->tets, *from->points);
      first_round.look(from->box, from->tet_count, &excerpt);
    }
    first_round.begin(from->box, from->tet_count, std::move(shares), from->samples);
    Assembly<Real> assembly = chunks_to(first_round.work);
    *first_round_done = assembly.mesh.locks.empty();
    if (*first_round_done) return assembly;
    *from = {};  // the names of its stores are free again
    *from = scatter_again();
  }
  return chunks_to({});
}

}  // namespace

template <class Real>
WorkMesh<Real> layout_of(const CarriedArrays& carried, std::uint32_t steering_width) {
  WorkMesh<Real> layout;
  layout.steering_width = steering_width;
  layout.point_columns = columns_like(carried.point_data);
  layout.cell_columns = columns_like(carried.cell_data);
  return layout;
}

template <class Real>
ImportedMesh<Real> import_mesh(const MeshStream& stream, const CarriedArrays& carried,
                               const Steering& steering, const ImportSettings& settings,
                               const FirstRound<Real>& first_round, const RunContext& context,
                               PhaseClock* clock, MemoryBudget* budget, Scratch* scratch) {
  WorkMesh<Real> layout = layout_of<Real>(carried, steering.width());
  layout.quadric_width = settings.quadric_width;
  layout.has_deviations = settings.has_deviations;
  if (settings.keeps_numbers) layout.cell_columns.push_back(number_column());
  const auto scatter = [&] {
    auto scattered =
        scatter_mesh(stream, carried, steering, settings, layout, context, clock, budget, scratch);
    clock->begin("assemble");
    return scattered;
  };
  ScatteredMesh<Real> from = scatter();
  ImportedMesh<Real> out;
  Assembly<Real> assembly = assemble(layout, settings, first_round, context, stream.cells(), budget,
                                     scratch, scatter, &from, &out.first_round_done);
  out.mesh = std::move(assembly.mesh);
  out.mesh.chunks = from.chunks;
  out.mesh.samples = std::move(from.samples);
  out.box = from.box;
  out.rewound = std::move(assembly.rewound);
  out.steering_box = std::move(from.steering_box);
  out.interesting_points = from.interesting_points;
  InputFacts& facts = out.facts = assembly.facts;
  facts.points += from.lower.loose_ids.size();
  facts.unused_points = stream.points() - facts.points + stream.dropped_points();
  facts.merged_points = stream.merged_points();
  facts.ghost_cells = from.ghost_cells;
  facts.coincident_points = from.coincident_points;
  if (settings.lock_coincident) {
    const auto& types = from.lower.cells.types;
    facts.carried_triangles =
        static_cast<std::uint64_t>(std::count(types.begin(), types.end(), kVtkTriangle));
  }
  out.lower = std::move(from.lower);
  return out;
}

template WorkMesh<float> layout_of(const CarriedArrays&, std::uint32_t);
template WorkMesh<double> layout_of(const CarriedArrays&, std::uint32_t);
template ImportedMesh<float> import_mesh(const MeshStream&, const CarriedArrays&, const Steering&,
                                         const ImportSettings&, const FirstRound<float>&,
                                         const RunContext&, PhaseClock*, MemoryBudget*, Scratch*);
template ImportedMesh<double> import_mesh(const MeshStream&, const CarriedArrays&, const Steering&,
                                          const ImportSettings&, const FirstRound<double>&,
                                          const RunContext&, PhaseClock*, MemoryBudget*, Scratch*);

}  // namespace tetfusion
