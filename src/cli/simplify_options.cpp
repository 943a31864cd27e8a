#include "cli/simplify_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <string_view>

#include "base/error.h"
#include "base/numbers.h"
#include "cli/listed_steps.h"

namespace tetfusion {

namespace {

// "0.025,0.05" or "off".
std::vector<double> parse_schedule(const std::string& option, const std::string& text,
                                   bool shares) {
  std::vector<double> values;
  for (const std::string& part : split(text, ',')) {
    if (part.empty()) refuse(fmt::format("{} {}: a value is missing at a comma", option, text));
    if (part == "off") {
      values.push_back(std::numeric_limits<double>::infinity());
      continue;
    }
    if (shares) {
      values.push_back(parse_share_of_range(option, part, "2.5%"));
      continue;
    }
    const auto value = parse_number(part);
    if (!value) refuse(fmt::format("{} {}: \"{}\" is no number", option, text, part));
    values.push_back(*value);
  }
  return values;
}

void parse_lods(const SimplifyArguments& a, BehaviourOptions* behaviour) {
  if (a.lods.empty()) return;
  const auto count = parse_count(a.lods);
  const bool is_count = count && a.lods.find('.') == std::string::npos;
  if (!is_count) {
    for (const std::string& part : split(a.lods, ',')) {
      const auto share = parse_share(part);
      if (!share) refuse(fmt::format("--lods {}: \"{}\" is no share, as in 50%", a.lods, part));
      behaviour->lods.push_back(*share);
    }
    return;
  }
  if (!behaviour->reduction) {
    refuse(
        "--lods N spaces its levels from the input to a goal: give --reduction as well, or the "
        "levels themselves, as in --lods 50%,80%");
  }
  if (*count < 1 || *count > 1000) refuse("--lods: give 1 to 1000 levels");
  // Geometrically: each level has the same share of the tetrahedra of the one before.
  const double left = 1 - *behaviour->reduction;
  for (std::uint64_t i = 1; i <= *count; ++i) {
    behaviour->lods.push_back(
        i == *count ? *behaviour->reduction
                    : 1 - std::pow(left, static_cast<double>(i) / static_cast<double>(*count)));
  }
}

void parse_boundary(const std::string& text, BehaviourOptions* behaviour) {
  if (text == "exact") return;
  behaviour->boundary = Boundary::kPlanar;
  if (text == "planar") return;
  const auto share = parse_share(text);
  if (!share) {
    refuse(fmt::format("--boundary {}: give exact, planar, or a share of the diagonal, as in 0.1%",
                       text));
  }
  if (*share >= 1) {
    refuse(fmt::format("--boundary {}: that is {:.6g} % of the diagonal; give less, as in 0.1%",
                       text, 100 * *share));
  }
  if (*share == 0) {
    refuse(fmt::format(
        "--boundary {}: give exact, where no vertex of the surface moves, or a share of the "
        "diagonal, as in 0.1%",
        text));
  }
  constexpr double kMostBare = 0.1;  // so far that a percent sign is likely to be missing
  if (*share >= kMostBare && !text.ends_with('%')) {
    refuse(
        fmt::format("--boundary {0}: that is {1:.6g} % of the diagonal; give {0}% or {1:.6g}%, "
                    "whichever is meant",
                    text, 100 * *share));
  }
  behaviour->boundary = Boundary::kWithin;
  behaviour->boundary_distance = *share;
}

void parse_arguments(SimplifyArguments* a) {
  BehaviourOptions& b = a->request.behaviour;
  if (!a->min_quality.empty()) {
    b.min_quality = parse_number(a->min_quality);
    if (!b.min_quality) {
      refuse(fmt::format("--min-quality {}: give a number, as in 0.1", a->min_quality));
    }
  }
  if (!a->max_rms.empty()) b.max_rms = parse_share_of_range("--max-rms", a->max_rms, "0.1%");
  parse_boundary(a->boundary, &b);
  if (a->feature_angle == "off") {
    b.feature_angle = 180;
  } else if (!a->feature_angle.empty()) {
    b.feature_angle = parse_number(a->feature_angle);
    if (!b.feature_angle) {
      refuse(fmt::format("--feature-angle {}: give degrees, as in 40, or off", a->feature_angle));
    }
  }
  if (!a->max_error.empty()) b.max_error = parse_share_of_range("--max-error", a->max_error, "1%");
  if (!a->reduction.empty()) {
    b.reduction = parse_share(a->reduction);
    if (!b.reduction)
      refuse(fmt::format("--reduction {}: give a share, as in 90% or 0.9", a->reduction));
    if (*b.reduction > 1) {
      refuse(fmt::format("--reduction {}: that is {:.6g} %; give less than 100%, as in 90% or 0.9",
                         a->reduction, 100 * *b.reduction));
    }
  }
  if (!a->tets.empty()) b.tets = parse_tets("--tets", a->tets);
  if (!a->chunk_tets.empty()) b.chunk_tets = parse_tets("--chunk-tets", a->chunk_tets);
  if (!a->scalar_tolerance.empty()) {
    b.scalar_tolerance = parse_schedule("--scalar-tolerance", a->scalar_tolerance, true);
  }
  if (!a->stretch_factor.empty()) {
    b.stretch_factor = parse_schedule("--stretch-factor", a->stretch_factor, false);
  }
  const auto aspect = parse_schedule("--aspect-ratio", a->aspect_ratio, false);
  if (aspect.size() != 1) refuse("--aspect-ratio takes one value");
  b.aspect_ratio = aspect[0];
  const auto volume = parse_schedule("--max-volume", a->max_volume, false);
  if (volume.size() != 1) refuse("--max-volume takes one value");
  b.max_volume = volume[0];
  if (!a->regions.empty()) {
    const bool none = a->regions.size() == 1 && a->regions[0] == "none";
    b.regions = none ? std::vector<std::string>{} : a->regions;
    // As --array and --weight say it.
    for (std::string& name : *b.regions) {
      if (name.starts_with("cell:")) name.erase(0, std::string_view("cell:").size());
    }
  }
  parse_lods(*a, &b);
  if (a->report == "-" && a->request.output == "-") {
    refuse("the mesh and the report cannot both go to standard output");
  }
}

// What is read and written.
void add_file_options(CLI::App& command, SimplifyArguments* a) {
  command
      .add_option("IN", a->inputs,
                  "The mesh: a .vtu, .pvtu, .vtk, Medit, Gmsh or TetGen file, or - for standard "
                  "input; with the VTK plugin also VTK's other files, Exodus, CGNS, VTKHDF, "
                  "XDMF, an EnSight .case, or an OpenFOAM case by its .foam or "
                  "system/controlDict; or the steps of a series over time: several files, a .pvd "
                  "or .series that names them, or one file that has them all (Exodus, EnSight, "
                  "OpenFOAM, CGNS, XDMF)")
      ->required()
      ->check(not_empty);
  command
      .add_option(
          "-o,--output", a->request.output,
          "The result: a .vtu file, a .pvtu file with several pieces, .vtk, .mesh or .meshb "
          "(Medit), .msh (Gmsh), .node or .ele (TetGen), or - for standard "
          "output. Of a series its name holds {step}, which is replaced by what differs "
          "between the names of the inputs, as 017 of step_017.vtu (counted from 0 where "
          "that tells nothing, and where one file has all steps), or is that of a .pvd, OUT.pvd "
          "of OUT_{step}.vtu")
      ->required()
      ->check(not_empty)
      ->group(kOutputGroup);
  command
      .add_option("--series", a->series,
                  "Of several steps: shared, one mesh for all, on which --max-error holds at each "
                  "step (default); each, every step by itself. Not with a series: --lods, "
                  "--dry-run, --progressive, --pieces, standard input and output; "
                  "each: --map; shared: --resume, --verify, --conserve")
      ->check(CLI::IsMember({"shared", "each"}).description("{shared,each}"))
      ->group(kOutputGroup);
  command
      .add_option(
          "--pieces", a->request.pieces,
          "Pieces of a .pvtu file; they lie in the folder OUT_pieces beside it. Default: "
          "one for each 4 million tetrahedra of the result. Without VTK this program reads up to "
          "512 of them")
      ->check(CLI::Range(1, 65536))
      ->group(kOutputGroup);
  command
      .add_flag("--verify", a->request.verify,
                "Check the result, and compare it with the input, before it gets its name: a "
                "promise that is not kept (cells, boundary, regions, arrays, --max-error, "
                "--conserve) ends with exit code 1, and the old file stays")
      ->group(kOutputGroup);
  command
      .add_flag("--original-ids", a->request.behaviour.original_ids,
                "Write the point array OriginalPointIds: the input's number of each point that "
                "stayed, -1 of those that are new")
      ->group(kOutputGroup);
  command
      .add_option(
          "--map", a->request.map,
          "Write to this file where each of the input's points and cells went, for "
          "'tetfusion apply' to bring other time steps or results onto OUT; with --lods its name "
          "holds {lod}")
      ->check(not_empty)
      ->group(kOutputGroup);
  command
      .add_option("--progressive", a->request.progressive,
                  "Write to this file how 'tetfusion refine' goes back from OUT to IN, as far as "
                  "wanted. Values of new points are then those that fusing has left: they are not "
                  "fitted to IN's in the end")
      ->check(not_empty)
      ->group(kOutputGroup);
}

void add_goal_options(CLI::App& command, SimplifyArguments* a) {
  constexpr const char* kGroup = "Goal";
  command
      .add_option("--reduction", a->reduction,
                  "The share of the tetrahedra that is to go, as in 90% or 0.9")
      ->check(not_empty)
      ->group(kGroup);
  command.add_option("--tets", a->tets, "How many tetrahedra are to be left, as in 100000 or 2M")
      ->check(not_empty)
      ->group(kGroup);
  command
      .add_option("--max-error", a->max_error,
                  "With --method fuse: at none of the input's points a steering field is off by "
                  "more than this share of its range (1%), of a vector that of the diagonal of the "
                  "box of its values. Default: 1%, but anything with a goal, "
                  "--max-rms or a tolerance of any --array. With a goal the errors stay as far "
                  "below as it allows")
      ->check(not_empty)
      ->group(kGroup);
  command
      .add_option("--max-rms", a->max_rms,
                  "With --method fuse: no fusion may change a steering field by more than this, "
                  "in the mean of squares, as a share of its range (0.1%); an estimate. Default: "
                  "anything")
      ->check(not_empty)
      ->group(kGroup);
  command
      .add_option(
          "--lods", a->lods,
          "Write levels on the way to OUT, whose name holds {lod}: a number of levels, "
          "spaced geometrically from the input to the goal (with --reduction), or reductions, "
          "as in 50%,80%")
      ->check(not_empty)
      ->group(kGroup);
  command.add_flag("--strict", a->strict, "Exit with code 6 when the goal is not reached")
      ->group(kGroup);
}

constexpr const char* kCriteriaGroup = "Criteria";

// What is fused with what, and what becomes of surfaces.
void add_method_options(CLI::App& command, SimplifyArguments* a) {
  static const std::map<std::string, Method> kMethods{{"tetfuse", Method::kTetFuse},
                                                      {"fuse", Method::kFuse}};
  static const std::map<std::string, BoundaryRule> kRules{{"tets", BoundaryRule::kTets},
                                                          {"vertices", BoundaryRule::kVertices}};
  add_choice(command, "--method", &a->request.behaviour.method, kMethods,
             "fuse: neighbouring vertices become one, where that changes the fields least; "
             "without a goal as far as --max-error allows. tetfuse: the paper's operation, the "
             "four vertices of a tetrahedron become one; without a goal until nothing, or next "
             "to nothing, fuses")
      ->default_str("fuse")
      ->group(kCriteriaGroup);
  add_choice(command, "--boundary-rule", &a->request.behaviour.boundary_rule, kRules,
             "With --method tetfuse, what stays for the boundary's sake: vertices (no boundary "
             "vertex is fused) or tets (the paper's text: nor is a tetrahedron with a vertex on "
             "the boundary touched)")
      ->default_str("vertices")
      ->group(kCriteriaGroup);
  command
      .add_option(
          "--boundary", a->boundary,
          "What may become of the boundary surface, and of surfaces between regions. exact: every "
          "triangle stays. With --method fuse also planar: the surface stays where it is, but flat "
          "parts and straight edges get new triangles; or a share of the bounding box's diagonal, "
          "as in 0.1%: nowhere is the new surface further from the old one, nor the old one from "
          "the new one")
      ->check(not_empty)
      ->capture_default_str()
      ->group(kCriteriaGroup);
  command
      .add_option("--feature-angle", a->feature_angle,
                  "With a surface that may move: where it is bent by so many degrees or "
                  "more between two triangles there is a sharp edge, which stays, and so do the "
                  "corners where such edges meet; or off. Default: 40")
      ->check(not_empty)
      ->group(kCriteriaGroup);
}

// What no fusion may do.
void add_limit_options(CLI::App& command, SimplifyArguments* a) {
  command
      .add_option("--scalar-tolerance", a->scalar_tolerance,
                  "In a single fusion the values of the fused may differ from the new one by this "
                  "share of the field's range (0.025 or 2.5%), or off; a list has one value a "
                  "round (the paper's macroLoD), the last one repeated. Default: 0.025 with "
                  "--method tetfuse, else off")
      ->check(not_empty)
      ->group(kCriteriaGroup);
  command
      .add_option(
          "--stretch-factor", a->stretch_factor,
          "A tetrahedron's height may grow by this factor in a round (the paper's macroLoD), at "
          "least 1, or off; a list has one value a round. Default: 5 with --method tetfuse, else "
          "off")
      ->check(not_empty)
      ->group(kCriteriaGroup);
  command
      .add_option("--aspect-ratio", a->aspect_ratio,
                  "Longest over shortest edge of a tetrahedron may not exceed this, at least 1, "
                  "unless it was worse; or off")
      ->capture_default_str()
      ->group(kCriteriaGroup);
  command
      .add_option(
          "--max-volume", a->max_volume,
          "No tetrahedron grows beyond this volume, in the mesh's own unit, nor one that is "
          "larger at all; or off")
      ->capture_default_str()
      ->group(kCriteriaGroup);
  command
      .add_flag(
          "--conserve", a->request.behaviour.conserve,
          "With --method fuse: the integral of every floating-point array over the mesh stays, "
          "to 1e-12 of that of its absolute value (1e-6 in single precision), but for --regions, "
          "whose values cells keep. With a boundary that is exact or planar")
      ->group(kCriteriaGroup);
  command
      .add_option("--min-quality", a->min_quality,
                  "With --method fuse: no new tetrahedron has a lower mean ratio (1 is regular, 0 "
                  "flat), unless the input has one there, and then none lower by more than a "
                  "twentieth; 0 switches that off. Default: 0.22, which keeps other new dihedral "
                  "angles between 4.1 and 171.7 degrees")
      ->check(not_empty)
      ->group(kCriteriaGroup);
}

// What arrays have to say, and places.
void add_field_options(CLI::App& command, SimplifyArguments* a) {
  command
      .add_option(
          "--array", a->request.behaviour.arrays,
          "An array that steers: NAME, NAME:0.5% (in place of --max-error or --scalar-tolerance), "
          "cell:NAME; may be given again; all: every floating-point point array. "
          "\"pressure_{step}\" stands for the point arrays of one "
          "mesh that are the steps of a series. Default: the active scalars, else the first "
          "floating-point point array, of these the first that is not the same everywhere. All "
          "arrays are carried along")
      ->allow_extra_args(false)
      ->group(kCriteriaGroup);
  command
      .add_option("--regions", a->regions,
                  "A cell array of one component (NAME or cell:NAME) whose interfaces stay, or "
                  "none; may be given again. Floating-point numbers tell regions apart where they "
                  "differ. Default: "
                  "those of integers named like material, region, physical, tissue, block, zone, "
                  "part, label, the references medit:ref and tetgen:ref, and the blocks of Exodus "
                  "(ObjectId)")
      ->allow_extra_args(false)
      ->group(kCriteriaGroup);
  command
      .add_option("--roi", a->request.behaviour.interest,
                  "A region of interest, where the mesh stays as it is: box=X0,X1,Y0,Y1,Z0,Z1, "
                  "sphere=X,Y,Z,RADIUS, or a point array and a value, as in \"pressure>0.5\" or "
                  "\"pressure<0.5\" (of a vector its length; in a shared series in any of the "
                  "steps). May be given again. A tetrahedron stays if all of its points are in one "
                  "of them")
      ->allow_extra_args(false)
      ->group(kCriteriaGroup);
  command
      .add_option("--weight", a->request.behaviour.weight,
                  "With --method fuse: a point array, or cell:NAME, of numbers >= 0 that says how "
                  "much errors count: where it is 2 one is as bad as one twice as large where it "
                  "is 1, so that the mesh stays finer there; --max-rms is divided by it")
      ->check(not_empty)
      ->group(kCriteriaGroup);
}

void add_performance_options(CLI::App& command, SimplifyArguments* a) {
  PerformanceOptions& performance = a->request.performance;
  add_thread_option(command, &performance.threads);
  add_memory_option(
      command, &performance.memory,
      "Memory that the run may take at most, as in 2G, 512M or 1.5G; what does not fit goes to the "
      "scratch folder. The result does not depend on it. Default: half of what the machine or its "
      "control group allows");
  command
      .add_option(
          "--scratch", performance.scratch,
          "Folder for what does not fit into memory, and for what --resume needs: empty, or "
          "not there yet, and removed when the run is done. Default: OUT.tetfusion, beside the "
          "output")
      ->check(not_empty)
      ->group(kPerformanceGroup);
  command
      .add_option(
          "--chunk-tets", a->chunk_tets,
          "Tetrahedra in each of the chunks that threads work on; the only performance option that "
          "changes the result. Default: " +
              std::to_string(BehaviourOptions().chunk_tets))
      ->check(not_empty)
      ->group(kPerformanceGroup);
  command
      .add_flag("--resume", performance.resume,
                "Go on with a run that was interrupted, from what it left in the scratch folder: "
                "same input, same options, but threads and memory as you like. Starts anew where "
                "there is nothing to go on with")
      ->group(kPerformanceGroup);
  command
      .add_flag(
          "--dry-run", a->dry_run,
          "Say what the run would take (arrays, memory, scratch space) and about how far it would "
          "come in what time, after trying a part of the mesh; write nothing but --report")
      ->group(kPerformanceGroup);
}

}  // namespace

void add_simplify_options(CLI::App& command, SimplifyArguments* a) {
  add_file_options(command, a);
  add_goal_options(command, a);
  add_method_options(command, a);
  add_limit_options(command, a);
  add_field_options(command, a);
  BehaviourOptions& behaviour = a->request.behaviour;
  add_cell_options(command, &behaviour);
  add_time_step_option(command, &behaviour.time_step, kStepByOutput);
  add_encoding_option(command, &a->request.encoding);
  add_report_option(command, &a->report);
  add_performance_options(command, a);
  add_console_options(command, &a->console, "Say more: a line for each round, time and memory");
}

void parse_simplify_arguments(SimplifyArguments* a) {
  take_chosen_step(&a->inputs, a->request.output, &a->request.behaviour.time_step);
  a->request.input = a->inputs[0];
  parse_arguments(a);
}

}  // namespace tetfusion
