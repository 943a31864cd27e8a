// Errors, gradients and integrals at the centres of the original's tetrahedra.
#include <array>
#include <cmath>

#include "compare/measure.h"
#include "mesh/blocks.h"
#include "mesh/predicates.h"

namespace tetfusion {

namespace {

// A tetrahedron as far as gradients need it.
struct Shape {
  double volume = 0;
  double error = 0;  // of the volume, by rounding, at most
  bool flat = true;  // no gradient
  // The gradient of a linear function is the sum of these times the differences of its values at
  // corners 1, 2, 3 from that at corner 0.
  std::array<Point, 3> slopes{};
};

Shape shape_of(const Corners& c) {
  const Determinant d = determinant(c[0], c[1], c[2], c[3]);
  Shape shape;
  shape.volume = std::abs(d.value) / 6;
  shape.error = d.error / 6;
  shape.flat = d.sign() == 0;
  if (shape.flat) return shape;
  const Point u = c[1] - c[0], v = c[2] - c[0], w = c[3] - c[0];
  const double scale = 1 / d.value;
  shape.slopes = {scale * cross(v, w), scale * cross(w, u), scale * cross(u, v)};
  return shape;
}

// Of a component of a field.
Point gradient(const Shape& shape, const CornerRows& rows, std::size_t c) {
  const double first = rows[0][c];
  return (rows[1][c] - first) * shape.slopes[0] + (rows[2][c] - first) * shape.slopes[1] +
         (rows[3][c] - first) * shape.slopes[2];
}

// One block of cells.
class Block {
 public:
  // `lengths`: of the point fields, at the window's points.
  Block(const Meshes& meshes, const OriginalCells& window, const Vector<double>& lengths,
        CellMeasures* out)
      : meshes_(meshes), window_(window), lengths_(lengths), out_(out) {}

  void measure(std::size_t cell, const Point& centre) {
    const Tet& t = window_.tets[cell];
    const auto& p = window_.points.points;
    shape_ = shape_of({p[t[0]], p[t[1]], p[t[2]], p[t[3]]});
    out_->volume.add(shape_.volume);
    out_->volume_error.add(shape_.error);
    centre_ = centre;
    place_ = meshes_.locator.locate(centre_, &hint_);
    if (place_.outside) ++out_->outside;
    if (place_.tet != shaped_) {
      shaped_ = place_.tet;
      other_ = shape_of(meshes_.simplified.corners(shaped_));
    }
    for (std::size_t f = 0; f < meshes_.point_fields.fields.size(); ++f) measure_points(t, f);
    for (std::size_t f = 0; f < meshes_.cell_fields.fields.size(); ++f) measure_cell(cell, f);
  }

 private:
  void measure_points(const Tet& t, std::size_t f) {
    const std::size_t fields = meshes_.point_fields.fields.size();
    const Field& field = meshes_.point_fields.fields[f];
    if (field.integer) return;
    double length = 0;
    for (const VertexId v : t) length += lengths_[v * fields + f];
    if (std::isnan(length)) {
      ++out_->errors[f].non_finite;
      return;
    }
    const std::size_t width = meshes_.point_fields.width;
    const SimplifiedMesh& mesh = meshes_.simplified;
    const CornerRows rows = corner_rows(window_.points.rows, width, t, field.offset);
    const CornerRows others =
        corner_rows(mesh.point_rows, width, mesh.tets[place_.tet], field.offset);
    double squared = 0;
    out_->integrals[f].add(shape_.volume / 4, length, [&](std::size_t c) {
      const double sum = (rows[0][c] + rows[1][c]) + (rows[2][c] + rows[3][c]);
      const double d = interpolate(others, place_.weights, c) - sum / 4;
      squared += d * d;
      return sum;
    });
    if (!std::isfinite(squared)) {
      ++out_->errors[f].undefined;
      return;
    }
    out_->errors[f].add(shape_.volume, squared, centre_);
    if (!shape_.flat && !other_.flat) measure_gradient(rows, others, f);
  }

  void measure_gradient(const CornerRows& rows, const CornerRows& others, std::size_t f) {
    double squares = 0, errors = 0;
    for (std::size_t c = 0; c < meshes_.point_fields.fields[f].info.components; ++c) {
      const Point g = gradient(shape_, rows, c);
      const Point e = gradient(other_, others, c) - g;
      squares += dot(g, g);
      errors += dot(e, e);
    }
    if (!std::isfinite(errors)) return;
    const double weight = std::min(shape_.volume, other_.volume);
    out_->gradient_squares[f].add(weight * squares);
    out_->gradient_errors[f].add(weight * errors);
  }

  void measure_cell(std::size_t cell, std::size_t f) {
    const Field& field = meshes_.cell_fields.fields[f];
    const std::size_t width = meshes_.cell_fields.width;
    Errors& errors = out_->cell_errors[f];
    const double* row = window_.cell_rows.data() + cell * width + field.offset;
    const double length = length_of(field, row);
    if (std::isnan(length)) {
      ++errors.non_finite;
      return;
    }
    out_->cell_values[f].add(row);
    out_->cell_integrals[f].add(shape_.volume, length, [&](std::size_t c) { return row[c]; });
    if (field.region) out_->cell_regions[f][*row].add(shape_.volume);
    const double* other = meshes_.simplified.cell_rows.data() + place_.tet * width + field.offset;
    const double squared = squared_difference(field, row, [&](std::size_t c) { return other[c]; });
    if (!std::isfinite(squared)) {
      ++errors.undefined;
      return;
    }
    errors.add(shape_.volume, squared, centre_);
    out_->cell_differences[f].add(shape_.volume * std::sqrt(squared));
  }

  const Meshes& meshes_;
  const OriginalCells& window_;
  const Vector<double>& lengths_;
  CellMeasures* out_;
  LocatorHint hint_;
  Shape shape_, other_;
  TetId shaped_ = kNoTet;  // the simplified mesh's tetrahedron that other_ is of
  Point centre_{};         // of the cell in hand
  Place place_{};
};

// Of cells [begin, end).
Vector<Point> centres_of(const OriginalCells& window, std::size_t begin, std::size_t end) {
  const Vector<Point>& p = window.points.points;
  Vector<Point> centres(end - begin);
  for (std::size_t i = 0; i < centres.size(); ++i) {
    const Tet& t = window.tets[begin + i];
    centres[i] = 0.25 * ((p[t[0]] + p[t[1]]) + (p[t[2]] + p[t[3]]));
  }
  return centres;
}

}  // namespace

CellMeasures measure_cells(const Meshes& meshes, const std::function<void(double)>& report) {
  const CellMeasures nothing(meshes.point_fields, meshes.cell_fields);
  CellMeasures sums = nothing;
  meshes.original.for_each_cells([&](const OriginalCells& window, double share) {
    const Vector<double> lengths = lengths_of(meshes.point_fields, window.points.rows);
    std::vector<CellMeasures> parts(block_count(window.tets.size(), kPlaces), nothing);
    for_each_block(window.tets.size(), kPlaces,
                   [&](std::size_t b, std::size_t begin, std::size_t end) {
                     Block block(meshes, window, lengths, &parts[b]);
                     const Vector<Point> centres = centres_of(window, begin, end);
                     for (const std::uint32_t i : curve_order(centres)) {
                       block.measure(begin + i, centres[i]);
                     }
                   });
    for (const CellMeasures& part : parts) sums.add(part);
    report(share);
  });
  return sums;
}

}  // namespace tetfusion
