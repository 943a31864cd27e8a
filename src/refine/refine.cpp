#include "refine/refine.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/resources.h"
#include "refine/refinable_mesh.h"
#include "refine/write_level.h"

namespace tetfusion {

namespace {

void check_request(const RefineRequest& request) {
  const auto refuse = [](const char* message) { throw Error(ErrorCode::kUsage, message); };
  if (request.reduction && request.tets) {
    refuse("--reduction and --tets are two goals: give one of them");
  }
  if (request.reduction && !(*request.reduction >= 0 && *request.reduction < 1)) {
    refuse("--reduction must be at least 0% and less than 100%");
  }
  if (request.tets && *request.tets == 0) refuse("--tets must be at least 1");
  check_mesh_output(request.output, request.write.encoding);
}

std::uint64_t goal_of(const RefineRequest& request, const ProgressiveCounts& counts) {
  if (request.tets) return *request.tets;
  if (!request.reduction) return std::numeric_limits<std::uint64_t>::max();
  return static_cast<std::uint64_t>(
      std::ceil(static_cast<double>(counts.tets) * (1 - *request.reduction) - 1e-6));
}

// Share of the work that is done when the mesh is refined.
constexpr double kRefineShare = 0.6;

}  // namespace

RefineReport refine(const RefineRequest& request, const RunContext& context) {
  check_request(request);
  context.report("reading", 0);
  PhaseClock clock;
  clock.begin("read");
  const ProgressiveFile file = ProgressiveFile::open(request.input);
  RefineReport report;
  report.counts = file.counts();
  report.file_bytes = file.bytes();
  context.report_size(report.counts.tets);
  const std::uint64_t goal = goal_of(request, report.counts);
  RefinableMesh mesh(file.counts(), file.description().point_row_bytes(),
                     file.description().cell_row_bytes(),
                     [&](const std::string& what) { file.fail(what); });
  for (std::size_t i = 0; i < file.parts_of_points(); ++i) mesh.add_points(file.points(i));
  for (std::size_t i = 0; i < file.parts_of_tets(); ++i) mesh.add_tets(file.tets(i));
  for (std::size_t i = 0; i < file.parts_of_lower(); ++i) mesh.add_lower(file.lower(i));
  if (mesh.tets() != report.counts.base_tets) file.fail("the file has not the tetrahedra it names");
  report.reached = mesh.tets() <= goal;
  clock.begin("undo");
  bool goes_on = true;
  for (std::size_t b = 0; b < file.blocks() && goes_on; ++b) {
    context.check();
    context.report("refining", 0, kRefineShare, b, file.blocks());
    FusionBlock block = file.block(b);
    for (std::size_t i = 0; i < block.size() && goes_on; ++i) {
      const FusionRecord record = block.next();
      goes_on = mesh.tets() + record.tets.size() <= goal;
      if (!goes_on) break;
      mesh.undo(record);
      ++report.undone;
    }
  }
  if (goes_on && report.undone != report.counts.fusions) {
    file.fail("the file has not the fusions it names");
  }
  if (goes_on) {
    for (std::size_t i = 0; i < file.parts_of_spare(); ++i) mesh.add_points(file.spare(i));
    for (std::size_t i = 0; i < file.parts_of_rewound(); ++i) mesh.rewind(file.rewound(i));
    const bool is_whole = mesh.points() == report.counts.points &&
                          mesh.cells() == report.counts.cells && mesh.tets() == report.counts.tets;
    if (!is_whole) file.fail("the file has not the points and cells it names");
  }
  file.check();
  WriteOptions write = request.write;
  write.progress = [&](double share) {
    context.check();
    context.report("writing", kRefineShare + (1 - kRefineShare) * share);
  };
  report.tets = mesh.tets();
  report.points = mesh.points();
  clock.begin("write");
  write_level(mesh, file, request.output, write);
  clock.end();
  report.seconds = clock.seconds();
  context.report("done", 1);
  return report;
}

}  // namespace tetfusion
