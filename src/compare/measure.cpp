#include "compare/measure.h"

#include <algorithm>
#include <cmath>

#include "base/blocks.h"
#include "mesh/predicates.h"

namespace tetfusion {

namespace {

constexpr std::size_t kTetsPerPart = 8192;

template <class T>
void add_all(std::vector<T>* sums, const std::vector<T>& others) {
  for (std::size_t i = 0; i < sums->size(); ++i) (*sums)[i].add(others[i]);
}
void add_all(std::vector<double>* sums, const std::vector<double>& others) {
  for (std::size_t i = 0; i < sums->size(); ++i) (*sums)[i] += others[i];
}

Integral empty_integral(const Field& field) {
  return {std::vector<CompensatedSum>(field.info.components), {}};
}

FieldValues no_values(const Field& field) { return {std::vector<Range>(field.info.components), 0}; }

}  // namespace

void Errors::add(const Errors& other) {
  squares += other.squares;
  weights += other.weights;
  differing += other.differing;
  if (other.max_squared > max_squared) {
    max_squared = other.max_squared;
    max_at = other.max_at;
  }
  non_finite += other.non_finite;
  if (undefined == 0) undefined_at = other.undefined_at;
  undefined += other.undefined;
}

double Errors::rms() const { return weights > 0 ? std::sqrt(squares / weights) : 0; }

double Errors::max() const { return std::sqrt(max_squared); }

void Integral::add(const Integral& other) {
  add_all(&components, other.components);
  length.add(other.length);
}

void FieldValues::add(const double* row) {
  for (std::size_t c = 0; c < ranges.size(); ++c) {
    ranges[c].add(row[c]);
    largest = std::max(largest, std::abs(row[c]));
  }
}

void FieldValues::add(const FieldValues& other) {
  add_all(&ranges, other.ranges);
  largest = std::max(largest, other.largest);
}

double FieldValues::diagonal() const {
  double widest = 0;
  for (const Range& range : ranges) widest = std::max(widest, range.width());
  const int exponent = exponent_for(widest);
  double squared = 0;
  for (const Range& range : ranges) {
    const double width = std::ldexp(range.width(), exponent);
    squared += width * width;
  }
  return std::ldexp(std::sqrt(squared), -exponent);
}

PointMeasures::PointMeasures(const FieldSet& fields) : errors(fields.fields.size()) {
  for (const Field& field : fields.fields) values.push_back(no_values(field));
}

void PointMeasures::add(const PointMeasures& other) {
  add_all(&errors, other.errors);
  add_all(&values, other.values);
  outside += other.outside;
  farthest = std::max(farthest, other.farthest);
  box.add(other.box);
}

CellMeasures::CellMeasures(const FieldSet& point_fields, const FieldSet& cell_fields)
    : errors(point_fields.fields.size()),
      gradient_squares(point_fields.fields.size()),
      gradient_errors(point_fields.fields.size()),
      cell_errors(cell_fields.fields.size()),
      cell_differences(cell_fields.fields.size()),
      cell_regions(cell_fields.fields.size()) {
  for (const Field& field : point_fields.fields) integrals.push_back(empty_integral(field));
  for (const Field& field : cell_fields.fields) {
    cell_values.push_back(no_values(field));
    region_limits.push_back(most_regions(field));
    cell_integrals.push_back(empty_integral(field));
  }
}

void CellMeasures::add(const CellMeasures& other) {
  volume.add(other.volume);
  volume_error.add(other.volume_error);
  outside += other.outside;
  add_all(&errors, other.errors);
  add_all(&integrals, other.integrals);
  add_all(&gradient_squares, other.gradient_squares);
  add_all(&gradient_errors, other.gradient_errors);
  add_all(&cell_errors, other.cell_errors);
  add_all(&cell_values, other.cell_values);
  add_all(&cell_integrals, other.cell_integrals);
  add_all(&cell_differences, other.cell_differences);
  for (std::size_t f = 0; f < cell_regions.size(); ++f) {
    for (const auto& [value, sum] : other.cell_regions[f]) {
      if (cell_regions[f].size() > region_limits[f]) break;
      cell_regions[f][value].add(sum);
    }
  }
}

Vector<std::uint32_t> curve_order(std::span<const Point> points) {
  return curve_order(points.size(), box_of(points), [&](std::size_t i) { return points[i]; });
}

VertexId nearest_corner(const SimplifiedMesh& mesh, const Place& place) {
  const auto& w = place.weights;
  return mesh
      .tets[place.tet][static_cast<std::size_t>(std::max_element(w.begin(), w.end()) - w.begin())];
}

namespace {

double volume_of(const SimplifiedMesh& mesh, TetId t) {
  return std::abs(determinant(mesh.points, mesh.tets[t]).value) / 6;
}

// add(tet, volume, integrals) for all tetrahedra, block by block.
template <class F>
std::vector<Integral> integrate(const SimplifiedMesh& mesh, const FieldSet& fields, F add) {
  std::vector<Integral> empty;
  for (const Field& field : fields.fields) empty.push_back(empty_integral(field));
  std::vector<std::vector<Integral>> parts(block_count(mesh.tets.size(), kTetsPerPart), empty);
  for_each_block(mesh.tets.size(), kTetsPerPart,
                 [&](std::size_t b, std::size_t begin, std::size_t end) {
                   for (std::size_t t = begin; t < end; ++t) {
                     add(static_cast<TetId>(t), volume_of(mesh, static_cast<TetId>(t)), &parts[b]);
                   }
                 });
  std::vector<Integral> sums = empty;
  for (const auto& part : parts) add_all(&sums, part);
  return sums;
}

}  // namespace

std::vector<Integral> integrate_points(const SimplifiedMesh& mesh, const FieldSet& fields) {
  return integrate(mesh, fields, [&](TetId t, double volume, std::vector<Integral>* sums) {
    const CornerRows rows = corner_rows(mesh.point_rows, fields.width, mesh.tets[t]);
    for (std::size_t f = 0; f < fields.fields.size(); ++f) {
      const Field& field = fields.fields[f];
      const double length = lengths_at(rows, field);
      if (field.integer || std::isnan(length)) continue;
      (*sums)[f].add(volume / 4, length, [&](std::size_t i) {
        const std::size_t c = field.offset + i;
        return (rows[0][c] + rows[1][c]) + (rows[2][c] + rows[3][c]);
      });
    }
  });
}

std::vector<Integral> integrate_cells(const SimplifiedMesh& mesh, const FieldSet& fields) {
  return integrate(mesh, fields, [&](TetId t, double volume, std::vector<Integral>* sums) {
    for (std::size_t f = 0; f < fields.fields.size(); ++f) {
      const Field& field = fields.fields[f];
      if (field.integer) continue;
      const double* row = mesh.cell_rows.data() + std::size_t{t} * fields.width + field.offset;
      const double length = length_of(field, row);
      if (std::isnan(length)) continue;
      (*sums)[f].add(volume, length, [&](std::size_t c) { return row[c]; });
    }
  });
}

RegionVolumes measure_regions(const SimplifiedMesh& mesh, const FieldSet& fields,
                              const Field& field) {
  RegionVolumes volumes;
  auto last = volumes.end();
  for (TetId t = 0; t < mesh.tets.size() && !has_too_many(field, volumes); ++t) {
    const double region = mesh.cell_rows[t * fields.width + field.offset];
    if (!std::isfinite(region)) continue;
    if (last == volumes.end() || last->first != region) last = volumes.try_emplace(region).first;
    last->second.add(volume_of(mesh, t));
  }
  return volumes;
}

}  // namespace tetfusion
