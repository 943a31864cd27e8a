#include "follow/apply_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>

#include "base/blocks.h"
#include "base/error.h"
#include "base/numbers.h"
#include "base/running_mean.h"
#include "compare/fields.h"
#include "compare/measure.h"
#include "follow/fit_values.h"
#include "io/source/stream_windows.h"
#include "mesh/array_names.h"

namespace tetfusion {

namespace {

constexpr std::size_t kValuesPerBlock = 8192;

static_assert(kLeastStreamWindow % PointWeights::kWindow == 0);

// One array, in two passes over the original's values, and some more where it is fitted, which it
// is with `weights`.
class Mover {
 public:
  Mover(const MapFile& map, const PointWeights* weights, const MeshStream& stream,
        const AttributeSet& arrays, std::size_t index)
      : map_(map),
        weights_(weights),
        stream_(stream),
        index_(index),
        info_(arrays.arrays[index]),
        width_(info_.components) {}

  MovedArray run(const RunContext& context, double bound, bool measured) {
    move(context);
    if (!is_float(info_.type)) return std::move(moved_);
    if (weights_ != nullptr) fit(context, bound);
    if (measured) measure(context);
    return std::move(moved_);
  }

 private:
  struct Sums {
    Errors errors;
    FieldValues values;
    double max_squared = 0;
    std::uint64_t max_at = 0;
  };

  std::size_t stride() const { return width_ * size_of(info_.type); }

  void move(const RunContext& context) {
    moved_.array.info = info_;
    moved_.array.info.tuples = map_.counts().points;
    moved_.array.bytes.resize(map_.counts().points * stride());
    std::fill(moved_.array.bytes.begin(), moved_.array.bytes.end(), std::byte{0});
    visit_type(info_.type, [&](auto value) { move<decltype(value)>(context); });
  }

  // Calls f(first, rows) for the original's values, window by window.
  template <class F>
  void for_each_window(const RunContext& context, F f) const {
    for_each_window_of(stream_, Association::kPoint, index_, info_, context, f);
  }

  template <class T>
  void move(const RunContext& context) {
    const std::span<T> out = moved_.array.as<T>();
    Vector<double> means, most;  // of floating-point values; the largest weight so far
    Vector<double> taken;        // weight so far
    Vector<double> lost;         // that of those that are not finite, once there are any
    Vector<T> others;            // the first of these
    if constexpr (std::is_floating_point_v<T>) {
      means.assign(out.size(), 0);
      taken.assign(map_.counts().points, 0);
    } else {
      most.assign(map_.counts().points, 0);
    }
    auto next = map_.shares().begin();
    auto begin = next;
    for_each_window(context, [&](std::uint64_t first, std::span<const std::byte> rows) {
      const T* values = reinterpret_cast<const T*>(rows.data());
      const std::uint64_t end = first + rows.size() / stride();
      for (; next != map_.shares().end() && next->original < end; ++next) {
        const T* from = values + (next->original - first) * width_;
        T* to = out.data() + next->point * width_;
        if constexpr (std::is_floating_point_v<T>) {
          const double before = taken[next->point];
          taken[next->point] += next->weight;
          for (std::size_t c = 0; c < width_; ++c) {
            const std::size_t i = next->point * width_ + c;
            if (std::isfinite(from[c])) {
              add_to_mean(from[c], next->weight, before - (lost.empty() ? 0 : lost[i]), &means[i]);
            } else if (next->weight < 1) {
              if (lost.empty()) {
                lost.assign(out.size(), 0);
                others.resize(out.size());
              }
              if (lost[i] == 0) others[i] = from[c];
              lost[i] += next->weight;
            }
            to[c] = next->weight == 1 ? from[c] : static_cast<T>(means[i]);
          }
        } else if (next->weight > most[next->point]) {
          most[next->point] = next->weight;
          std::copy_n(from, width_, to);
        }
      }
      map_.forget(std::span(begin, next));
      begin = next;
    });
    if constexpr (std::is_floating_point_v<T>) {
      // As in a fusion (kernel/fusions.h).
      for (std::size_t i = 0; i < lost.size(); ++i) {
        if (lost[i] > 0.5) out[i] = others[i];
      }
    }
  }

  void fit(const RunContext& context, double bound) {
    Vector<double> values, rows;
    spread_values(info_, moved_.array.bytes, target(map_.counts().points, &values));
    scale_by(largest_of(values));
    if (exponent_ != 0) {
      spread_values(info_, moved_.array.bytes, target(map_.counts().points, &values));
    }
    fit_values(*weights_, width_, bound, &values, [&](const TakeRows& take) {
      for_each_window(context, [&](std::uint64_t first, std::span<const std::byte> bytes) {
        spread_values(info_, bytes, target(bytes.size() / stride(), &rows));
        take(first, rows);
      });
    });
    visit_type(info_.type, [&](auto zero) {
      using T = decltype(zero);
      const std::span<T> out = moved_.array.as<T>();
      for (std::size_t i = 0; i < out.size(); ++i) {
        if (weights_->is_new()[i / width_] == 0) continue;
        out[i] = static_cast<T>(std::ldexp(values[i], -exponent_));
      }
    });
  }

