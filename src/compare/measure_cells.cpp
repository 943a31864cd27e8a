// Errors, gradients and integrals at the centres of the original's tetrahedra.
#include <array>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "base/blocks.h"
#include "compare/measure.h"
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

// Two components at a time. Every operation rounds as it does for one.
using Pair = double __attribute__((vector_size(2 * sizeof(double))));

// The last one may have no partner but a length, as what follows it in a row.
Pair pair_at(const double* row, std::size_t c) {
  Pair pair;
  std::memcpy(&pair, row + c, sizeof pair);
  return pair;
}

using Pairs = std::array<Pair, 4>;  // at the corners of a tetrahedron
Pairs pairs_at(const CornerRows& rows, std::size_t c) {
  return {pair_at(rows[0], c), pair_at(rows[1], c), pair_at(rows[2], c), pair_at(rows[3], c)};
}

std::array<Pair, 3> gradient(const Shape& shape, const Pairs& values) {
  const Pair u = values[1] - values[0], v = values[2] - values[0], w = values[3] - values[0];
  const auto& s = shape.slopes;
  return {u * s[0].x + v * s[1].x + w * s[2].x, u * s[0].y + v * s[1].y + w * s[2].y,
          u * s[0].z + v * s[1].z + w * s[2].z};
}

Pair squared_length(const std::array<Pair, 3>& a) {
  return a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
}

// Two compensated sums (CompensatedSum).
class PairSum {
 public:
  void add(Pair x) {
    const Pair t = sum_ + x;
    const Pair added = t - sum_;
    compensation_ += (sum_ - (t - added)) + (x - added);
    sum_ = t;
  }
  CompensatedSum operator[](std::size_t i) const { return {sum_[i], compensation_[i]}; }

 private:
  Pair sum_{}, compensation_{};
};

Point centre_of(const OriginalCells& window, const Tet& t) {
  const Vector<Point>& p = window.points.points;
  return 0.25 * ((p[t[0]] + p[t[1]]) + (p[t[2]] + p[t[3]]));
}

// What a cell needs lies apart from what the last one did: its corners' numbers, and then what they
// are the numbers of, are asked for so many cells earlier.
constexpr std::size_t kTetAhead = 8;
constexpr std::size_t kCellsAhead = 3;

// One block of cells.
class CellBlock {
 public:
  CellBlock(const Meshes& meshes, const OriginalCells& window, CellMeasures* out)
      : meshes_(meshes),
        window_(window),
        out_(out),
        components_((meshes.point_fields.components + 1) / 2),
        integrals_((meshes.point_fields.width + 1) / 2) {}

  void measure(std::size_t cell) {
    const Tet& t = window_.tets[cell];
    const auto& p = window_.points.points;
    shape_ = shape_of({p[t[0]], p[t[1]], p[t[2]], p[t[3]]});
    volumes_.add(Pair{shape_.volume, shape_.error});
    centre_ = centre_of(window_, t);
    place_ = meshes_.locator.locate(centre_, &hint_, window_.points.part_of(t[0]));
    if (place_.outside) ++out_->outside;
    if (place_.tet != shaped_) {
      shaped_ = place_.tet;
      other_ = shape_of(meshes_.simplified.corners(shaped_));
    }
    const CornerRows rows = corner_rows(window_.points.rows, meshes_.point_fields.width, t);
    compare_components(rows);
    integrate(rows);
    for (std::size_t f = 0; f < meshes_.point_fields.fields.size(); ++f) measure_points(rows, f);
    for (std::size_t f = 0; f < meshes_.cell_fields.fields.size(); ++f) measure_cell(cell, f);
  }

