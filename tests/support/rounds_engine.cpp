#include "support/rounds_engine.h"

#include <algorithm>
#include <utility>

#include "support/interface_tables.h"

namespace tetfusion::testing {

MacroLod<double> macro_lod(const WorkMesh<double>& mesh, std::uint64_t chunk_tets,
                           Scratch* scratch) {
  MacroLod<double> lod;
  lod.tets = mesh.tets.size();
  lod.chunks = static_cast<std::uint32_t>((lod.tets + chunk_tets - 1) / chunk_tets);
  if (lod.chunks == 1) {
    lod.whole = mesh;
    return lod;
  }
  CutMesh cut = cut_up(mesh, lod.chunks, 0, scratch, "import");
  lod.pieces = std::move(cut.pieces);
  lod.interface = std::move(cut.interface);
  for (const Tet& t : mesh.tets) lod.samples.push_back(mesh.positions[t[0]]);
  return lod;
}

WorkMesh<double> joined(const MacroLod<double>& lod, const WorkMesh<double>& layout) {
  if (lod.whole) return *lod.whole;
  std::vector<WorkMesh<double>> chunks(lod.chunks, layout);
  ChunkGather<double> gather;
  for (std::uint32_t c = 0; c < lod.chunks; ++c) {
    Rounds<double>::gather(lod, c, &gather, &chunks[c]);
  }
  return join(chunks);
}

RoundsEngine::RoundsEngine(const WorkMesh<double>& mesh, std::uint64_t chunk_tets, int threads,
                           std::unique_ptr<Scratch> own_scratch, std::uint64_t memory)
    : budget_(memory),
      scratch_(std::move(own_scratch)),
      layout_(testing::layout_of(mesh)),
      lod(macro_lod(mesh, chunk_tets, scratch_.get())),
      rounds_(layout_, threads, &budget_, scratch_.get()) {
  settings.box = box_of(mesh);
  settings.chunk_tets = chunk_tets;
  settings.limits.paper.stretch_factor = 5;
}

RoundStatistics RoundsEngine::run(const RunContext& context) {
  const auto before = static_cast<double>(lod.tets);
  const RoundStatistics round = rounds_.run(settings, fields, context, &lod);
  ++settings.number;
  settings.shrink = static_cast<double>(lod.tets) / before;
  return round;
}

WorkMesh<double> RoundsEngine::chunk(std::uint32_t c) const {
  WorkMesh<double> mesh = layout_;
  ChunkGather<double> gather;
  Rounds<double>::gather(lod, c, &gather, &mesh);
  return mesh;
}

void RoundsEngine::forget_flips() {
  if (lod.whole) {
    std::ranges::fill(lod.whole->remembered, std::uint16_t{0});
    return;
  }
  auto pieces = scratch_->begin("forgotten-" + std::to_string(settings.number));
  ChunkScatter<double> scatter;
  Vector<InterfaceReport> reports;
  for (std::uint32_t c = 0; c < lod.chunks; ++c) {
    WorkMesh<double> mesh = chunk(c);
    std::ranges::fill(mesh.remembered, std::uint16_t{0});
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
      if ((mesh.marks[v] & kOnInterface) == 0) continue;
      reports.push_back({mesh.point_ids[v], c, c, 0, false});
    }
    scatter.keep(mesh, c, pieces.get());
  }
  pieces->seal();
  lod.pieces = std::move(pieces);
  lod.interface = table_of(std::move(reports));
}

}  // namespace tetfusion::testing