  void measure(const RunContext& context) {
    Sums all = measure_points(context);
    if (scale_by(std::ldexp(all.values.largest, -exponent_))) all = measure_points(context);
    const double range = all.values.diagonal();
    const double scale = range > 0 ? range : all.values.largest;
    const auto share = [&](double error) { return error == 0 ? 0 : error / scale; };
    moved_.rms = share(all.errors.rms());
    moved_.max = share(all.errors.max());
    moved_.rounding = share(rounding_of(info_.type) * all.values.largest);
    moved_.max_at = all.max_at;
    moved_.undefined = all.errors.undefined;
  }

  Sums measure_points(const RunContext& context) const {
    const Field field{info_, 0, 0, false, false, 0};
    FieldSet set{{field}, width_, width_};
    Sums all = nothing(set);
    Vector<double> values, rows;
    spread_values(info_, moved_.array.bytes, target(map_.counts().points, &values));
    for_each_window(context, [&](std::uint64_t first, std::span<const std::byte> bytes) {
      const std::size_t count = bytes.size() / stride();
      spread_values(info_, bytes, target(count, &rows));
      std::vector<Sums> parts(block_count(count, kValuesPerBlock), nothing(set));
      for_each_block(
          count, kValuesPerBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
              measure_point(field, first + i, rows.data() + i * width_, values, &parts[b]);
            }
          });
      if (weights_ != nullptr) {
        weights_->let_go();
      } else {
        map_.forget(map_.places().subspan(first, count));
      }
      for (const Sums& part : parts) {
        all.errors.add(part.errors);
        all.values.add(part.values);
        if (part.max_squared <= all.max_squared) continue;
        all.max_squared = part.max_squared;
        all.max_at = part.max_at;
      }
    });
    return all;
  }

  static Sums nothing(const FieldSet& set) {
    const PointMeasures empty(set);
    return {empty.errors[0], empty.values[0], 0, 0};
  }

  RowTarget target(std::size_t rows, Vector<double>* out) const {
    out->resize(rows * width_);
    return {width_, 0, rows, {}, out->data(), 0, std::ldexp(1.0, exponent_)};
  }

  // Takes the exponent for values of which that is the largest. Whether it is another one.
  bool scale_by(double largest) {
    const int before = std::exchange(exponent_, exponent_for(largest));
    return exponent_ != before;
  }

  static double largest_of(const Vector<double>& values) {
    double largest = 0;
    for (const double value : values) {
      if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
    }
    return largest;
  }

  void measure_point(const Field& field, std::uint64_t point, const double* row,
                     const Vector<double>& values, Sums* sums) const {
    const PointPlace place = weights_ != nullptr ? weights_->place(point) : place_of(map_, point);
    if (place.corners[0] == kNoVertex || !all_finite(row, width_)) return;
    sums->values.add(row);
    const double squared = squared_difference(field, row, [&](std::size_t c) {
      double sum = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        sum += place.weights[k] * values[place.corners[k] * width_ + c];
      }
      return sum;
    });
    if (!std::isfinite(squared)) {
      ++sums->errors.undefined;
      return;
    }
    sums->errors.add(1, squared, {});
    if (squared <= sums->max_squared) return;
    sums->max_squared = squared;
    sums->max_at = point;
  }

  const MapFile& map_;
  const PointWeights* weights_;
  const MeshStream& stream_;
  const std::size_t index_;
  const ArrayInfo info_;
  const std::size_t width_;
  int exponent_ = 0;  // of values that are measured or fitted, as of a Field
  MovedArray moved_;
};

std::vector<std::size_t> choose(const MeshDescription& mesh,
                                const std::vector<std::string>& names) {
  const AttributeSet& all = mesh.point_data;
  std::vector<std::size_t> chosen;
  for (const std::string& name : names) {
    const std::size_t index = all.find(name);
    const bool is_new = std::find(chosen.begin(), chosen.end(), index) == chosen.end();
    if (is_new) chosen.push_back(index);
    if (index != AttributeSet::npos) continue;
    throw Error(
        ErrorCode::kUsage,
        fmt::format("{}: there is no point array \"{}\"; see 'tetfusion info'", mesh.path, name));
  }
  if (!names.empty()) return chosen;
  for (std::size_t i = 0; i < all.arrays.size(); ++i) {
    if (!is_ghost_mark(all.arrays[i].name)) chosen.push_back(i);
  }
  return chosen;
}

