#include "support/import.h"

#include <algorithm>

#include "base/resources.h"
#include "driver/arrays/regions.h"
#include "driver/arrays/steering.h"
#include "driver/rounds/rounds.h"
#include "io/open_mesh.h"
#include "support/cut_meshes.h"

namespace tetfusion::testing {

template <class Real>
Import<Real>::Import(const std::string& path, const ImportChoice& choice, const RunContext& context)
    : folder_(path + ".scratch"),
      source(open_mesh(path)),
      scratch(choice.on_disk ? disk_scratch({folder_, "a test", false, 0}) : memory_scratch()),
      carried(source->description()),
      chunk_tets_(choice.chunk_tets) {
  const MeshDescription& description = source->description();
  const auto stream = open_stream(source.get());
  const auto choices = choice.steering.empty()
                           ? choose_what_varies(source.get(), stream.get(), context)
                           : choose_steering(description, choice.steering);
  Steering steering(choices, description, *stream, context);
  fields = steering.fields();
  ImportSettings import_settings;
  import_settings.chunk_tets = choice.chunk_tets;
  if (choice.window > 0) {
    import_settings.cell_window = import_settings.point_window = choice.window;
  }
  for (const std::size_t i : choose_regions(description, choice.regions)) {
    const auto at = std::ranges::find(carried.cell_indices, i);
    import_settings.regions.push_back(static_cast<std::size_t>(at - carried.cell_indices.begin()));
  }
  import_settings.surfaces_move = choice.surfaces_move;
  layout = tetfusion::layout_of<Real>(carried, steering.width());
  layout.has_deviations = choice.surfaces_move;
  rounds_ = std::make_unique<Rounds<Real>>(layout, thread_count(), &budget, scratch.get());
  FirstRound<Real> first;
  first.scattered = [&] { fields = steering.fields(); };
  if (choice.first_round) {
    first.begin = [&](const Box& box, std::uint64_t tets, std::vector<std::uint64_t> of_chunks,
                      const Vector<Vec3<Real>>& samples) {
      box_ = box;
      shares = of_chunks;
      rounds_->begin(settings(), fields, {tets, std::move(of_chunks), samples});
    };
    first.work = [&](std::uint32_t chunk, std::size_t worker, WorkMesh<Real>* mesh) {
      rounds_->work(chunk, worker, mesh);
    };
    first.drop = [&] { rounds_->drop(); };
  }
  import_settings.excerpt = choice.excerpt;
  first.look = [&](const Box&, std::uint64_t, WorkMesh<Real>* mesh) { excerpt = std::move(*mesh); };
  PhaseClock clock;
  imported = import_mesh<Real>({*stream, carried, &steering}, import_settings, first,
                               {context, &clock, &budget, scratch.get()});
  box_ = imported.box;
  if (imported.first_round_done) {
    const InterfaceTable marks = std::move(imported.mesh.interface);
    first_round = rounds_->end(&imported.mesh, marks);
  }
}

template <class Real>
MeshSummary Import<Real>::export_to(const std::string& path, ExportSettings settings) {
  settings.path = path;
  return export_mesh<Real>({.mesh = imported.mesh,
                            .layout = layout,
                            .lower = imported.lower,
                            .carried = carried,
                            .source = source.get(),
                            .settings = settings,
                            .context = {},
                            .budget = &budget,
                            .scratch = scratch.get()});
}

template <class Real>
RoundSettings Import<Real>::settings() const {
  RoundSettings settings;
  settings.box = box_;
  settings.chunk_tets = chunk_tets_;
  settings.passes = 2;
  return settings;
}

template <class Real>
RoundStatistics Import<Real>::run_first_round() {
  return rounds_->run(settings(), fields, {}, &imported.mesh);
}

template <class Real>
std::vector<WorkMesh<Real>> Import<Real>::chunks() const {
  if (imported.mesh.whole) return {*imported.mesh.whole};
  std::vector<WorkMesh<Real>> out(imported.mesh.chunks, layout);
  ChunkGather<Real> gather;
  for (std::uint32_t c = 0; c < imported.mesh.chunks; ++c) {
    Rounds<Real>::gather(imported.mesh, c, &gather, &out[c]);
  }
  return out;
}

template <class Real>
WorkMesh<Real> Import<Real>::joined() const {
  return join(chunks());
}

template class Import<float>;
template class Import<double>;

}  // namespace tetfusion::testing
