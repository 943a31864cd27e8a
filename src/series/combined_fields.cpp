#include "series/combined_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/numbers.h"
#include "io/source/stream_windows.h"
#include "mesh/array_names.h"
#include "series/series_plan.h"

namespace tetfusion {

namespace {

// 1 or -1 by the number of the step, as a coin would have it: with signs that alternate, sums of
// steps that are alike would be nothing. (The finalizer of MurmurHash3.)
double sign_of(std::uint64_t step, std::uint64_t way) {
  std::uint64_t x = step + 1 + (way << 32);
  x = (x ^ x >> 33) * 0xff51afd7ed558ccdULL;
  x = (x ^ x >> 33) * 0xc4ceb9fe1a85ec53ULL;
  return (x ^ x >> 33) % 2 == 0 ? 1 : -1;
}

Vector<double> read_rows(const MeshStream& stream, std::size_t index, const ArrayInfo& info,
                         std::uint64_t first, std::uint64_t count) {
  Vector<std::byte> rows(count * info.row_bytes());
  stream.read_rows(Association::kPoint, index, first, count, rows);
  Vector<double> values(count * info.components);
  spread_values(info, rows, {info.components, 0, count, {}, values.data()});
  return values;
}

// What values are multiplied by, so that their range and its inverse are numbers.
double scale_for(double range) {
  if (!std::isfinite(range)) return 0x1p-4;
  return range > 0 && range < std::numeric_limits<double>::min() ? 0x1p200 : 1;
}

FieldValues scaled(FieldValues values, double scale) {
  for (Range& range : values.ranges) range = {scale * range.min, scale * range.max};
  values.largest *= scale;
  return values;
}

}  // namespace

CombinedFields::CombinedFields(const std::string& folder, const std::vector<SteeringChoice>& arrays,
                               const MeshDescription& first, const PointSet* used,
                               std::size_t steps, const Settings& settings)
    : arrays_(arrays),
      used_(used),
      alone_(settings.alone),
      sums_(std::min(steps, settings.sums)),
      fields_(sums_ + alone_.size()),
      way_(settings.way) {
  std::uint64_t bytes = 0;
  for (const SteeringChoice& array : arrays_) {
    const std::uint32_t components = first.point_data.arrays[array.index].components;
    for (std::size_t k = 0; k < fields_; ++k) {
      infos_.push_back({k < sums_ ? fmt::format("{} (sum {} of {})", array.name, k + 1, sums_)
                                  : fmt::format("{} (step {})", array.name, alone_[k - sums_]),
                        ValueType::kFloat64,
                        components,
                        {},
                        used->points(),
                        true});
      starts_.push_back(bytes);
      bytes += used->points() * components * sizeof(double);
    }
  }
  ranges_.resize(infos_.size());
  if (bytes > 0) file_.emplace(folder, bytes);
}

CombinedFields::Source CombinedFields::find(const SteeringChoice& array, std::uint32_t components,
                                            const MeshDescription& mesh) const {
  Source source{mesh.point_data.find(array.name), {}};
  if (source.index == AttributeSet::npos) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: this step has no point array \"{}\", which steers: its arrays are "
                            "{}",
                            mesh.path, array.name, names_of(mesh.point_data)));
  }
  source.info = mesh.point_data.arrays[source.index];
  if (!is_float(source.info.type)) {
    throw Error(
        ErrorCode::kBadInput,
        fmt::format("{}: the array \"{}\", which steers, has integers in this step, between "
                    "which nothing can be measured: name another array{}",
                    mesh.path, array.name,
                    holds_step(array.name) ? "" : ", or give --series each"));
  }
  if (source.info.components != components) {
    throw Error(
        ErrorCode::kBadInput,
        fmt::format("{}: the array \"{}\", which steers, has {} in this step, not {}", mesh.path,
                    array.name, format_count(source.info.components, "component"), components));
  }
  return source;
}

// Of the components, at points that are used.
std::optional<FieldValues> CombinedFields::measure(const Source& source, const MeshStream& stream,
                                                   const RunContext& context) const {
  const std::size_t width = source.info.components;
  FieldValues all{std::vector<Range>(width), 0};
  bool has_some = false;
  for_each_window(used_->points(), context, [&](std::uint64_t first, std::uint64_t count) {
    const Vector<double> rows = read_rows(stream, source.index, source.info, first, count);
    for (std::uint64_t i = 0; i < count; ++i) {
      const double* row = rows.data() + i * width;
      if (!used_->has(first + i) || !all_finite(row, width)) continue;
      all.add(row);
      has_some = true;
    }
  });
  if (!has_some) return std::nullopt;
  return all;
}

