#include "series/step_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "base/tasks.h"
#include "driver/convert.h"
#include "follow/apply_map.h"
#include "mesh/array_names.h"
#include "mesh/time_value.h"
#include "series/each_step.h"
#include "series/run_part.h"

namespace tetfusion {

namespace {

// So much of the run is done when writing begins, and so much is left.
constexpr double kBefore = 0.7, kWriting = 0.3;

// Where the values of an array of points were put aside.
struct Fitted {
  std::size_t step, array;
};
using PlaceOf = std::function<std::optional<Fitted>(const std::string& name)>;

std::optional<std::size_t> find_fitted(const SeriesResult& result, const std::string& name) {
  for (std::size_t a = 0; a < result.arrays.size(); ++a) {
    if (result.arrays[a].name == name) return a;
  }
  return std::nullopt;
}

bool is_written(const ArrayInfo& array) { return !array.steers_only && !is_ghost_mark(array.name); }

// The arrays of points, as they were fitted where place_of() says so, and the field data.
StepArrays moved_arrays(const SeriesResult& result, MeshSource* source, const PlaceOf& place_of,
                        const RunContext& context) {
  const AttributeSet& all = source->description().point_data;
  RunContext quiet = context;
  quiet.progress = {};
  StepArrays arrays;
  for (const ArrayInfo& info : all.arrays) {
    if (!is_written(info)) continue;
    if (const std::optional<Fitted> place = place_of(info.name)) {
      arrays.points.push_back(result.fitted->read(place->step, place->array, info));
      continue;
    }
    const bool is_to_fit = is_float(info.type) && result.fitted != nullptr;
    auto moved = is_to_fit ? result.fitted->fit({info.name}, source, quiet)
                           : apply_map(result.map, source, {info.name}, quiet, false);
    arrays.points.push_back(std::move(moved[0].array));
  }
  arrays.field_data = source->read_field_data();
  return arrays;
}

// With the arrays of cells.
void write_mesh(const SeriesResult& result, StepArrays arrays, MeshSource* source,
                const std::string& path, const RunContext& context) {
  RunContext quiet = context;
  quiet.progress = {};
  arrays.cells = result.mesh.cell_arrays(source, quiet);
  const auto out = result.mesh.with(std::move(arrays), source->description());
  WriteOptions write;
  write.encoding = result.encoding;
  write.label = result.label;
  write.report_to(context);
  convert_mesh(out.get(), path, write);
}

void write_step(const SeriesResult& result, const StepFiles& files, std::size_t i,
                const RunContext& context, Step* step) {
  const auto source = files.open(i);
  const auto place_of = [&](const std::string& name) {
    const auto a = find_fitted(result, name);
    return a ? std::optional<Fitted>({i, *a}) : std::nullopt;
  };
  StepArrays arrays = moved_arrays(result, source.get(), place_of, context);
  for (const DataArray& array : arrays.field_data) {
    if (!step->time) step->time = time_of(array);
  }
  write_mesh(result, std::move(arrays), source.get(), step->output, context);
}

}  // namespace

void write_steps(const SeriesResult& result, const StepFiles& files, int at_once,
                 const RunContext& context, SeriesPlan* plan) {
  std::vector<Step>& steps = plan->steps;
  std::vector<std::uint8_t> written(steps.size(), 0);
  std::once_flag first;
  const auto share = [&](std::size_t i) {
    return kBefore + kWriting * static_cast<double>(i) / static_cast<double>(steps.size());
  };
  try {
    run_tasks_with_loops(steps.size(), at_once, [&](std::size_t i) {
      write_step(result, files, i, part_of_run(context, share(i), share(i + 1)), &steps[i]);
      written[i] = 1;
      std::call_once(first, [&] { drop_old_list(*plan); });
    });
  } catch (const Error& error) {
    const auto last = std::find(written.rbegin(), written.rend(), 1);
    const auto place = static_cast<std::size_t>(written.rend() - last);
    throw Error(error.code(),
                fmt::format("{}; steps written: {} of {}{}", error.what(),
                            std::count(written.begin(), written.end(), 1), written.size(),
                            place == 0 ? "" : ", the last is " + steps[place - 1].output));
  }
}

void write_in_one_mesh(const SeriesResult& result, const StepFiles& files, const std::string& path,
                       const RunContext& context) {
  const auto source = files.open_whole(0);
  const auto place_of = [&](const std::string& name) {
    std::optional<Fitted> place;
    for (std::size_t i = 0; i < files.count() && !place; ++i) {
      const auto pattern = pattern_of(files[i], name);
      const auto a = pattern ? find_fitted(result, *pattern) : std::nullopt;
      if (a) place = {i, *a};
    }
    return place;
  };
  StepArrays arrays = moved_arrays(result, source.get(), place_of, context);
  write_mesh(result, std::move(arrays), source.get(), path, part_of_run(context, kBefore, 1));
}

}  // namespace tetfusion
