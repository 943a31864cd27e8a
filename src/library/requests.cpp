#include "library/requests.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>

#include "base/error.h"
#include "base/numbers.h"
#include "driver/arrays/steering.h"
#include "library/options_text.h"
#include "mesh/array_names.h"

namespace tetfusion {

namespace {

static_assert(static_cast<int>(Type::kInt8) == static_cast<int>(ValueType::kInt8) &&
              static_cast<int>(Type::kFloat64) == static_cast<int>(ValueType::kFloat64));

// In texts, as a request has them, they would be refused in the words of the command.
void check_tolerances(const Options& o) {
  for (const SteeringArray& array : o.arrays) {
    if (!array.tolerance || (*array.tolerance > 0 && *array.tolerance <= 1)) continue;
    throw Error(ErrorCode::kUsage,
                fmt::format("arrays: the tolerance of \"{}\" is {}: it must be greater than 0 and "
                            "at most 1, a share of its range",
                            array.name, *array.tolerance));
  }
  for (const double share : o.scalar_tolerance) {
    if (share <= 1 || std::isinf(share)) continue;
    throw Error(ErrorCode::kUsage,
                fmt::format("scalar_tolerance: {} is more than 1, the whole range", share));
  }
}

Boundary to_boundary(BoundaryMode mode) {
  if (mode == BoundaryMode::kWithin) return Boundary::kWithin;
  return mode == BoundaryMode::kPlanar ? Boundary::kPlanar : Boundary::kExact;
}

std::string to_text(const SteeringArray& array) {
  const std::string name = (array.of_cells ? "cell:" : "") + array.name;
  return array.tolerance ? with_tolerance(name, *array.tolerance) : name;
}

void check_address(const void* data, std::size_t size, const std::string& what) {
  if (size > std::numeric_limits<std::size_t>::max() / sizeof(std::uint64_t)) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("the mesh: {} cannot have {}", what, format_count(size, "value")));
  }
  if (data != nullptr || size == 0) return;
  throw Error(ErrorCode::kBadInput, fmt::format("the mesh: {} has {}, but its address is null",
                                                what, format_count(size, "value")));
}

ValuesView to_values(const Values& values, const std::string& what) {
  check_address(values.data(), values.size(), what);
  const ValueType type = to_value_type(values.type());
  return {type, {static_cast<const std::byte*>(values.data()), values.size() * size_of(type)}};
}

std::vector<ArrayView> to_arrays(const std::vector<Array>& arrays, const char* kind) {
  std::vector<ArrayView> views;
  for (const Array& a : arrays) {
    const std::string what = fmt::format("{} array \"{}\"", kind, a.name);
    views.push_back({a.name, a.components, to_values(a.values, what)});
  }
  return views;
}

MeshFacts to_facts(const MeshSummary& m) {
  return {m.points, m.tets, m.boundary_triangles, m.volume};
}

}  // namespace

ValueType to_value_type(Type type) { return static_cast<ValueType>(type); }
Type to_type(ValueType type) { return static_cast<Type>(type); }

SimplifyRequest to_request(const Options& o) {
  if (o.threads < 0) throw Error(ErrorCode::kUsage, "threads must be at least 0");
  check_tolerances(o);
  SimplifyRequest request;
  request.input = "the mesh";
  request.output = "the result";
  BehaviourOptions& b = request.behaviour;
  b.method = o.method == Operation::kFuse ? Method::kFuse : Method::kTetFuse;
  b.boundary_rule = o.boundary_tets_stay ? BoundaryRule::kTets : BoundaryRule::kVertices;
  b.reduction = o.reduction;
  b.tets = o.tets;
  b.scalar_tolerance = o.scalar_tolerance;
  b.stretch_factor = o.stretch_factor;
  b.aspect_ratio = o.aspect_ratio;
  b.max_volume = o.max_volume;
  b.min_quality = o.min_quality;
  b.max_rms = o.max_rms;
  b.max_error = o.max_error;
  b.conserve = o.conserve;
  b.boundary = to_boundary(o.boundary);
  if (o.boundary == BoundaryMode::kWithin) b.boundary_distance = o.boundary_distance;
  b.feature_angle = o.feature_angle;
  for (const SteeringArray& array : o.arrays) b.arrays.push_back(to_text(array));
  b.regions = o.regions;
  b.interest = o.roi;
  b.weight = o.weight;
  b.chunk_tets = o.chunk_tets;
  b.original_ids = o.original_ids;
  b.tetrahedralize = o.tetrahedralize;
  b.linearize = o.linearize;
  b.drop_patches = o.drop_patches;
  b.dropped_patches = o.drop_patch;
  request.performance.threads = o.threads;
  request.performance.memory = o.memory;
  return request;
}

