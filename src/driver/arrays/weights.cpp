#include "driver/arrays/weights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "base/error.h"
#include "driver/arrays/steering.h"
#include "io/source/stream_windows.h"
#include "mesh/array_names.h"

namespace tetfusion {

namespace {

SteeringChoice choose_weights(const std::string& name, const MeshDescription& mesh) {
  const auto choice = find_own_array(mesh, name);
  const auto is_scalar = [&](const AttributeSet& set) {
    const ArrayInfo& info = set.arrays[choice->index];
    return info.components == 1 && info.type != ValueType::kString;
  };
  if (choice &&
      is_scalar(choice->association == Association::kCell ? mesh.cell_data : mesh.point_data)) {
    return *choice;
  }
  throw Error(ErrorCode::kUsage,
              fmt::format("{}: --weight {}: there is no array of one component with that name; "
                          "point arrays: {}; cell arrays (name them cell:NAME): {}",
                          mesh.path, name, names_of(mesh.point_data), names_of(mesh.cell_data)));
}

}  // namespace

WeightColumn weight_column(const std::string& name, const MeshDescription& mesh,
                           const CarriedArrays& carried) {
  if (name.empty()) return {};
  const SteeringChoice choice = choose_weights(name, mesh);
  const auto column = carried.column_of(choice.association, choice.index);
  if (!column) {
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: --weight {}: that marks ghosts, and says nothing of errors",
                            mesh.path, name));
  }
  return {*column, choice.association == Association::kCell};
}

WeightScale scale_weights(const std::string& name, const MeshDescription& mesh,
                          const MeshStream& stream, const RunContext& context) {
  WeightScale out;
  if (name.empty()) return out;
  const SteeringChoice choice = choose_weights(name, mesh);
  const bool of_cells = choice.association == Association::kCell;
  const ArrayInfo& info = (of_cells ? mesh.cell_data : mesh.point_data).arrays[choice.index];
  double largest = 0;
  double least = std::numeric_limits<double>::infinity();
  const auto look = [&](std::uint64_t first, std::span<const std::byte> rows) {
    const Vector<double> values = to_doubles(info.type, rows);
    const auto wrong = std::find_if(values.begin(), values.end(), [](double value) {
      return !(value >= 0 && value <= std::numeric_limits<float>::max());
    });
    if (wrong != values.end()) {
      throw Error(ErrorCode::kBadInput,
                  fmt::format("{}: --weight {}: {} {} has the value {}; weights are numbers from 0 "
                              "to 3.4e38",
                              mesh.path, name, of_cells ? "cell" : "point",
                              first + static_cast<std::uint64_t>(wrong - values.begin()), *wrong));
    }
    for (const double value : values) {
      largest = std::max(largest, value);
      least = std::min(least, value);
    }
  };
  for_each_window_of(stream, choice.association, choice.index, info, context, look);
  if (least == largest) {
    context.say(fmt::format("--weight {} is {} everywhere: all places count alike", name, least));
  }
  if (!(largest > 0)) return out;
  // Of smaller ones the inverse would be infinite.
  out.scale = 1 / std::max(largest, std::numeric_limits<double>::min());
  double sum = 0, count = 0;
  const auto add = [&](std::uint64_t, std::span<const std::byte> rows) {
    for (const double value : to_doubles(info.type, rows)) {
      sum += std::log2(std::max(value * out.scale, double{WeightColumn::kLeast}));
      ++count;
    }
  };
  for_each_window_of(stream, choice.association, choice.index, info, context, add);
  out.mean = std::exp2(sum / count);
  return out;
}

}  // namespace tetfusion
