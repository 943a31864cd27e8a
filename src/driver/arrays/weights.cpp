#include "driver/arrays/weights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "base/error.h"
#include "driver/arrays/rows_in_use.h"
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
  const BitSet in_use = find_rows_in_use(stream, choice.association, context);
  const auto for_each_weight = [&](auto use) {
    const auto look = [&](std::uint64_t first, std::span<const std::byte> rows) {
      const Vector<double> values = to_doubles(info.type, rows);
      for (std::size_t i = 0; i < values.size(); ++i) {
        if (in_use.has(first + i)) use(first + i, values[i]);
      }
    };
    for_each_window_of(stream, choice.association, choice.index, info, context, look);
  };
  for_each_weight([&](std::uint64_t row, double value) {
    if (!(value >= 0 && value <= std::numeric_limits<float>::max())) {
      throw Error(ErrorCode::kBadInput,
                  fmt::format("{}: --weight {}: {} {} has the value {}; weights are numbers from 0 "
                              "to 3.4e38",
                              mesh.path, name, of_cells ? "cell" : "point", row, value));
    }
    largest = std::max(largest, value);
    least = std::min(least, value);
  });
  if (least == largest) {
    context.say(fmt::format("--weight {} is {} everywhere: all places count alike", name, least));
  }
  if (!(largest > 0)) return out;
  // Of smaller ones the inverse would be infinite.
  out.scale = 1 / std::max(largest, std::numeric_limits<double>::min());
  double sum = 0, count = 0;
  for_each_weight([&](std::uint64_t, double value) {
    sum += std::log2(std::max(value * out.scale, double{WeightColumn::kLeast}));
    ++count;
  });
  out.mean = std::exp2(sum / count);
  return out;
}

}  // namespace tetfusion
