#include "run_case.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include "base/error.h"
#include "case.h"
#include "driver/simplify.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "judge.h"
#include "mesh/inspection/inspect.h"

namespace corpus {

namespace {

using tetfusion::Error;
using tetfusion::ErrorCode;

tetfusion::SimplifyRequest request_of(const Options& o, const std::string& folder) {
  tetfusion::SimplifyRequest request;
  request.input = folder + "/in.vtu";
  request.output = folder + "/out.vtu";
  request.verify = o.verify;
  auto& b = request.behaviour;
  b.method = o.fuse ? tetfusion::Method::kFuse : tetfusion::Method::kTetFuse;
  if (o.boundary_tets) b.boundary_rule = tetfusion::BoundaryRule::kTets;
  b.tets = o.tets;
  b.max_error = o.max_error;
  b.max_rms = o.max_rms;
  if (o.scalar_tolerance) b.scalar_tolerance = {*o.scalar_tolerance};
  if (o.stretch_factor) b.stretch_factor = {*o.stretch_factor};
  b.aspect_ratio = o.aspect_ratio.value_or(std::numeric_limits<double>::infinity());
  if (o.fuse) b.min_quality = o.min_quality;
  if (o.surface == Surface::kPlanar) b.boundary = tetfusion::Boundary::kPlanar;
  if (o.surface == Surface::kWithin) b.boundary = tetfusion::Boundary::kWithin;
  b.boundary_distance = o.distance;
  b.feature_angle = o.feature_angle;
  b.conserve = o.conserve;
  if (!o.regions) b.regions = std::vector<std::string>{};
  b.chunk_tets = o.chunk_tets;
  request.performance.threads = o.threads;
  request.performance.on_disk = o.on_disk;
  return request;
}

// What `tetfusion check` counts.
struct Checked {
  std::uint64_t inverted = 0, duplicates = 0, nonconforming = 0, degenerate = 0, edges = 0;
};

Checked check(const std::string& path) {
  tetfusion::Geometry mesh = tetfusion::open_mesh(path)->read_geometry();
  const tetfusion::Inspection i = tetfusion::inspect(mesh);
  return {i.inverted, i.duplicate_tets, i.foldover_faces + i.overfull_faces, i.degenerate,
          i.nonmanifold_edges};
}

void compare_checks(const std::string& folder, std::vector<std::string>* faults) {
  const Checked a = check(folder + "/in.vtu"), b = check(folder + "/out.vtu");
  const auto compare = [&](const char* what, std::uint64_t before, std::uint64_t after) {
    if (after <= before) return;
    faults->push_back("check: " + std::to_string(after) + " " + what + ", before " +
                      std::to_string(before));
  };
  compare("inverted cells", a.inverted, b.inverted);
  compare("duplicate cells", a.duplicates, b.duplicates);
  compare("faces that do not conform", a.nonconforming, b.nonconforming);
  compare("degenerate cells", a.degenerate, b.degenerate);
  compare("edges that are not manifold", a.edges, b.edges);
}

std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Another number of threads, chunks elsewhere: the same bytes.
void run_again(const Options& options, const std::string& folder,
               std::vector<std::string>* faults) {
  const std::string before = bytes_of(folder + "/out.vtu");
  Options other = options;
  other.threads = 4 - options.threads;
  other.on_disk = !options.on_disk;
  other.verify = false;  // which has had its say
  tetfusion::simplify(request_of(other, folder));
  if (bytes_of(folder + "/out.vtu") != before) faults->push_back("bytes: they are others");
}

// What the program may refuse: nothing to steer by, nothing to compare with.
bool may_refuse(const Error& error) {
  const std::string what = error.what();
  return (error.code() == ErrorCode::kUsage && what.find("no array steers") != std::string::npos) ||
         (error.code() == ErrorCode::kBadInput && what.find("no boundary") != std::string::npos);
}

}  // namespace

Outcome run_case(std::uint64_t number, const std::string& folder) {
  const Case c = make_case(number);
  Outcome out;
  out.kind = c.kind;
  out.before = c.mesh.tets.size();
  out.options = c.place + ": " + c.options.command();
  write_vtu(c.mesh, folder + "/in.vtu");
  std::filesystem::remove(folder + "/out.vtu");
  try {
    tetfusion::simplify(request_of(c.options, folder));
  } catch (const Error& error) {
    if (may_refuse(error)) {
      out.refused = error.what();
      return out;
    }
    if (error.code() != ErrorCode::kBroken) throw;
    const std::string what = error.what();
    const bool of_error = what.find(": the largest error of") != std::string::npos ||
                          what.find(" where the input's is, the first at") != std::string::npos;
    out.faults.push_back(
        (of_error && c.options.surface != Surface::kExact ? "error outside: " : "verify: ") + what);
    std::filesystem::remove_all(folder + "/out.vtu.tetfusion");  // kept, as the run can be resumed
    Options all_the_same = c.options;
    all_the_same.verify = false;
    tetfusion::simplify(request_of(all_the_same, folder));
  }
  const Mesh result = read_vtu(folder + "/out.vtu");
  out.after = result.tets.size();
  for (std::string& fault : judge(c, result)) out.faults.push_back(std::move(fault));
  compare_checks(folder, &out.faults);
  if (c.options.twice) run_again(c.options, folder, &out.faults);
  return out;
}

}  // namespace corpus
