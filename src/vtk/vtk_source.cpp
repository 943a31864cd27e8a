// The module's entry: a mesh that VTK has read, behind the interface of io/vtk_plugin.h.

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "io/formats/xml_text.h"
#include "io/source/cell_kinds.h"
#include "io/vtk_plugin.h"
#include "vtk/vtk_arrays.h"
#include "vtk/vtk_cells.h"
#include "vtk/vtk_load.h"
#include "vtk/vtk_pieces.h"
#include "vtk/vtk_trial.h"

namespace tetfusion {
namespace {

// What comes behind the path may be text of a damaged file.
PluginStatus failure(const std::string& path, const Error& error) {
  const std::string message = error.what();
  const std::size_t kept = message.starts_with(path) ? path.size() : 0;
  PluginStatus status;
  status.failed = true;
  status.code = error.code();
  status.message = message.substr(0, kept) + for_message(message.substr(kept));
  return status;
}

// Runs `work`; what it throws becomes a status, because no exception may leave the module.
template <class Work>
PluginStatus guarded(const std::string& path, Work&& work) noexcept {
  try {
    work();
    return {};
  } catch (const InvalidMesh& error) {
    PluginStatus status = failure(path, error);
    status.invalid_mesh = true;
    return status;
  } catch (...) {
    return failure(path, caught_error(path));
  }
}

class VtkMesh : public PluginMesh {
 public:
  VtkMesh(const std::string& path, const OpenOptions& options)
      : options_(options),
        file_(load_with_vtk(path, options)),
        pieces_(number_pieces(path, file_)) {
    points_ = collect_arrays(path, pieces_, Association::kPoint);
    cells_ = collect_arrays(path, pieces_, Association::kCell);
    fields_ = collect_field_data(file_.field_data);
    cell_types_ = count_types(file_);
    describe(path);
  }

  const MeshDescription& description() const noexcept override { return description_; }
  const CellTypeCounts& cell_types() const noexcept override { return cell_types_; }
  std::uint64_t bytes_of_cells() const noexcept override {
    return tetfusion::bytes_of_cells(file_);
  }

  PluginStatus read_geometry(Geometry* out) noexcept override {
    return guarded(description_.path, [&] {
      *out = convert_cells(description_.path, pieces_, options_, point_use());
      const PointUse& use = point_use();
      const CopyDifferences found = find_differences(pieces_, points_, use.copy_of, use.used);
      out->differing_points = found.points;
      out->largest_difference = found.largest;
    });
  }

  PluginStatus read_array(Association association, std::size_t index,
                          DataArray* out) noexcept override {
    return guarded(description_.path, [&] {
      const ArrayTable& t = table(association);
      if (association == Association::kPoint && some_piece_lacks(t, index)) {
        *out = read_values(pieces_, t, association, index, point_use().copy_of);
      } else {
        *out = read_values(pieces_, t, association, index);
      }
    });
  }

 private:
  void describe(const std::string& path) {
    description_.path = path;
    description_.format = file_.format;
    description_.files = file_.files;
    description_.left_out = file_.left_out;
    description_.time_steps = file_.time_steps;
    description_.time_step = file_.time_step;
    for (const ArrayTable* t : {&points_, &cells_, &fields_}) {
      description_.left_out.insert(description_.left_out.end(), t->left_out.begin(),
                                   t->left_out.end());
    }
    for (std::string& words : description_.left_out) words = for_message(words);
    description_.pieces = pieces_.pieces.size();
    description_.joins_points = description_.pieces > 1 || options_.merge_points;
    description_.points = pieces_.points;
    description_.cells = pieces_.cells;
    description_.point_type = pieces_.point_type;
    std::error_code ignored;
    description_.file_bytes = std::filesystem::file_size(path, ignored);
    description_.point_data = points_.set;
    description_.cell_data = cells_.set;
    unmark_global_ids(options_, &description_.cell_data);
    // Points in the middle of polyhedra have those of a corner.
    if (file_.tets_round_centres > 0) unmark_global_ids(options_, &description_.point_data);
    description_.field_data = fields_.set;
    for (AttributeSet* set :
         {&description_.point_data, &description_.cell_data, &description_.field_data}) {
      make_legible(set);
    }
  }

  const PointUse& point_use() {
    if (!use_) use_ = find_point_use(description_.path, pieces_, options_);
    return *use_;
  }

  const ArrayTable& table(Association association) const {
    switch (association) {
      case Association::kPoint:
        return points_;
      case Association::kCell:
        return cells_;
      case Association::kField:
        break;
    }
    return fields_;
  }

  OpenOptions options_;
  LoadedFile file_;
  PieceList pieces_;
  ArrayTable points_, cells_, fields_;
  std::optional<PointUse> use_;  // once it was asked for
  CellTypeCounts cell_types_;
  MeshDescription description_;
};

PluginStatus open_mesh_with_vtk(const std::string& path, const OpenOptions& options,
                                std::unique_ptr<PluginMesh>* out) noexcept {
  return guarded(path, [&] { *out = std::make_unique<VtkMesh>(path, options); });
}

PluginStatus time_steps_of_file(const std::string& path, const OpenOptions& options,
                                std::vector<double>* out) noexcept {
  return guarded(path, [&] { *out = load_time_steps(path, options); });
}

constexpr VtkPlugin kPlugin = {kVtkPluginInterface, TETFUSION_VERSION, open_mesh_with_vtk,
                               time_steps_of_file};

}  // namespace
}  // namespace tetfusion

extern "C" __attribute__((visibility("default"))) const tetfusion::VtkPlugin*
tetfusion_vtk_plugin() {
  return &tetfusion::kPlugin;
}
