// Errors at the points of the original.
#include <limits>

#include "base/blocks.h"
#include "compare/measure.h"

namespace tetfusion {

namespace {

// What a point needs lies apart from what the last one did: it is asked for so many points earlier.
constexpr std::size_t kPointsAhead = 4;

// One block of points.
class PointBlock {
 public:
  PointBlock(const Meshes& meshes, PointMeasures* out) : meshes_(meshes), out_(out) {}

  void measure(const Point& p, std::uint32_t part, const double* row) {
    out_->box.add(p);
    vertices_.clear();
    meshes_.locator.for_each_vertex_at(p, part, [&](VertexId v) {
      // A crack's junction has a few. Where a mesh has collapsed, all would take forever.
      constexpr std::size_t kMost = 256;
      if (vertices_.size() < kMost) vertices_.push_back(v);
    });
    if (vertices_.empty()) {
      place_ = meshes_.locator.locate(p, &hint_, part);
      if (place_.outside) {
        ++out_->outside;
        out_->farthest = std::max(out_->farthest, place_.distance);
      }
    }
    const auto& fields = meshes_.point_fields.fields;
    for (std::size_t f = 0; f < fields.size(); ++f) {
      measure_field(fields[f], row, p, f);
    }
  }

 private:
  void measure_field(const Field& field, const double* row, const Point& p, std::size_t f) {
    Errors& errors = out_->errors[f];
    if (std::isnan(row[field.length])) {
      ++errors.non_finite;
      return;
    }
    const double* values = row + field.offset;
    out_->values[f].add(values);
    const double squared = least_difference(field, values);
    if (std::isfinite(squared)) {
      errors.add(1, squared, p);
    } else {
      errors.add_undefined(p);
    }
  }

  // Of several points in one place, as on the two sides of a crack, the most similar one counts.
  double least_difference(const Field& field, const double* values) const {
    const SimplifiedMesh& mesh = meshes_.simplified;
    const std::size_t width = meshes_.point_fields.width;
    const auto at_vertex = [&](VertexId v) {
      const double* others = mesh.point_rows.data() + v * width + field.offset;
      return squared_difference(field, values, [&](std::size_t c) { return others[c]; });
    };
    if (vertices_.empty()) {
      if (field.integer) return at_vertex(nearest_corner(mesh, place_));
      const CornerRows rows = corner_rows(mesh.point_rows, width, mesh.tets[place_.tet]);
      return squared_difference(field, values, [&](std::size_t c) {
        return interpolate(rows, place_.weights, field.offset + c);
      });
    }
    double least = std::numeric_limits<double>::infinity();
    for (const VertexId v : vertices_) {
      const double squared = at_vertex(v);
      if (squared < least) least = squared;
    }
    return least;
  }

  const Meshes& meshes_;
  PointMeasures* out_;
  LocatorHint hint_;
  std::vector<VertexId> vertices_;
  Place place_{};
};

}  // namespace

PointMeasures measure_points(const Meshes& meshes, const std::function<void(double)>& report) {
  const std::size_t width = meshes.point_fields.width;
  const PointMeasures nothing(meshes.point_fields);
  PointMeasures sums = nothing;
  meshes.original.for_each_points([&](const OriginalPoints& window, double share) {
    std::vector<PointMeasures> parts(block_count(window.points.size(), kPlaces), nothing);
    const Vector<std::uint32_t> order = curve_order(window.points);
    for_each_block(order.size(), kPlaces, [&](std::size_t b, std::size_t begin, std::size_t end) {
      PointBlock block(meshes, &parts[b]);
      for (std::size_t k = begin; k < end; ++k) {
        if (k + kPointsAhead < end) {
          __builtin_prefetch(&window.points[order[k + kPointsAhead]]);
          __builtin_prefetch(window.rows.data() + order[k + kPointsAhead] * width);
        }
        block.measure(window.points[order[k]], window.part_of(order[k]),
                      window.rows.data() + order[k] * width);
      }
    });
    for (const PointMeasures& part : parts) sums.add(part);
    report(share);
  });
  return sums;
}

}  // namespace tetfusion
