#include "driver/request/check_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/placeholders.h"
#include "driver/request/stages.h"
#include "io/mesh_format.h"
#include "io/vtk/pieces_output.h"
#include "io/vtk/pvtu_reader.h"

namespace tetfusion {

namespace {

void check_progressive(const SimplifyRequest& request) {
  if (request.progressive.empty()) return;
  const BehaviourOptions& b = request.behaviour;
  if (request.progressive == "-") {
    refuse("--progressive is written to a file, not to standard output: give a name");
  }
  const auto refuse_with = [](bool given, const char* option, const char* reason) {
    if (!given) return;
    refuse(fmt::format("--progressive and {} do not go together yet: {}", option, reason));
  };
  refuse_with(b.conserve, "--conserve", "the values of cells change with it");
  refuse_with(!b.lods.empty(), "--lods", "the file holds all levels, for 'tetfusion refine'");
  refuse_with(b.tetrahedralize, "--tetrahedralize", "convert the mesh first");
  refuse_with(b.linearize, "--linearize", "convert the mesh first");
  refuse_with(b.merge_points, "--merge-points", "convert the mesh first");
  refuse_with(b.drop_patches, "--drop-patches", "convert the mesh first");
  refuse_with(!b.dropped_patches.empty(), "--drop-patch", "convert the mesh first");
}

void check_map(const SimplifyRequest& request) {
  if (request.map.empty()) return;
  if (request.map == "-") refuse("--map is written to a file, not to standard output: give a name");
  if (is_pieces_name(request.output)) {
    refuse(
        "--map is for a result in one file, but the name after -o ends in .pvtu: give another one");
  }
  const bool has_field = request.map.find(kLodField) != std::string::npos;
  if (has_field == request.behaviour.lods.empty()) {
    refuse(has_field ? "the name after --map holds {lod}, but there is no --lods"
                     : "with --lods there are several maps: the name after --map must hold {lod}, "
                       "as in part_{lod}.map");
  }
}

void check_goal(const BehaviourOptions& b) {
  if (b.reduction && b.tets) refuse("--reduction and --tets are two goals: give one of them");
  if (b.reduction && !(*b.reduction >= 0 && *b.reduction < 1)) {
    refuse("--reduction must be at least 0% and less than 100%");
  }
  if (b.tets && *b.tets == 0) refuse("--tets must be at least 1");
  const auto is_share = [](double v) { return v > 0 && v <= 1; };
  if (b.max_rms && !is_share(*b.max_rms)) {
    refuse("--max-rms must be greater than 0% and at most 100% of the range");
  }
  if (b.max_error && !is_share(*b.max_error)) {
    refuse("--max-error must be greater than 0% and at most 100% of the range");
  }
}

void check_criteria(const BehaviourOptions& b) {
  const auto positive = [](double v) { return v > 0; };
  if (!std::all_of(b.scalar_tolerance.begin(), b.scalar_tolerance.end(), positive)) {
    refuse("--scalar-tolerance must be greater than 0 (a share of the range), or off");
  }
  const auto at_least_one = [](double v) { return v >= 1; };
  if (!std::all_of(b.stretch_factor.begin(), b.stretch_factor.end(), at_least_one)) {
    refuse("--stretch-factor must be at least 1, or off");
  }
  if (!at_least_one(b.aspect_ratio)) refuse("--aspect-ratio must be at least 1");
  if (!(b.max_volume > 0)) refuse("--max-volume must be greater than 0");
  if (b.min_quality && !(*b.min_quality >= 0 && *b.min_quality < 1)) {
    refuse("--min-quality must be at least 0 and less than 1");
  }
  if (b.boundary == Boundary::kWithin && !(b.boundary_distance > 0 && b.boundary_distance < 1)) {
    refuse("--boundary must be a share of the diagonal, more than 0% and less than 100%");
  }
  if (!b.feature_angle) return;
  if (!(*b.feature_angle > 0 && *b.feature_angle <= 180)) {
    refuse("--feature-angle must be more than 0 and at most 180 degrees");
  }
  if (b.boundary == Boundary::kExact) {
    refuse(
        "--feature-angle is for a surface that may move: give --boundary planar or a distance as "
        "well, or leave the option out");
  }
}

// An option that the method has no use for would be forgotten without a word.
void check_method(const BehaviourOptions& b) {
  const auto is_for = [&](Method method, const char* option, bool given) {
    if (!given || b.method == method) return;
    refuse(fmt::format("{} belongs to --method {}: give that as well, or leave the option out",
                       option, method == Method::kFuse ? "fuse" : "tetfuse"));
  };
  is_for(Method::kTetFuse, "--boundary-rule", b.boundary_rule != BoundaryRule::kVertices);
  is_for(Method::kFuse, "--boundary", b.boundary != Boundary::kExact);
  is_for(Method::kFuse, "--min-quality", b.min_quality.has_value());
  is_for(Method::kFuse, "--max-error", b.max_error.has_value());
  is_for(Method::kFuse, "--max-rms", b.max_rms.has_value());
  is_for(Method::kFuse, "--conserve", b.conserve);
  is_for(Method::kFuse, "--weight", !b.weight.empty());
  if (b.conserve && b.boundary == Boundary::kWithin) {
    refuse("--conserve needs a boundary that stays, exact or planar");
  }
}

void check_chunks(const BehaviourOptions& b) {
  if (b.chunk_tets == 0) refuse("--chunk-tets must be at least 1");
  if (b.chunk_tets > kMaxChunkTets) {
    refuse(fmt::format("--chunk-tets must be at most {}", kMaxChunkTets));
  }
}

void check_lods(const SimplifyRequest& request) {
  const BehaviourOptions& b = request.behaviour;
  const bool has_field = request.output.find(kLodField) != std::string::npos;
  if (b.lods.empty()) {
    if (has_field) refuse("the name after -o holds {lod}, but there is no --lods");
    return;
  }
  if (!std::is_sorted(b.lods.begin(), b.lods.end())) {
    refuse("--lods must ascend, as in 50%,80%,95%");
  }
  const auto twin = std::adjacent_find(b.lods.begin(), b.lods.end());
  if (twin != b.lods.end()) {
    refuse(fmt::format("--lods has two levels of {:.6g}%; each must go further than the one before",
                       100 * *twin));
  }
  for (const double lod : b.lods) {
    if (!(lod >= 0 && lod < 1)) refuse("--lods must be at least 0% and less than 100%");
  }
  if (b.reduction && *b.reduction < b.lods.back()) {
    refuse(
        "--lods goes further than --reduction: give one of them, or a goal beyond the last level");
  }
  if (!has_field) {
    refuse(
        fmt::format("--lods writes several files: the name after -o must hold {{lod}}, as in "
                    "part_{{lod}}.vtu, but it is \"{}\"",
                    request.output));
  }
}

void check_pieces(const SimplifyRequest& request) {
  if (request.pieces > 0 && !is_pieces_name(request.output)) {
    refuse(fmt::format("--pieces is for a name after -o that ends in .pvtu, but it is \"{}\"",
                       request.output));
  }
  // Cells of lower dimension are one piece more.
  if (request.verify && request.pieces >= kMaxPiecesRead) {
    refuse(fmt::format("--verify reads less than {} pieces: give fewer with --pieces, or one file",
                       kMaxPiecesRead));
  }
}

}  // namespace

void check_options(const SimplifyRequest& request) {
  check_method(request.behaviour);
  check_goal(request.behaviour);
  check_criteria(request.behaviour);
  check_chunks(request.behaviour);
  check_lods(request);
  check_pieces(request);
  check_map(request);
  check_progressive(request);
}

void refuse_outputs_among(const MeshDescription& mesh, const SimplifyRequest& request) {
  const auto refuse_more_than = [&](std::uint64_t most, const char* option) {
    if (mesh.cells <= most) return;
    refuse(fmt::format("{} is for meshes of at most {} cells, and {} has {}", option, most,
                       request.input, mesh.cells));
  };
  if (!request.progressive.empty()) refuse_more_than(kMaxTets, "--progressive");
  if (!request.map.empty()) refuse_more_than(kNoTet, "--map");
  refuse_piece(request.progressive, mesh);
  refuse_piece(request.also_written, mesh);
  // Each level is made of the original: it can only take that one's name when it is the last.
  std::vector<std::string> others = mesh.files;
  others.push_back(mesh.path);
  const std::vector<Stage> stages = plan_stages(request, kMaxTets);
  for (const Stage& stage : stages) {
    refuse_piece(stage.path, mesh);
    refuse_piece(stage.map, mesh);
    if (&stage != &stages.back()) refuse_same_file("-o", stage.path, others);
  }
  for (const Stage& stage : stages) others.push_back(stage.path);
  for (const Stage& stage : stages) {
    refuse_same_file("--map", stage.map, others);
    others.push_back(stage.map);
  }
  others.push_back(request.also_written);
  refuse_same_file("--progressive", request.progressive, others);
}

}  // namespace tetfusion
