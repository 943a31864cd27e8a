#include "driver/examine/examine.h"

#include <fmt/format.h>

#include <exception>
#include <filesystem>
#include <memory>

#include "base/error.h"
#include "base/numbers.h"
#include "base/resources.h"
#include "driver/examine/chunked_examination.h"
#include "driver/rounds/memory_plan.h"
#include "io/files/file_system.h"
#include "io/source/mesh_stream.h"
#include "io/store/scratch.h"
#include "mesh/inspection/inspect.h"

namespace tetfusion {

namespace {

// inspect() and the mesh itself, a cell and a point; 32 to 47 a cell measured, and up to 60 where
// all of them are odd.
constexpr std::uint64_t kCellBytes = 60;
constexpr std::uint64_t kPointBytes = 60;

Examination examine_whole(MeshSource* source, const RunContext& context) {
  context.report("reading", 0);
  Geometry geometry = source->read_geometry();
  context.report_size(geometry.tets.size());
  context.check();
  context.report("inspecting", 0.4);
  Examination out;
  const Inspection inspection = inspect(geometry);
  out.mesh = summarize(geometry, inspection);
  context.check();
  context.report("measuring", 0.8);
  out.quality = measure_quality(geometry);
  context.check();
  return out;
}

// Nothing that could be resumed: the folder goes with whatever happens; what a killed process has
// left goes with the next.
class TemporaryScratch {
 public:
  TemporaryScratch(const std::string& parent, std::uint64_t expected_bytes) {
    constexpr const char* kFingerprint = "examine";
    const std::filesystem::path folder = parent.empty() ? temporary_folder() : parent;
    remove_dead_scratch(folder.string(), kFingerprint);
    scratch_ =
        disk_scratch({(folder / temporary_name()).string(), kFingerprint, false, expected_bytes});
  }
  ~TemporaryScratch() {
    try {
      scratch_->remove();
    } catch (const std::exception&) {
      // What was found out is worth more than a folder that stays.
    }
  }
  TemporaryScratch(const TemporaryScratch&) = delete;
  TemporaryScratch& operator=(const TemporaryScratch&) = delete;
  Scratch* get() { return scratch_.get(); }

 private:
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace

Examination examine(MeshSource* source, const ExamineOptions& options, const RunContext& context) {
  const std::uint64_t total = memory_to_use(options.memory);
  const MeshDescription& mesh = source->description();
  const std::unique_ptr<MeshStream> stream = source->stream();
  const std::uint64_t whole = kProcessBytes + kCellBytes * mesh.cells + kPointBytes * mesh.points;
  if (!options.in_chunks && (whole <= total || stream == nullptr)) {
    if (stream == nullptr && options.memory != 0 && whole > total) {
      throw Error(
          ErrorCode::kMemory,
          fmt::format("{}: a file of this format is read whole, and looking at it then "
                      "takes about {} of memory, but it may use {}: give --memory {}M or "
                      "more, or convert it to .vtu first",
                      mesh.path, format_bytes(whole), format_bytes(total), (whole >> 20) + 1));
    }
    return examine_whole(source, context);
  }
  const std::unique_ptr<MeshStream> other = stream == nullptr ? open_stream(source) : nullptr;
  const MeshStream& cells = stream == nullptr ? *other : *stream;
  const MemoryNeeds needs = fit_threads(
      total,
      [&](int threads) { return needs_of_examination(mesh, cells, options.chunk_tets, threads); },
      context);
  if (needs.out_of_core > total) {
    throw Error(ErrorCode::kMemory,
                fmt::format("{}: looking at this mesh needs about {} of memory with its chunks on "
                            "disk, but it may use {}: give --memory {}M or more",
                            mesh.path, format_bytes(needs.out_of_core), format_bytes(total),
                            (needs.out_of_core >> 20) + 1));
  }
  MemoryBudget budget(total);
  if (!options.on_disk && needs.in_core <= total) {
    const auto scratch = memory_scratch();
    return examine_chunks(mesh, cells, options.chunk_tets, context, &budget, scratch.get());
  }
  TemporaryScratch scratch(options.scratch, needs.scratch);
  return examine_chunks(mesh, cells, options.chunk_tets, context, &budget, scratch.get());
}

}  // namespace tetfusion
