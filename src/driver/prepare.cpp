#include "driver/prepare.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

#include "base/error.h"
#include "partition/spatial_order.h"

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
  const auto contains = [&](std::string_view word) { return lower.find(word) != std::string::npos; };
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

template <class Real>
void mark_vertices(const Inspection& inspection, const Steering& steering,
                   std::span<const std::uint8_t> interfaces, const Vector<VertexId>& new2old,
                   WorkMesh<Real>* work) {
  work->marks.resize(new2old.size());
  for (std::size_t v = 0; v < new2old.size(); ++v) {
    const VertexId old = new2old[v];
    const std::uint8_t flags = inspection.vertex_flags[old];
    const bool locked = (flags & (kBrokenVertex | kCarriedVertex)) != 0 ||
                        steering.not_finite[old] != 0 || (!interfaces.empty() && interfaces[old] != 0);
    work->marks[v] = static_cast<std::uint8_t>(((flags & kBoundaryVertex) != 0 ? kOnBoundary : 0) |
                                               (locked ? kLocked : 0));
  }
  for (const Tet& t : work->tets) {
    const int any = work->marks[t[0]] | work->marks[t[1]] | work->marks[t[2]] | work->marks[t[3]];
    if ((any & kOnBoundary) == 0) continue;
    for (const VertexId v : t) work->marks[v] |= kNearBoundary;
  }
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
      throw Error(ErrorCode::kUsage,
                  fmt::format("{}: --regions {}: there is no integer cell array of one component with that "
                              "name; see 'tetfusion info {}'",
                              mesh.path, name, mesh.path));
    }
    regions.push_back(i);
  }
  return regions;
}

Vector<std::uint8_t> find_interfaces(const std::vector<std::size_t>& regions, const Geometry& geometry,
                                     MeshSource* source) {
  Vector<std::uint8_t> interfaces;
  if (regions.empty()) return interfaces;
  interfaces.assign(point_count(geometry.points), 0);
  for (const std::size_t i : regions) {
    mark_interfaces(source->read_array(Association::kCell, i), geometry, &interfaces);
  }
  return interfaces;
}

template <class Real>
WorkMesh<Real> make_work_mesh(const Inspection& inspection, const Steering& steering,
                              std::span<const std::uint8_t> interfaces, Geometry* geometry) {
  WorkMesh<Real> work;
  const Vector<VertexId> new2old = points_along_curve(geometry->points);
  const std::size_t points = new2old.size();
  const auto& positions = std::get<Vector<Vec3<Real>>>(geometry->points);
  Vector<VertexId> old2new(points);
  work.positions.resize(points);
  work.steering_width = steering.width;
  work.steering.resize(points * steering.width);
  for (std::size_t v = 0; v < points; ++v) {
    const VertexId old = new2old[v];
    old2new[old] = static_cast<VertexId>(v);
    work.positions[v] = positions[old];
    std::copy_n(steering.values.begin() + old * steering.width, steering.width,
                work.steering.begin() + v * steering.width);
  }
  geometry->points = Vector<Vec3<Real>>();

  for (Tet& t : geometry->tets) {
    for (VertexId& v : t) v = old2new[v];
  }
  work.tet_ids = tets_by_first_vertex(geometry->tets, points);
  work.tets.resize(geometry->tets.size());
  for (std::size_t t = 0; t < work.tets.size(); ++t) work.tets[t] = geometry->tets[work.tet_ids[t]];
  geometry->tets = Vector<Tet>();

  mark_vertices(inspection, steering, interfaces, new2old, &work);
  work.point_ids = new2old;
  return work;
}

template WorkMesh<float> make_work_mesh(const Inspection&, const Steering&,
                                        std::span<const std::uint8_t>, Geometry*);
template WorkMesh<double> make_work_mesh(const Inspection&, const Steering&,
                                         std::span<const std::uint8_t>, Geometry*);

}  // namespace tetfusion
