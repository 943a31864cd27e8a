// Which files are the steps of a series, and what becomes of each.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/placeholders.h"
#include "base/run_context.h"
#include "io/mesh_format.h"
#include "io/source/mesh_source.h"
#include "series/series.h"

namespace tetfusion {

bool holds_step(const std::string& name);

struct Step {
  std::string input;
  std::string label;           // what stands for {step}
  std::optional<double> time;  // as the .pvd file has it
  std::string output;
  std::optional<std::uint64_t> time_step;  // of the input's own steps, as in OpenOptions
  // Of steps that are arrays of one mesh: those of this step, by the names that hold {step}.
  std::map<std::string, std::string> arrays;
};

// What stands for that array where steps are arrays of one mesh, if it is one of this step.
std::optional<std::string> pattern_of(const Step& step, const std::string& name);

struct SeriesPlan {
  std::vector<Step> steps;  // at least one
  std::string list;         // the .pvd file to write; empty: none

  bool in_one_mesh() const { return !steps[0].arrays.empty(); }
};

std::vector<std::string> labels_of(const SeriesPlan& plan);

// What went wrong, with the step's label where the file has several.
Error in_step(const Step& step, const Error& error);

// Steps come in the order of their times, of their labels where these are numbers, else as given.
// With steps in one mesh its arrays are looked at; those that one file has itself stay in its
// order, and are counted from 0. Throws Error(kUsage) for options that a series cannot have, for an
// output that is an input or another step's output; what opening a .pvd file throws, and a file
// that VTK looks into, as long as the context lets it.
SeriesPlan plan_series(const SeriesRequest& request, const RunContext& context);

// What another job than a simplification reads and writes, one mesh a step.
struct StepsRequest {
  std::vector<std::string> inputs;  // as SeriesRequest's, but for steps that are arrays of one mesh
  std::string output;               // holds {step}, or is the name of a .pvd file
  Encoding encoding = Encoding::kRaw;
  OpenOptions open;                       // with its time_step that one alone
  std::vector<std::string> also_written;  // files that are no input either; "": none
};

// Throws like plan_series().
SeriesPlan plan_steps(const StepsRequest& request);

}  // namespace tetfusion