  // After all cells of the block.
  void finish() {
    out_->volume.add(volumes_[0]);
    out_->volume_error.add(volumes_[1]);
    const auto sum_of = [&](std::size_t column) { return integrals_[column / 2][column % 2]; };
    for (std::size_t f = 0; f < meshes_.point_fields.fields.size(); ++f) {
      const Field& field = meshes_.point_fields.fields[f];
      if (field.integer) continue;
      Integral& integral = out_->integrals[f];
      for (std::size_t c = 0; c < field.info.components; ++c) {
        integral.components[c].add(sum_of(field.offset + c));
      }
      integral.length.add(sum_of(field.length));
    }
  }

  void prefetch(std::size_t cell) const {
    const std::size_t width = meshes_.point_fields.width;
    for (const VertexId v : window_.tets[cell]) {
      __builtin_prefetch(&window_.points.points[v]);
      __builtin_prefetch(window_.points.rows.data() + v * width);
    }
  }

 private:
  // Of two components of the arrays of points.
  struct Components {
    Pair sum;            // of the values at the corners
    Pair squared;        // of the difference in the centre
    Pair slope_squared;  // of the gradient
    Pair slope_error;    // of the difference from it, squared
  };

  // All components, whatever arrays they belong to.
  void compare_components(const CornerRows& rows) {
    const FieldSet& set = meshes_.point_fields;
    const SimplifiedMesh& mesh = meshes_.simplified;
    const CornerRows other_rows = corner_rows(mesh.point_rows, set.width, mesh.tets[place_.tet]);
    for (std::size_t c = 0; c < set.components; c += 2) {
      const Pairs values = pairs_at(rows, c);
      const Pairs others = pairs_at(other_rows, c);
      Pair interpolated{};
      for (std::size_t i = 0; i < 4; ++i) {  // a corner without weight has no influence
        if (place_.weights[i] > 0) interpolated += place_.weights[i] * others[i];
      }
      Components& to = components_[c / 2];
      to.sum = (values[0] + values[1]) + (values[2] + values[3]);
      const Pair difference = interpolated - 0.25 * to.sum;
      to.squared = difference * difference;
      const std::array<Pair, 3> slope = gradient(shape_, values);
      std::array<Pair, 3> error = gradient(other_, others);
      for (std::size_t i = 0; i < 3; ++i) error[i] -= slope[i];
      to.slope_squared = squared_length(slope);
      to.slope_error = squared_length(error);
    }
  }

  // All columns of the rows: components, and behind them lengths. A field of which a value is not
  // finite is left out.
  void integrate(const CornerRows& rows) {
    const FieldSet& set = meshes_.point_fields;
    const Pair weight = {shape_.volume / 4, shape_.volume / 4};
    double lengths = 0;
    for (std::size_t c = 0; c < set.width; c += 2) {
      Pair sum;
      if (c < set.components) {
        sum = components_[c / 2].sum;
      } else if (c + 1 < set.width) {
        const Pairs values = pairs_at(rows, c);
        sum = (values[0] + values[1]) + (values[2] + values[3]);
      } else {
        sum = Pair{(rows[0][c] + rows[1][c]) + (rows[2][c] + rows[3][c]), 0};
      }
      if (c + 1 >= set.components) lengths += sum[1];
      if (c >= set.components) lengths += sum[0];
      sums_[c / 2] = weight * sum;
    }
    if (std::isnan(lengths)) leave_out_what_is_not_finite(rows);
    for (std::size_t i = 0; i < integrals_.size(); ++i) integrals_[i].add(sums_[i]);
  }

  void leave_out_what_is_not_finite(const CornerRows& rows) {
    for (const Field& field : meshes_.point_fields.fields) {
      if (!std::isnan(lengths_at(rows, field))) continue;
      const auto clear = [&](std::size_t column) { sums_[column / 2][column % 2] = 0; };
      for (std::size_t c = 0; c < field.info.components; ++c) clear(field.offset + c);
      clear(field.length);
    }
  }

  // Adds up a field's components.
  double total(const Field& field, Pair Components::*what) const {
    double sum = 0;
    for (std::size_t c = field.offset; c < field.offset + field.info.components; ++c) {
      sum += (components_[c / 2].*what)[c % 2];
    }
    return sum;
  }