void check_steering(const Options& options, const MeshDescription& mesh) {
  for (const SteeringArray& array : options.arrays) {
    const AttributeSet& set = array.of_cells ? mesh.cell_data : mesh.point_data;
    if (array.name == kAllArrays && !array.of_cells) continue;
    const bool is_hidden =
        array.of_cells && mesh.point_data.find("cell:" + array.name) != AttributeSet::npos;
    const std::string text = to_text(array);
    const bool is_anothers = array.tolerance && find_array(mesh, text);
    if (set.find(array.name) != AttributeSet::npos && !is_hidden && !is_anothers) continue;
    throw Error(
        ErrorCode::kUsage,
        fmt::format("{}: {}; point arrays: {}; cell arrays (name them cell:NAME): {}", mesh.path,
                    is_anothers
                        ? fmt::format("the bound of {} cannot be told from the array \"{}\": "
                                      "rename one of them",
                                      array.name, text)
                        : fmt::format("no array \"{}{}\" to steer by",
                                      array.of_cells ? "cell:" : "", array.name),
                    names_of(mesh.point_data), names_of(mesh.cell_data)));
  }
}

MeshView to_view(const Mesh& mesh) {
  MeshView view;
  view.points = to_values(mesh.points, "points");
  view.connectivity = to_values(mesh.connectivity, "connectivity");
  view.offsets = to_values(mesh.offsets, "offsets");
  check_address(mesh.types.data(), mesh.types.size(), "types");
  check_address(mesh.ghosts.data(), mesh.ghosts.size(), "ghosts");
  view.types = mesh.types;
  view.tets_only = mesh.types.empty() && mesh.offsets.empty();
  view.ghosts = mesh.ghosts;
  view.point_arrays = to_arrays(mesh.point_arrays, "point");
  view.cell_arrays = to_arrays(mesh.cell_arrays, "cell");
  if (!mesh.active_scalars.empty()) {
    const auto is_it = [&](const Array& array) { return array.name == mesh.active_scalars; };
    if (std::ranges::none_of(mesh.point_arrays, is_it)) {
      throw Error(ErrorCode::kBadInput,
                  fmt::format("active_scalars: there is no point array {}", mesh.active_scalars));
    }
    view.point_markers["Scalars"] = mesh.active_scalars;
  }
  return view;
}

Report to_report(const SimplifyReport& r) {
  Report out;
  out.input = to_facts(r.input);
  out.output = to_facts(r.output);
  const InputFacts& odd = r.facts;
  out.odd = {odd.rewound,        odd.degenerate,          odd.inverted,
             odd.duplicate_tets, odd.nonconforming_faces, odd.unused_points,
             odd.ghost_cells,    odd.locked_vertices};
  out.reduction = r.reduction();
  out.goal_reached = r.has_goal && r.stop_reason == StopReason::kGoal;
  out.stop_sentence = r.stop_sentence();
  out.steering = r.steering;
  out.regions = r.regions;
  out.deviation = r.rounds.empty() ? 0 : r.rounds.back().deviation;
  out.rounds = r.rounds.size();
  out.chunks = r.rounds.empty() ? 1 : r.rounds.front().chunks;
  out.seconds = r.total_seconds;
  out.cpu_seconds = r.cpu_seconds;
  out.scratch_bytes = r.scratch_bytes;
  out.threads = r.threads;
  out.json = to_json(r);
  return out;
}

// But for what looks like an option in a name of the user's.
std::string in_words_of_library(const std::string& message) {
  const auto is_letter = [&](std::size_t i) {
    return i < message.size() && std::islower(static_cast<unsigned char>(message[i])) != 0;
  };
  // Those that are called otherwise there.
  static const std::map<std::string, std::string> kNames{{"array", "arrays"},
                                                         {"boundary_rule", "boundary_tets_stay"}};
  std::string out;
  for (std::size_t i = 0; i < message.size();) {
    std::string name;
    const bool begins = i == 0 || message[i - 1] == ' ' || message[i - 1] == '(';
    if (begins && message.compare(i, 2, "--") == 0) {
      std::size_t at = i + 2;
      while (is_letter(at) || (at < message.size() && message[at] == '-' && is_letter(at + 1))) {
        name += message[at] == '-' ? '_' : message[at];
        ++at;
      }
    }
    const auto other = kNames.find(name);
    if (is_option(name) || other != kNames.end()) {
      out += other != kNames.end() ? other->second : name;
      i += 2 + name.size();
    } else {
      out += message[i++];
    }
  }
  return out;
}

}  // namespace tetfusion
