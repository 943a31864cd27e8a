#include "series/point_means.h"

#include <cstring>
#include <mutex>
#include <optional>
#include <utility>

#include "driver/arrays/steering.h"
#include "io/source/mesh_stream.h"
#include "series/other_arrays.h"

namespace tetfusion {

namespace {

// NAME, or NAME:0.5%.
std::optional<SteeringChoice> find_with_share(const MeshDescription& mesh,
                                              const std::string& text) {
  if (auto choice = find_array(mesh, text)) return choice;
  return find_array(mesh, text.substr(0, text.rfind(':')));
}

// `mesh` outlives it.
ArrayFrom means_of(const SteeringChoice& array, MeshSource* mesh,
                   const std::atomic<bool>* cancelled) {
  struct Means {
    std::once_flag once;
    Vector<double> values;
  };
  const ArrayInfo& of_cells = mesh->description().cell_data.arrays[array.index];
  ArrayInfo info{array.name, ValueType::kFloat64, of_cells.components, {}, {}};
  info.tuples = mesh->description().points;
  info.steers_only = true;
  const auto means = std::make_shared<Means>();
  return {info, [means, mesh, cancelled, index = array.index, width = of_cells.components](
                    const MeshStream&, std::uint64_t first, std::span<std::byte> out) {
            // Not with the stream that is given: that may be one to rows alone.
            std::call_once(means->once, [&] {
              RunContext context;
              context.cancelled = cancelled;
              means->values =
                  means_at_points(index, mesh->description(), *open_stream(mesh), context);
            });
            std::memcpy(out.data(), means->values.data() + first * width, out.size());
          }};
}

}  // namespace

std::unique_ptr<MeshSource> with_point_means(std::unique_ptr<MeshSource> mesh,
                                             const std::vector<std::string>& arrays,
                                             const std::atomic<bool>* cancelled) {
  const MeshDescription& description = mesh->description();
  OtherArrays all;
  for (const std::string& text : arrays) {
    const auto choice = find_with_share(description, text);
    if (choice && choice->association == Association::kCell) {
      all.points.push_back(means_of(*choice, mesh.get(), cancelled));
    }
  }
  if (all.points.empty()) return mesh;
  std::vector<ArrayFrom> own;
  for (std::size_t i = 0; i < description.point_data.arrays.size(); ++i) {
    own.push_back(own_array(description, Association::kPoint, i));
  }
  all.points.insert(all.points.begin(), own.begin(), own.end());
  for (std::size_t i = 0; i < description.cell_data.arrays.size(); ++i) {
    all.cells.push_back(own_array(description, Association::kCell, i));
  }
  all.point_markers = description.point_data.active;
  all.cell_markers = description.cell_data.active;
  all.field_data = mesh->read_field_data();
  return with_arrays(std::move(mesh), std::move(all));
}

}  // namespace tetfusion
