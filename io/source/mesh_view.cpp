#include "io/source/mesh_view.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <set>
#include <stdexcept>
#include <utility>
#include <variant>

#include "base/error.h"
#include "base/numbers.h"
#include "io/source/cell_kinds.h"
#include "io/source/merge_pieces.h"
#include "io/source/view_cells.h"
#include "io/source/view_stream.h"

namespace tetfusion {

namespace {

AttributeSet describe(const std::vector<ArrayView>& arrays) {
  AttributeSet set;
  for (const ArrayView& a : arrays) {
    set.arrays.push_back({a.name, a.values.type, a.components, a.component_names, 0});
    set.arrays.back().units = a.units;
    set.arrays.back().tuples = a.components > 0 ? a.values.size() / a.components : 0;
  }
  return set;
}

class ViewChecks {
 public:
  explicit ViewChecks(const MeshView& view) : view_(view) {}

  void run() const {
    if (!is_float(view_.points.type)) fail("the coordinates must be Float32 or Float64");
    if (view_.points.size() % 3 != 0) {
      fail(fmt::format("the points have {}, which is no multiple of three",
                       format_count(view_.points.size(), "coordinate")));
    }
    if (!is_id(view_.connectivity)) fail("the connectivity must be Int32 or Int64");
    if (view_.tets_only) {
      if (view_.connectivity.size() % 4 != 0) {
        fail(fmt::format("the connectivity has {}, which is no multiple of four",
                         format_count(view_.connectivity.size(), "number")));
      }
    } else {
      check_offsets();
    }
    if (!view_.ghosts.empty() && view_.ghosts.size() != view_.cells()) {
      fail(fmt::format("{} for {}", format_count(view_.ghosts.size(), "ghost flag"),
                       format_count(view_.cells(), "cell")));
    }
    check_arrays(view_.point_arrays, "point", view_.points.size() / 3);
    check_arrays(view_.cell_arrays, "cell", view_.cells());
  }

 private:
  static bool is_id(const ValuesView& values) {
    return values.type == ValueType::kInt32 || values.type == ValueType::kInt64;
  }

  void check_offsets() const {
    if (view_.offsets.type != view_.connectivity.type) {
      fail("the offsets must have the type of the connectivity");
    }
    if (view_.offsets.size() != view_.types.size() + 1) {
      fail(fmt::format("{} for {}, expected one more than cells",
                       format_count(view_.offsets.size(), "offset"),
                       format_count(view_.types.size(), "cell")));
    }
  }

  void check_arrays(const std::vector<ArrayView>& arrays, const char* kind,
                    std::uint64_t tuples) const {
    std::set<std::string> names;
    for (const ArrayView& a : arrays) {
      if (a.name.empty() && !view_.any_names) fail(fmt::format("a {} array has no name", kind));
      if (!names.insert(a.name).second && !view_.any_names) {
        fail(fmt::format("two {} arrays are called \"{}\"", kind, a.name));
      }
      if (a.components == 0) fail(fmt::format("{} array \"{}\" has no components", kind, a.name));
      if (a.values.size() != tuples * a.components) {
        fail(fmt::format("{} array \"{}\" has {}, expected {} with {} a {}", kind, a.name,
                         format_count(a.values.size(), "value"), tuples * a.components,
                         a.components, kind));
      }
    }
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kBadInput, view_.name + ": " + what);
  }

  const MeshView& view_;
};

class ViewSource final : public MeshSource {
 public:
  ViewSource(MeshView view, const OpenOptions& options)
      : view_(std::move(view)), options_(options) {
    ViewChecks(view_).run();
    description_.path = view_.name;
    description_.format = "a mesh in memory";
    description_.points = view_.points.size() / 3;
    description_.cells = view_.cells();
    description_.point_type = view_.points.type;
    description_.point_data = describe(view_.point_arrays);
    description_.point_data.active = view_.point_markers;
    description_.cell_data = describe(view_.cell_arrays);
    description_.cell_data.active = view_.cell_markers;
    for (const DataArray& array : view_.field_data) {
      description_.field_data.arrays.push_back(array.info);
    }
  }

  const MeshDescription& description() const override { return description_; }

  std::unique_ptr<MeshStream> stream() override {
    return open_view_stream(view_, description_, options_);
  }

  Geometry read_geometry() override {
    const ViewCells cells(view_, options_);
    Geometry mesh;
    if (description_.point_type == ValueType::kFloat32) {
      mesh.points = copy_points<float>();
    } else {
      mesh.points = copy_points<double>();
    }
    Vector<std::uint8_t> used;
    used.assign(description_.points, 0);
    cells.for_each_vertex(false, [&](VertexId v) { used[v] = 1; });
    check_finite(mesh.points, used);
    const Vector<VertexId> number = compact_points(used, {}, &mesh);
    take_cells(view_.name, cells.all(), number, &mesh);
    return mesh;
  }

  DataArray read_array(Association association, std::size_t index) override {
    const bool points = association == Association::kPoint;
    if (association == Association::kField) return view_.field_data.at(index);
    DataArray array;
    array.info = (points ? description_.point_data : description_.cell_data).arrays.at(index);
    const auto& bytes = (points ? view_.point_arrays : view_.cell_arrays)[index].values.bytes;
    array.bytes.assign(bytes.begin(), bytes.end());
    forget_ghosts(association, array.info, array.bytes);
    return array;
  }

 private:
  template <class Real>
  Vector<Vec3<Real>> copy_points() const {
    Vector<Vec3<Real>> points(description_.points);
    const std::span<const std::byte> from = view_.points.bytes;
    if (!from.empty()) std::memcpy(points.data(), from.data(), from.size());
    return points;
  }

  void check_finite(const Points& all, const Vector<std::uint8_t>& used) const {
    std::visit(
        [&](const auto& points) {
          for (std::size_t v = 0; v < points.size(); ++v) {
            const auto& p = points[v];
            const bool finite = std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
            if (finite || used[v] == 0) continue;
            throw InvalidMesh(view_.name + ": point " + std::to_string(v) +
                              " has a coordinate that is not finite");
          }
        },
        all);
  }

  MeshView view_;
  OpenOptions options_;
  MeshDescription description_;
};

}  // namespace

std::unique_ptr<MeshSource> open_view(MeshView view, const OpenOptions& options) {
  return std::make_unique<ViewSource>(std::move(view), options);
}

}  // namespace tetfusion