  void measure_points(const CornerRows& rows, std::size_t f) {
    const Field& field = meshes_.point_fields.fields[f];
    if (field.integer) return;
    if (std::isnan(lengths_at(rows, field))) {
      ++out_->errors[f].non_finite;
      return;
    }
    const double squared = total(field, &Components::squared);
    if (!std::isfinite(squared)) {
      out_->errors[f].add_undefined(centre_);
      return;
    }
    // A flat cell has no inside, and its centre is any other's.
    if (shape_.flat) return;
    out_->errors[f].add(shape_.volume, squared, centre_);
    if (other_.flat) return;
    const double error = total(field, &Components::slope_error);
    if (!std::isfinite(error)) return;
    const double weight = std::min(shape_.volume, other_.volume);
    out_->gradient_squares[f] += weight * total(field, &Components::slope_squared);
    out_->gradient_errors[f] += weight * error;
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
    if (field.region) add_to_region(f, *row);
    const double* other = meshes_.simplified.cell_rows.data() + place_.tet * width + field.offset;
    const double squared = squared_difference(field, row, [&](std::size_t c) { return other[c]; });
    if (!field.integer) {
      out_->cell_integrals[f].add(shape_.volume, length, [&](std::size_t c) { return row[c]; });
    }
    if (!std::isfinite(squared)) {
      errors.add_undefined(centre_);
      return;
    }
    if (shape_.flat) return;
    errors.add(shape_.volume, squared, centre_);
    if (!field.integer) out_->cell_differences[f].add(shape_.volume * std::sqrt(squared));
  }

  void add_to_region(std::size_t f, double value) {
    RegionVolumes& regions = out_->cell_regions[f];
    if (regions.size() > out_->region_limits[f]) return;
    if (region_.first != &regions || region_.second->first != value) {
      region_ = {&regions, regions.try_emplace(value).first};
    }
    region_.second->second.add(shape_.volume);
  }

  const Meshes& meshes_;
  const OriginalCells& window_;
  CellMeasures* out_;
  std::vector<Components> components_;
  std::vector<PairSum> integrals_;             // of columns
  std::vector<Pair> sums_{integrals_.size()};  // of the cell in hand
  PairSum volumes_;                            // and their errors
  LocatorHint hint_;
  Shape shape_, other_;
  TetId shaped_ = kNoTet;  // the simplified mesh's tetrahedron that other_ is of
  Point centre_{};         // of the cell in hand
  // The region that was met last.
  std::pair<const RegionVolumes*, RegionVolumes::iterator> region_{};
  Place place_{};
};

}  // namespace

CellMeasures measure_cells(const Meshes& meshes, const std::function<void(double)>& report) {
  const CellMeasures nothing(meshes.point_fields, meshes.cell_fields);
  CellMeasures sums = nothing;
  meshes.original.for_each_cells([&](const OriginalCells& window, double share) {
    std::vector<CellMeasures> parts(block_count(window.tets.size(), kPlaces), nothing);
    const Vector<std::uint32_t> order =
        curve_order(window.tets.size(), box_of(window.points.points),
                    [&](std::size_t cell) { return centre_of(window, window.tets[cell]); });
    for_each_block(order.size(), kPlaces, [&](std::size_t b, std::size_t begin, std::size_t end) {
      CellBlock block(meshes, window, &parts[b]);
      for (std::size_t k = begin; k < end; ++k) {
        if (k + kTetAhead < end) __builtin_prefetch(&window.tets[order[k + kTetAhead]]);
        if (k + kCellsAhead < end) block.prefetch(order[k + kCellsAhead]);
        block.measure(order[k]);
      }
      block.finish();
    });
    for (const CellMeasures& part : parts) sums.add(part);
    report(share);
  });
  return sums;
}

}  // namespace tetfusion
