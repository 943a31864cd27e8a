#include "driver/import/import.h"

#include <algorithm>
#include <utility>

#include "driver/import/assemble.h"
#include "driver/rounds/rounds.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

std::vector<Column> columns_like(const AttributeSet& set) {
  std::vector<Column> columns;
  for (const ArrayInfo& info : set.arrays) columns.push_back({info.type, info.components, {}});
  return columns;
}

// With the first round done with each chunk as it is put together.
template <class Real>
Assembly<Real> assemble_with(const FirstRound<Real>& first_round, const ChunkParts<Real>& parts,
                             const ImportPlace& place) {
  const ScatteredMesh<Real>& from = parts.from;
  std::vector<std::uint64_t> shares{0};
  for (std::uint32_t c = 0; c < from.all_chunks; ++c) {
    shares.push_back(shares.back() + from.chunk_tets[c]);
  }
  if (from.has_excerpt) {
    const auto memory = place.budget->wait_for(chunk_memory(parts.bytes(from.all_chunks)),
                                               "an excerpt of the mesh");
    WorkMesh<Real> excerpt = assemble_excerpt(parts);
    first_round.look(from.box, from.tet_count, &excerpt);
  }
  first_round.begin(from.box, from.tet_count, std::move(shares), from.samples);
  return assemble_chunks(parts, first_round.work, place);
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
ImportedMesh<Real> import_mesh(const ImportInput& input, const ImportSettings& settings,
                               const FirstRound<Real>& first_round, const ImportPlace& place) {
  const MeshStream& stream = input.stream;
  stream.differing_points();  // what that takes is given back before the tables are made
  WorkMesh<Real> layout = layout_of<Real>(input.carried, input.steering->width());
  layout.quadric_width = settings.quadric_width;
  layout.has_deviations = settings.surfaces_move;
  if (settings.keeps_numbers) layout.cell_columns.push_back(number_column());
  const auto scatter = [&] {
    auto scattered = scatter_mesh(input, settings, layout, place);
    if (first_round.scattered) first_round.scattered();
    place.clock->begin("assemble");
    return scattered;
  };
  ScatteredMesh<Real> from = scatter();
  const ChunkParts<Real> parts{layout, from, settings.regions, settings.surfaces_move,
                               settings.keeps_numbers ? stream.cells() : 0};
  ImportedMesh<Real> out;
  Assembly<Real> assembly;
  if (from.all_chunks > 1 && first_round.begin) {
    assembly = assemble_with(first_round, parts, place);
    out.first_round_done = assembly.mesh.locks.empty();
    if (!out.first_round_done) {
      // In vain, and what was worked on is not there any more.
      first_round.drop();
      assembly = {};
      from = {};  // the names of its stores are free again
      from = scatter();
    }
  }
  if (!out.first_round_done) assembly = assemble_chunks(parts, {}, place);
  out.mesh = std::move(assembly.mesh);
  out.mesh.chunks = from.chunks;
  out.mesh.samples = std::move(from.samples);
  out.box = from.box;
  out.rewound = std::move(assembly.rewound);
  out.interesting_points = from.interesting_points;
  InputFacts& facts = out.facts = assembly.facts;
  facts.points += from.lower.loose_ids.size();
  facts.unused_points = stream.points() - facts.points + stream.dropped_points();
  facts.merged_points = stream.merged_points();
  facts.differing_points = stream.differing_points();
  facts.largest_difference = stream.largest_difference();
  facts.ghost_cells = from.ghost_cells;
  facts.valueless_points = from.valueless_points;
  facts.coincident_points = from.coincident_points;
  if (settings.surfaces_move) {
    const auto& types = from.lower.cells.types;
    facts.carried_triangles =
        static_cast<std::uint64_t>(std::count(types.begin(), types.end(), kVtkTriangle));
  }
  out.lower = std::move(from.lower);
  return out;
}

template WorkMesh<float> layout_of(const CarriedArrays&, std::uint32_t);
template WorkMesh<double> layout_of(const CarriedArrays&, std::uint32_t);
template ImportedMesh<float> import_mesh(const ImportInput&, const ImportSettings&,
                                         const FirstRound<float>&, const ImportPlace&);
template ImportedMesh<double> import_mesh(const ImportInput&, const ImportSettings&,
                                          const FirstRound<double>&, const ImportPlace&);

}  // namespace tetfusion
