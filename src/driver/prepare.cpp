#include "driver/prepare.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

#include "base/error.h"

namespace tetfusion {

namespace {

bool can_be_region(const ArrayInfo& array) {
  return array.components == 1 && !is_float(array.type) && array.type != ValueType::kString;
}

bool is_named_like_material(std::string_view name) {
  constexpr std::array<std::string_view, 8> kWords{"material", "region", "physical", "tissue",
                                                   "block",    "zone",   "part",     "label"};
  // A partition's rank says who computed a cell, not what it is made of.
  constexpr std::array<std::string_view, 3> kPartitions{"partition", "particle", "parallel"};
  std::string lower(name);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto contains = [&](std::string_view word) {
    return lower.find(word) != std::string::npos;
  };
  return std::any_of(kWords.begin(), kWords.end(), contains) &&
         std::none_of(kPartitions.begin(), kPartitions.end(), contains);
}

void mark_interfaces(const DataArray& array, const Geometry& geometry,
                     Vector<std::uint8_t>* interfaces) {
  visit_type(array.info.type, [&](auto zero) {
    using T = decltype(zero);
    const auto values = array.as<T>();
    Vector<T> first;
    first.assign(interfaces->size(), T{});
    Vector<std::uint8_t> seen;
    seen.assign(interfaces->size(), 0);
    for (std::size_t t = 0; t < geometry.tets.size(); ++t) {
      const T value = values[geometry.tet_source.empty() ? t : geometry.tet_source[t]];
      for (const VertexId v : geometry.tets[t]) {
        if (seen[v] != 0 && first[v] != value) (*interfaces)[v] = 1;
        first[v] = value;
        seen[v] = 1;
      }
    }
  });
}

Vector<std::uint8_t> mark_vertices(const Inspection& inspection, const Steering& steering,
                                   std::span<const std::uint8_t> interfaces,
                                   const Vector<Tet>& tets) {
  Vector<std::uint8_t> marks(inspection.vertex_flags.size());
  for (std::size_t v = 0; v < marks.size(); ++v) {
    const std::uint8_t flags = inspection.vertex_flags[v];
    const bool locked = (flags & (kBrokenVertex | kCarriedVertex)) != 0 ||
                        steering.not_finite[v] != 0 || (!interfaces.empty() && interfaces[v] != 0);
    marks[v] = static_cast<std::uint8_t>(((flags & kBoundaryVertex) != 0 ? kOnBoundary : 0) |
                                         (locked ? kLocked : 0));
  }
  for (const Tet& t : tets) {
    if (((marks[t[0]] | marks[t[1]] | marks[t[2]] | marks[t[3]]) & kOnBoundary) == 0) continue;
    for (const VertexId v : t) marks[v] |= kNearBoundary;
  }
  return marks;
}

}  // namespace

std::vector<std::size_t> choose_regions(const MeshDescription& mesh,
                                        const std::optional<std::vector<std::string>>& names) {
  std::vector<std::size_t> regions;
  if (!names) {
    for (std::size_t i = 0; i < mesh.cell_data.arrays.size(); ++i) {
      const ArrayInfo& array = mesh.cell_data.arrays[i];
      if (can_be_region(array) && is_named_like_material(array.name)) regions.push_back(i);
    }
    return regions;
  }
  for (const std::string& name : *names) {
    const std::size_t i = mesh.cell_data.find(name);
    if (i == AttributeSet::npos || !can_be_region(mesh.cell_data.arrays[i])) {
      throw Error(
          ErrorCode::kUsage,
          fmt::format("{}: --regions {}: there is no integer cell array of one component with that "
                      "name; see 'tetfusion info {}'",
                      mesh.path, name, mesh.path));
    }
    regions.push_back(i);
  }
  return regions;
}

Vector<std::uint8_t> find_interfaces(const std::vector<std::size_t>& regions,
                                     const Geometry& geometry, MeshSource* source) {
  Vector<std::uint8_t> interfaces;
  if (regions.empty()) return interfaces;
  interfaces.assign(point_count(geometry.points), 0);
  for (const std::size_t i : regions) {
    mark_interfaces(source->read_array(Association::kCell, i), geometry, &interfaces);
  }
  return interfaces;
}

template <class Real>
WorkMesh<Real> make_work_mesh(const Inspection& inspection,
                              std::span<const std::uint8_t> interfaces, Steering* steering,
                              Geometry* geometry) {
  WorkMesh<Real> work;
  work.marks = mark_vertices(inspection, *steering, interfaces, geometry->tets);
  work.positions = std::move(std::get<Vector<Vec3<Real>>>(geometry->points));
  work.tets = std::move(geometry->tets);
  work.steering_width = steering->width;
  work.steering = std::move(steering->values);
  work.point_ids = count_up<VertexId>(work.positions.size());
  work.tet_ids = count_up<TetId>(work.tets.size());
  count_incidence(&work);
  work.changed.assign(work.positions.size(), 0);
  work.flipped.assign(work.tets.size(), 0);
  return work;
}

template WorkMesh<float> make_work_mesh(const Inspection&, std::span<const std::uint8_t>, Steering*,
                                        Geometry*);
template WorkMesh<double> make_work_mesh(const Inspection&, std::span<const std::uint8_t>,
                                         Steering*, Geometry*);

}  // namespace tetfusion
