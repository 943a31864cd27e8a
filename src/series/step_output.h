// The outputs of a shared series: its mesh, with the arrays of each step.
#pragma once

#include <string>
#include <vector>

#include "base/run_context.h"
#include "driver/arrays/steering.h"
#include "io/mesh_format.h"
#include "io/progressive/map_file.h"
#include "io/write_mesh.h"
#include "series/fitted_steps.h"
#include "series/result_mesh.h"
#include "series/series_plan.h"
#include "series/step_source.h"

namespace tetfusion {

// What all outputs are made of; all of it outlives whoever writes them.
struct SeriesResult {
  const ResultMesh& mesh;
  const MapFile& map;                         // where points of the steps went
  const std::vector<SteeringChoice>& arrays;  // that were fitted
  const FittedSteps* fitted = nullptr;        // null where there are none
  Encoding encoding = Encoding::kRaw;
  std::string label = {};  // WriteOptions::label
};

// Writes the output of each step of the plan, so many at once: arrays that steered as they were
// fitted, other ones of points by the map, those of cells likewise. Sets the times of steps
// that say theirs. Reports progress as the last three tenths of the run. Throws Error, which says
// how many are written, and the last of them.
void write_steps(const SeriesResult& result, const StepFiles& files, int at_once,
                 const RunContext& context, SeriesPlan* plan);

// The same of steps that are arrays of one mesh: all in one file, in the order that they have
// there.
void write_in_one_mesh(const SeriesResult& result, const StepFiles& files, const std::string& path,
                       const RunContext& context);

}  // namespace tetfusion
