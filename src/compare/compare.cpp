#include "compare/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "compare/locator.h"
#include "compare/measure.h"
#include "compare/original_mesh.h"
#include "compare/simplified_mesh.h"

namespace tetfusion {

namespace {

double share_of(double value, double whole) {
  if (value == 0) return 0;
  return whole > 0 ? value / whole : std::numeric_limits<double>::infinity();
}

double change_of(const Integral& original, const Integral& simplified) {
  double length = 0, signed_change = 0;
  for (std::size_t c = 0; c < original.components.size(); ++c) {
    signed_change = simplified.components[c].value() - original.components[c].value();
    length = std::hypot(length, signed_change);  // whose square may be too large
  }
  return original.components.size() == 1 ? signed_change : length;
}

double largest_in(const Field& field, std::size_t width, const Vector<double>& rows) {
  double largest = 0;
  for (std::size_t at = field.offset; at < rows.size(); at += width) {
    for (std::size_t c = at; c < at + field.info.components; ++c) {
      if (std::isfinite(rows[c])) largest = std::max(largest, std::abs(rows[c]));
    }
  }
  return largest;
}

// Sets the exponents that values of both meshes ask for, and multiplies those of the simplified one
// in `rows`. Whether there are any.
bool choose_exponents(const std::vector<FieldValues>& original, FieldSet* set,
                      Vector<double>* rows) {
  bool any = false;
  for (std::size_t f = 0; f < set->fields.size(); ++f) {
    Field& field = set->fields[f];
    if (field.integer) continue;
    field.exponent =
        exponent_for(std::max(original[f].largest, largest_in(field, set->width, *rows)));
    if (field.exponent == 0) continue;
    any = true;
    for (std::size_t at = field.offset; at < rows->size(); at += set->width) {
      for (std::size_t c = at; c < at + field.info.components; ++c) (*rows)[c] *= field.factor();
    }
  }
  return any;
}

double base_of(const Field& field) {
  return field.info.type == ValueType::kUInt64
             ? static_cast<double>(static_cast<std::uint64_t>(field.base))
             : static_cast<double>(field.base);
}

// What arrays of points and of cells have in common.
ArrayComparison summarize(const Field& field, const Errors& errors, const FieldValues& values,
                          double* scale) {
  ArrayComparison a;
  a.info = field.info;
  a.integer = field.integer;
  const double range = values.diagonal();
  a.range = std::ldexp(range, -field.exponent);
  for (const Range& r : values.ranges) {
    a.component_ranges.push_back(std::ldexp(r.width(), -field.exponent));
  }
  *scale = range > 0 ? range : values.largest + std::abs(base_of(field));
  a.non_finite = errors.non_finite;
  a.undefined = errors.undefined;
  a.undefined_at = errors.undefined_at;
  a.rms = share_of(errors.rms(), *scale);
  a.max = share_of(errors.max(), *scale);
  a.max_at = errors.max_at;
  a.differing = share_of(errors.differing, errors.weights);
  a.rounding = share_of(rounding_of(field.info.type) * values.largest, *scale);
  return a;
}

std::vector<RegionVolume> join_regions(const Field& field, const RegionVolumes& original,
                                       const RegionVolumes& simplified) {
  if (has_too_many(field, original) || has_too_many(field, simplified)) return {};
  std::map<double, RegionVolume> joined;
  for (const auto& [value, volume] : original) joined[value].original = volume.value();
  for (const auto& [value, volume] : simplified) joined[value].simplified = volume.value();
  std::vector<RegionVolume> regions;
  for (const auto& [value, volumes] : joined) {
    regions.push_back({base_of(field) + std::ldexp(value, -field.exponent), volumes.original,
                       volumes.simplified});
  }
  return regions;
}

class Comparer {
 public:
  Comparer(MeshSource* original, MeshSource* simplified, const RunContext& context,
           std::uint64_t sides)
      : context_(context),
        sides_(sides),
        match_(match_arrays(original->description(), simplified->description())),
        original_(original, match_.points, match_.cells),
        simplified_(simplified),
        point_type_(coarsest(original->description(), simplified->description())) {}

  Comparison run() {
    context_.report("reading", 0);
    original_.choose_bases(Association::kPoint, &match_.points);
    original_.choose_bases(Association::kCell, &match_.cells);
    const MeshStream& stream = original_.stream();
    result_.joined = {stream.merged_points(), stream.differing_points(),
                      stream.largest_difference()};
    SimplifiedMesh mesh = load_simplified(simplified_, match_.points, match_.cells);
    context_.check();
    context_.report("surface", 0.1);
    original_.survey(sides_within(sides_ != 0 ? sides_ : 4 * kSideBytes * mesh.tets.size()),
                     context_);
    original_.match_parts(mesh.parts, context_);
    context_.report_size(original_.tets());
    const SurfaceDistance surface = measure_surfaces(original_.boundary(), mesh.boundary);
    add_sizes(mesh);
    original_.take_boundary();
    context_.check();
    context_.report("index", 0.35);
    const Locator locator(&mesh, point_type_);
    const Meshes meshes{original_, mesh, locator, match_.points, match_.cells};
    PointMeasures points = measure_points(meshes, progress("points", 0.4, 0.55));
    if (choose_exponents(points.values, &match_.points, &mesh.point_rows)) {
      fill_lengths(match_.points, mesh.points.size(), mesh.point_rows.data());
      points = measure_points(meshes, progress("points", 0.4, 0.55));
    }
    CellMeasures cells = measure_cells(meshes, progress("cells", 0.55, 1));
    if (choose_exponents(cells.cell_values, &match_.cells, &mesh.cell_rows)) {
      cells = measure_cells(meshes, progress("cells", 0.55, 1));
    }
    volume_error_ = cells.volume_error.value() + mesh.volume_error;
    result_.diagonal = length(points.box.extent());
    result_.rounding = share_of(locator.rounding_in(points.box), result_.diagonal);
    add_surface(surface);
    add_domain(points, cells, mesh);
    add_point_arrays(points, cells, mesh);
    add_cell_arrays(cells, mesh);
    result_.missing_arrays = match_.missing;
    result_.lost_fields = match_.lost_fields;
    result_.lost_regions = match_.lost_regions;
    result_.retyped_arrays = match_.retyped;
    return result_;
  }

