#include "mesh/regions/region_of_interest.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "base/error.h"
#include "base/numbers.h"
#include "mesh/array_names.h"

namespace tetfusion {

namespace {

constexpr std::string_view kBox = "box=", kSphere = "sphere=";

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
  throw Error(ErrorCode::kUsage, fmt::format("--roi {}: {}", text, why));
}

std::vector<double> parse_numbers(const std::string& text, std::string_view list) {
  std::vector<double> numbers;
  for (const std::string& part : split(list, ',')) {
    const auto number = parse_number(part);
    if (!number) refuse(text, fmt::format("\"{}\" is no number", part));
    numbers.push_back(*number);
  }
  return numbers;
}

bool contains(const std::array<double, 6>& box, const Vec3<double>& p) {
  return p.x >= box[0] && p.x <= box[1] && p.y >= box[2] && p.y <= box[3] && p.z >= box[4] &&
         p.z <= box[5];
}

// Also where squares leave the range of double precision.
double length_of(std::span<const double> values) {
  double sum = 0;
  for (const double x : values) sum += x * x;
  if (std::isnormal(sum)) return std::sqrt(sum);
  double length = 0;
  for (const double x : values) length = std::hypot(length, x);
  return length;
}

}  // namespace

RegionOfInterest::RegionOfInterest(const std::vector<std::string>& texts, const std::string& path,
                                   const AttributeSet& point_data) {
  for (const std::string& text : texts) parts_.push_back(parse(text, path, point_data));
}

bool RegionOfInterest::is_by_values(const std::string& text) {
  return !text.starts_with(kBox) && !text.starts_with(kSphere);
}

auto RegionOfInterest::parse(const std::string& text, const std::string& path,
                             const AttributeSet& point_data) -> Part {
  if (text.starts_with(kBox)) {
    const auto n = parse_numbers(text, std::string_view(text).substr(kBox.size()));
    if (n.size() != 6 || !(n[0] <= n[1] && n[2] <= n[3] && n[4] <= n[5])) {
      refuse(text, "a box has six bounds, box=X0,X1,Y0,Y1,Z0,Z1, the lower one of each pair first");
    }
    Bounds bounds;
    std::copy(n.begin(), n.end(), bounds.limits.begin());
    return bounds;
  }
  if (text.starts_with(kSphere)) {
    const auto n = parse_numbers(text, std::string_view(text).substr(kSphere.size()));
    if (n.size() != 4 || !(n[3] >= 0)) {
      refuse(text, "a sphere has a centre and a radius, sphere=X,Y,Z,RADIUS");
    }
    return Sphere{{n[0], n[1], n[2]}, n[3]};
  }
  const std::size_t sign = text.find_last_of("<>");
  const auto value = sign == std::string::npos
                         ? std::nullopt
                         : parse_number(trimmed(std::string_view(text).substr(sign + 1)));
  if (!value) {
    refuse(text,
           "give box=X0,X1,Y0,Y1,Z0,Z1, sphere=X,Y,Z,RADIUS, or a point array and a value, as in "
           "pressure>0.5");
  }
  // A name may end in blanks, but those of "p > 0.5" belong to no name.
  std::string name = text.substr(0, sign);
  if (point_data.find(name) == AttributeSet::npos) name = trimmed(name);
  const std::size_t index = point_data.find(name);
  if (index == AttributeSet::npos) {
    refuse(text, fmt::format("{} has no point array \"{}\"; it has {}", path, name,
                             names_of(point_data)));
  }
  return Threshold{index, point_data.arrays[index], *value, text[sign] == '>'};
}

template <class Real>
void RegionOfInterest::mark(std::span<const Vec3<Real>> positions, const ReadRows& read,
                            std::uint8_t* inside) const {
  const auto mark_where = [&](auto is_inside) {
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const Vec3<Real>& p = positions[i];
      if (is_inside(Vec3<double>{double{p.x}, double{p.y}, double{p.z}})) inside[i] = 1;
    }
  };
  for (const Part& part : parts_) {
    if (const auto* box = std::get_if<Bounds>(&part)) {
      mark_where([&](const Vec3<double>& p) { return contains(box->limits, p); });
    } else if (const auto* sphere = std::get_if<Sphere>(&part)) {
      mark_where([&](const Vec3<double>& p) {
        const double x = p.x - sphere->centre.x, y = p.y - sphere->centre.y;
        const double z = p.z - sphere->centre.z;
        const double square = x * x + y * y + z * z, radius = sphere->radius;
        if (std::isnormal(square) && std::isnormal(radius * radius)) {
          return square <= radius * radius;
        }
        return length_of(std::array{x, y, z}) <= radius;
      });
    }
  }
  mark_by_values(positions.size(), read, inside);
}

void RegionOfInterest::mark_by_values(std::size_t points, const ReadRows& read,
                                      std::uint8_t* inside) const {
  for (const Part& part : parts_) {
    const auto* threshold = std::get_if<Threshold>(&part);
    if (threshold == nullptr) continue;
    const std::size_t width = threshold->array.components;
    Vector<std::byte> rows(points * width * size_of(threshold->array.type));
    read(threshold->index, rows);
    const Vector<double> values = to_doubles(threshold->array.type, rows);
    for (std::size_t i = 0; i < points; ++i) {
      const double value =
          width == 1 ? values[i] : length_of(std::span(values).subspan(i * width, width));
      if (threshold->above ? value > threshold->value : value < threshold->value) inside[i] = 1;
    }
  }
}

template void RegionOfInterest::mark(std::span<const Vec3<float>>, const ReadRows&,
                                     std::uint8_t*) const;
template void RegionOfInterest::mark(std::span<const Vec3<double>>, const ReadRows&,
                                     std::uint8_t*) const;

}  // namespace tetfusion
