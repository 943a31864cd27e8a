// Where a list of steps (.pvd, .series) stands in the place of a mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/findings.h"
#include "io/source/mesh_source.h"
#include "series/series_plan.h"

namespace tetfusion {

// A mesh to look at: a file, or a time step of one that has several itself.
struct StepToRead {
  std::string path;
  std::optional<double> time;
  std::optional<std::uint64_t> time_step;  // as in OpenOptions

  // The same options, for this step.
  OpenOptions options(OpenOptions open) const {
    open.time_step = time_step;
    return open;
  }
};

// All that a list names, or that a file has itself, if it has more than one, in the order of times;
// else the file, whose time_step nobody has chosen. With open.time_step the one that it says, where
// there are several to choose from: of a file's own as it counts them. Throws what
// read_series_list(), time_steps_of() and choose_time_step() throw.
std::vector<StepToRead> steps_to_read(const std::string& input, const OpenOptions& open);

// Does the file have several time steps of its own?
bool has_own_steps(const std::string& input, const OpenOptions& open);

// The path, and of a file's own step which one.
std::string name_of(const StepToRead& step);

// Where the output is one mesh, and a step of a list is chosen: the step's file takes the list's
// place, of which none is to be chosen then. Throws what steps_to_read() throws.
void take_chosen_step(std::vector<std::string>* inputs, const std::string& output,
                      std::optional<std::uint64_t>* time_step);

// The steps, where a mesh is to be made of each: the output holds {step} or is a .pvd, there are
// several inputs, or a list none of whose steps is chosen. Nothing where one mesh is wanted, after
// take_chosen_step(). Throws what plan_steps() throws.
std::optional<SeriesPlan> plan_if_series(StepsRequest* request);

// Else: that mesh.
Step only_mesh(const StepsRequest& request);

// All files that it reads and writes, for looking whether another one is among them.
std::vector<std::string> files_of(const SeriesPlan& plan);

// For a report: "path", and "time" if there is one.
Json step_json(const StepToRead& step);

}  // namespace tetfusion