 private:
  static ValueType coarsest(const MeshDescription& a, const MeshDescription& b) {
    return a.point_type == ValueType::kFloat32 ? a.point_type : b.point_type;
  }

  std::function<void(double)> progress(std::string_view phase, double from, double to) const {
    return [this, phase, from, to](double share) {
      context_.check();
      context_.report(phase, from + (to - from) * share);
    };
  }

  void add_sizes(const SimplifiedMesh& mesh) {
    result_.original = {original_.points(), original_.tets(), original_.boundary().triangles.size(),
                        0, topology_of(original_.boundary())};
    result_.simplified = {mesh.points.size(), mesh.tets.size(), mesh.boundary.triangles.size(),
                          mesh.volume, topology_of(mesh.boundary)};
  }

  void add_surface(const SurfaceDistance& surface) {
    result_.identical_surface = surface.identical;
    result_.surface_differs_at = surface.differs_at;
    const auto shares = [&](const OneSidedDistance& d) {
      return SurfaceShares{share_of(d.max, result_.diagonal), share_of(d.mean, result_.diagonal),
                           d.max_at};
    };
    result_.to_simplified = shares(surface.first_to_second);
    result_.to_original = shares(surface.second_to_first);
    const auto swept = [](const OneSidedDistance& d) { return d.max > 0 ? d.area * d.max : 0; };
    result_.volume_between =
        std::max(swept(surface.first_to_second), swept(surface.second_to_first));
  }

  void add_domain(const PointMeasures& points, const CellMeasures& cells,
                  const SimplifiedMesh& mesh) {
    result_.original.volume = cells.volume.value();
    result_.volume_change = share_of(mesh.volume - cells.volume.value(), cells.volume.value());
    result_.volume_error = volume_error_;
    result_.outside_points = points.outside;
    result_.outside_max = share_of(points.farthest, result_.diagonal);
    result_.outside_cells = cells.outside;
  }

  void add_point_arrays(const PointMeasures& points, const CellMeasures& cells,
                        const SimplifiedMesh& mesh) {
    const std::vector<Integral> simplified = integrate_points(mesh, match_.points);
    for (std::size_t f = 0; f < match_.points.fields.size(); ++f) {
      const Field& field = match_.points.fields[f];
      double scale = 0;
      ArrayComparison a = summarize(field, points.errors[f], points.values[f], &scale);
      a.simplified_non_finite = count_non_finite(field, mesh.point_rows, match_.points.width);
      if (!field.integer) {
        a.cell_rms = share_of(cells.errors[f].rms(), scale);
        a.cell_max = share_of(cells.errors[f].max(), scale);
        a.gradient_rms = std::sqrt(share_of(cells.gradient_errors[f], cells.gradient_squares[f]));
        a.integral_change = share_of(change_of(cells.integrals[f], simplified[f]),
                                     cells.integrals[f].length.value());
        a.integral_rounding =
            rounding_of_integral(points.values[f], cells.integrals[f].length.value());
      }
      result_.arrays.push_back(std::move(a));
    }
  }

  void add_cell_arrays(const CellMeasures& cells, const SimplifiedMesh& mesh) {
    const std::vector<Integral> simplified = integrate_cells(mesh, match_.cells);
    for (std::size_t f = 0; f < match_.cells.fields.size(); ++f) {
      const Field& field = match_.cells.fields[f];
      double scale = 0;
      ArrayComparison a = summarize(field, cells.cell_errors[f], cells.cell_values[f], &scale);
      a.association = Association::kCell;
      a.simplified_non_finite = count_non_finite(field, mesh.cell_rows, match_.cells.width);
      if (field.region) {
        a.regions =
            join_regions(field, cells.cell_regions[f], measure_regions(mesh, match_.cells, field));
      }
      if (!field.integer) {
        const double whole = cells.cell_integrals[f].length.value();
        a.integral_change = share_of(change_of(cells.cell_integrals[f], simplified[f]), whole);
        a.integral_rounding = rounding_of_integral(cells.cell_values[f], whole);
        a.l1_change = share_of(simplified[f].length.value() - whole, whole);
        a.l1_error = share_of(cells.cell_differences[f].value(), whole);
      }
      result_.arrays.push_back(std::move(a));
    }
  }

  static std::uint64_t count_non_finite(const Field& field, const Vector<double>& rows,
                                        std::size_t width) {
    std::uint64_t count = 0;
    for (std::size_t at = field.offset; at < rows.size(); at += width) {
      if (!all_finite(rows.data() + at, field.info.components)) ++count;
    }
    return count;
  }

  double rounding_of_integral(const FieldValues& values, double whole) const {
    return share_of(volume_error_ * values.largest, whole);
  }

  const RunContext& context_;
  const std::uint64_t sides_;
  ArrayMatch match_;
  OriginalMesh original_;
  MeshSource* simplified_;
  const ValueType point_type_;
  double volume_error_ = 0;  // of both meshes together, by rounding, at most
  Comparison result_;
};

}  // namespace

Comparison compare_meshes(MeshSource* original, MeshSource* simplified, const RunContext& context,
                          std::uint64_t sides) {
  return Comparer(original, simplified, context, sides).run();
}

}  // namespace tetfusion