// Throws where the map is not of that mesh.
std::unique_ptr<MeshStream> open_for(const MapFile& map, MeshSource* source) {
  auto stream = open_rows(source);
  if (stream->points() != map.counts().original_points) {
    throw Error(
        ErrorCode::kBadInput,
        fmt::format("{}: the mesh has {}, but {} is of one that had {}: give a file with the "
                    "points of the mesh that was simplified, in their order, and what that run was "
                    "given of --tetrahedralize, --linearize, --merge-points and --drop-patches",
                    source->description().path, format_count(stream->points(), "point"), map.path(),
                    format_count(map.counts().original_points)));
  }
  return stream;
}

}  // namespace

std::vector<MovedArray> apply_map(const MapFile& map, MeshSource* source,
                                  const std::vector<std::string>& names, const RunContext& context,
                                  bool measured, const PointWeights* weights) {
  const MeshDescription& mesh = source->description();
  const std::vector<std::size_t> chosen = choose(mesh, names);
  const auto stream = open_for(map, source);
  std::vector<MovedArray> arrays;
  for (const std::size_t i : chosen) {
    context.report("moving", static_cast<double>(arrays.size()) /
                                 static_cast<double>(std::max<std::size_t>(chosen.size(), 1)));
    arrays.push_back(
        Mover(map, weights, *stream, mesh.point_data, i).run(context, ArrayFit{}.bound, measured));
  }
  map.check();
  return arrays;
}

std::vector<MovedArray> fit_arrays(const MapFile& map, const PointWeights& weights,
                                   MeshSource* source, const std::vector<ArrayFit>& fits,
                                   const RunContext& context, bool measured) {
  const AttributeSet& all = source->description().point_data;
  const auto stream = open_for(map, source);
  std::vector<MovedArray> arrays;
  for (const ArrayFit& fit : fits) {
    const std::size_t i = choose(source->description(), {fit.name})[0];
    arrays.push_back(Mover(map, &weights, *stream, all, i).run(context, fit.bound, measured));
  }
  map.check();
  return arrays;
}

namespace {

double largest_coordinate(ValueType type, std::span<const std::byte> coordinates) {
  const std::size_t step = kStreamWindow * size_of(type);
  double largest = 0;
  for (std::size_t at = 0; at < coordinates.size(); at += step) {
    const auto part = coordinates.subspan(at, std::min(step, coordinates.size() - at));
    for (const double x : to_doubles(type, part)) largest = std::max(largest, std::abs(x));
  }
  return largest;
}

}  // namespace

StayedPoints compare_stayed_points(const MapFile& map, MeshSource* source,
                                   const RunContext& context) {
  const auto stream = open_for(map, source);
  const ValueType type = source->description().point_type, own_type = map.counts().point_type;
  const std::span<const std::byte> own = map.mesh().points.bytes;
  const std::size_t stride = 3 * size_of(own_type);
  // Files of other programs may have rounded coordinates, also those that are 0 but for rounding.
  const double largest = largest_coordinate(own_type, own);
  const auto is_about = [&](double a, double b) {
    return std::abs(a - b) <= 1e-6 * std::max(std::abs(a), std::abs(b)) + 1e-12 * largest;
  };
  StayedPoints stayed;
  Vector<std::byte> rows;
  auto next = map.shares().begin();
  for_each_window(stream->points(), context, [&](std::uint64_t first, std::uint64_t count) {
    rows.resize(count * 3 * size_of(type));
    stream->read_points(first, count, rows);
    const Vector<double> there = to_doubles(type, rows);
    const auto begin = next;
    for (; next != map.shares().end() && next->original < first + count; ++next) {
      if (next->weight != 1) continue;
      const Vector<double> here = to_doubles(own_type, own.subspan(next->point * stride, stride));
      const double* other = there.data() + 3 * (next->original - first);
      ++stayed.count;
      stayed.elsewhere += std::equal(here.begin(), here.end(), other, is_about) ? 0 : 1;
    }
    map.forget(std::span(begin, next));
  });
  return stayed;
}

std::unique_ptr<MeshSource> open_moved(const MapFile& map, const std::vector<MovedArray>& arrays,
                                       const std::vector<MovedCells>& cells, MeshSource* source) {
  const MeshDescription& mesh = source->description();
  MeshView view = map.mesh();
  view.any_names = true;
  view.field_data = source->read_field_data();
  const auto add = [](const DataArray& array, const AttributeSet& set, std::vector<ArrayView>* to,
                      std::map<std::string, std::string>* markers) {
    const ArrayInfo& info = array.info;
    to->push_back({info.name,
                   info.components,
                   {info.type, std::span(array.bytes)},
                   info.component_names,
                   info.units});
    for (const auto& [marker, name] : set.active) {
      if (name == info.name) (*markers)[marker] = name;
    }
  };
  for (const MovedArray& moved : arrays) {
    add(moved.array, mesh.point_data, &view.point_arrays, &view.point_markers);
  }
  for (const MovedCells& moved : cells) {
    add(moved.array, mesh.cell_data, &view.cell_arrays, &view.cell_markers);
  }
  return open_view(std::move(view));
}

}  // namespace tetfusion