void CombinedFields::add(std::size_t step, const MeshDescription& mesh, const MeshStream& stream,
                         const RunContext& context) {
  const auto alone = std::ranges::find(alone_, step);
  for (std::size_t a = 0; a < arrays_.size(); ++a) {
    const std::size_t field = a * fields_ + sum_of(step);
    const Source source = find(arrays_[a], infos_[field].components, mesh);
    const std::optional<FieldValues> values = measure(source, stream, context);
    // A step without any value has none to lose.
    if (!values) continue;
    // A field without a range may still have points without a value, which are to have none.
    const double scale = scale_for(values->diagonal());
    const double range = scaled(*values, scale).diagonal();
    const double factor = range > 0 ? sign_of(step, way_) / range : 0;
    for_each_window(used_->points(), context, [&](std::uint64_t first, std::uint64_t count) {
      Vector<double> rows = read_rows(stream, source.index, source.info, first, count);
      if (scale != 1) std::ranges::for_each(rows, [&](double& value) { value *= scale; });
      add_rows(field, first, rows, factor);
      if (alone == alone_.end()) return;
      const auto place = static_cast<std::size_t>(alone - alone_.begin());
      add_rows(a * fields_ + sums_ + place, first, rows, factor);
    });
  }
}

void CombinedFields::add_rows(std::size_t field, std::uint64_t first, const Vector<double>& rows,
                              double factor) {
  Vector<double> sums(rows.size());
  file_->read(offset(field, first), std::as_writable_bytes(std::span(sums)));
  for (std::size_t i = 0; i < rows.size(); ++i) sums[i] += factor * rows[i];
  file_->write(offset(field, first), std::as_bytes(std::span(sums)));
}

void CombinedFields::finish(const RunContext& context) {
  Vector<double> rows;
  std::vector<bool> has_some(infos_.size());
  for (std::size_t f = 0; f < infos_.size(); ++f) {
    const std::size_t width = infos_[f].components;
    FieldValues all{std::vector<Range>(width), 0};
    for_each_window(used_->points(), context, [&](std::uint64_t first, std::uint64_t count) {
      rows.resize(count * width);
      file_->read(offset(f, first), std::as_writable_bytes(std::span(rows)));
      for (std::uint64_t i = 0; i < count; ++i) {
        const double* row = rows.data() + i * width;
        if (!used_->has(first + i) || !all_finite(row, width)) continue;
        all.add(row);
        has_some[f] = true;
      }
    });
    ranges_[f] = all.diagonal();
  }
  for (std::size_t f = 0; f < infos_.size(); ++f) {
    const auto it = std::find_if(ranges_.begin(), ranges_.end(), [](double r) { return r > 0; });
    if (ranges_[f] > 0 || !has_some[f] || it == ranges_.end()) continue;
    take_gaps(f, static_cast<std::size_t>(it - ranges_.begin()), context);
  }
}

// A field without a range steers nothing, but where it has no value there is to be none.
void CombinedFields::take_gaps(std::size_t from, std::size_t to, const RunContext& context) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const std::size_t width = infos_[from].components, to_width = infos_[to].components;
  Vector<double> rows, to_rows;
  for_each_window(used_->points(), context, [&](std::uint64_t first, std::uint64_t count) {
    rows.resize(count * width);
    to_rows.resize(count * to_width);
    file_->read(offset(from, first), std::as_writable_bytes(std::span(rows)));
    file_->read(offset(to, first), std::as_writable_bytes(std::span(to_rows)));
    for (std::uint64_t i = 0; i < count; ++i) {
      if (all_finite(rows.data() + i * width, width)) continue;
      std::fill_n(to_rows.data() + i * to_width, to_width, kNone);
    }
    file_->write(offset(to, first), std::as_bytes(std::span(to_rows)));
  });
}

void CombinedFields::read(std::size_t field, std::uint64_t first, std::span<std::byte> out) const {
  file_->read(offset(field, first), out);
}

}  // namespace tetfusion
