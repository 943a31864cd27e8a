#include "driver/promise.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "base/error.h"
#include "base/resources.h"
#include "driver/arrays/carried_arrays.h"
#include "driver/arrays/regions.h"
#include "driver/request/error_limits.h"
#include "driver/rounds/round_plan.h"
#include "io/mesh_format.h"
#include "io/vtk/pieces_output.h"
#include "verify/result_seam.h"

namespace tetfusion {

namespace {

void promise_surfaces(const BehaviourOptions& behaviour, const RunChoices& choices,
                      Promise* promise) {
  if (behaviour.boundary == Boundary::kPlanar) {
    promise->distance = flatness(behaviour, choices.mesh.point_type);
  }
  if (behaviour.boundary == Boundary::kWithin) promise->distance = behaviour.boundary_distance;
  promise->regions = names_of_cell_arrays(choices.mesh, choices.regions);
}

void promise_errors(const BehaviourOptions& behaviour, const RunChoices& choices,
                    Promise* promise) {
  if (behaviour.method != Method::kFuse) return;
  const double limit = error_limits(behaviour, tolerances_of(choices.steering)).max_error;
  for (const SteeringChoice& choice : choices.steering) {
    const double share = choice.tolerance.value_or(limit);
    if (share == std::numeric_limits<double>::infinity()) continue;
    if (choice.association == Association::kCell) {
      promise->beyond.push_back(
          fmt::format("the error of {}: its bound is for its means at the points, which no file "
                      "holds ('tetfusion compare' measures the values of the cells)",
                      choice.name));
      continue;
    }
    const ArrayInfo& info = choices.mesh.point_data.arrays[choice.index];
    if (is_float(info.type)) {
      promise->errors.push_back({info.name, share});
    } else {
      promise->beyond.push_back(
          fmt::format("the error of {}: its bound is for the smooth field through its whole "
                      "numbers, which no file holds",
                      choice.name));
    }
  }
  if (behaviour.max_rms) {
    promise->beyond.emplace_back("the mean error of fusions: --max-rms is for an estimate of it");
  }
}

void add_dropped(const AttributeSet& all, const std::vector<std::size_t>& carried,
                 const std::string& prefix, Promise* promise) {
  for (std::size_t i = 0; i < all.arrays.size(); ++i) {
    if (std::find(carried.begin(), carried.end(), i) != carried.end()) continue;
    promise->dropped.push_back(prefix + all.arrays[i].name);
  }
}

}  // namespace

Promise promise_of(const BehaviourOptions& behaviour, const RunChoices& choices,
                   const InputFacts& facts, const LowerCells& lower, const MeshSummary& written) {
  Promise promise;
  promise.points = written.points;
  promise.tets = written.tets;
  promise.boundary_triangles = facts.boundary_faces + written.boundary_triangles;
  promise.lower_types = lower.types;
  promise.inverted = facts.inverted;
  promise.duplicate_tets = facts.duplicate_tets;
  promise.nonconforming_faces = facts.nonconforming_faces;
  promise.degenerate = facts.degenerate;
  promise.nonmanifold_edges = facts.nonmanifold_edges;
  promise.integrals = behaviour.conserve;
  promise_surfaces(behaviour, choices, &promise);
  promise_errors(behaviour, choices, &promise);
  promise.max_volume = behaviour.max_volume;
  promise.interest =
      RegionOfInterest(behaviour.interest, choices.mesh.path, choices.mesh.point_data);
  const CarriedArrays carried(choices.mesh);
  add_dropped(choices.mesh.point_data, carried.point_indices, "", &promise);
  add_dropped(choices.mesh.cell_data, carried.cell_indices, "cell:", &promise);
  return promise;
}

void require_boundary(const std::string& input, const InputFacts& facts) {
  if (facts.boundary_faces > 0) return;
  throw Error(
      ErrorCode::kBadInput,
      fmt::format("{}: the mesh has no boundary, so cells must be doubled or without "
                  "volume, and --verify and --map have nothing to go by; see 'tetfusion check'",
                  input));
}

Verification verify_output(const WrittenOutput& output, const Promise& promise,
                           MeshSource* original, const RunContext& context, MemoryBudget* budget) {
  trim_memory();
  const ComparisonNeeds needs = estimate_comparison(original->description(), promise.tets,
                                                    promise.points, promise.boundary_triangles);
  const std::uint64_t sides = needs.sides_within(budget->free());
  const auto reserved = budget->reserve(needs.fixed + sides, "the verification of the result");
  result_seam().written(output.path);
  Verification verification = verify_result(original, output.path, promise, sides, context);
  verification.path = output.name;
  if (!is_pieces_name(output.name) && output_format(output.name) != MeshFormat::kVtu) {
    verification.not_verified.emplace_back(
        "what its format has no place for: the mesh was verified before it was brought into that");
  }
  if (verification.kept()) return verification;
  throw Error(ErrorCode::kBroken,
              fmt::format("{} was not written, and what had that name stays, as --verify has found "
                          "the result not to be what was promised: {}. Without --verify it is "
                          "written all the same, for 'tetfusion check' and 'tetfusion compare' to "
                          "look at",
                          output.name, verification.complaint()));
}

}  // namespace tetfusion
