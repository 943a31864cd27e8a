#include "partition/spatial_order.h"

#include <algorithm>

#include "base/copy_few.h"
#include "mesh/hilbert.h"
#include "partition/radix_sort.h"

namespace tetfusion {

namespace {

struct KeyedId {
  std::uint64_t key;
  VertexId id;
};

template <class Real>
Vector<VertexId> vertices_along(const ShiftedCurve& curve, const Vector<Vec3<Real>>& positions) {
  Vector<KeyedId> keys(positions.size());
  for (std::size_t v = 0; v < positions.size(); ++v) {
    keys[v] = {curve.key(positions[v]), static_cast<VertexId>(v)};
  }
  radix_sort<3 * kHilbertBits>(&keys, [](const KeyedId& k) { return k.key; });
  Vector<VertexId> new2old(keys.size());
  std::transform(keys.begin(), keys.end(), new2old.begin(), [](const KeyedId& k) { return k.id; });
  return new2old;
}

Tet renamed(const Tet& t, const Vector<VertexId>& old2new) {
  return {old2new[t[0]], old2new[t[1]], old2new[t[2]], old2new[t[3]]};
}

Vector<TetId> by_smallest_vertex(const Vector<Tet>& tets, const Vector<VertexId>& old2new) {
  const auto smallest = [&](const Tet& tet) {
    const Tet t = renamed(tet, old2new);
    return std::min({t[0], t[1], t[2], t[3]});
  };
  Vector<TetId> start;
  start.assign(old2new.size() + 1, 0);
  for (const Tet& t : tets) ++start[smallest(t) + 1];
  for (std::size_t v = 0; v < old2new.size(); ++v) start[v + 1] += start[v];
  Vector<TetId> new2old(tets.size());
  for (std::size_t t = 0; t < tets.size(); ++t) {
    new2old[start[smallest(tets[t])]++] = static_cast<TetId>(t);
  }
  return new2old;
}

// to[new] becomes from[new2old[new]], tuples of `width`.
template <class T>
void permute(const Vector<std::uint32_t>& new2old, const Vector<T>& from, std::size_t width,
             Vector<T>* to) {
  to->resize(from.size());
  for (std::size_t i = 0; i < new2old.size(); ++i) {
    copy_few(from.data() + new2old[i] * width, width, to->data() + i * width);
  }
}

void permute(const Vector<std::uint32_t>& new2old, const std::vector<Column>& from,
             std::vector<Column>* to) {
  to->resize(from.size());
  for (std::size_t c = 0; c < from.size(); ++c) {
    (*to)[c].type = from[c].type;
    (*to)[c].components = from[c].components;
    permute(new2old, from[c].rows, from[c].stride(), &(*to)[c].rows);
  }
}

}  // namespace

template <class Real>
void order_along_curve(const ShiftedCurve& curve, const WorkMesh<Real>& mesh, WorkMesh<Real>* out) {
  const Vector<VertexId> vertices = vertices_along(curve, mesh.positions);
  Vector<VertexId> old2new(vertices.size());
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    old2new[vertices[v]] = static_cast<VertexId>(v);
  }
  permute(vertices, mesh.positions, 1, &out->positions);
  permute(vertices, mesh.marks, 1, &out->marks);
  permute(vertices, mesh.steering, mesh.steering_width, &out->steering);
  out->steering_width = mesh.steering_width;
  permute(vertices, mesh.quadrics, mesh.quadric_width, &out->quadrics);
  out->quadric_width = mesh.quadric_width;
  permute(vertices, mesh.point_ids, 1, &out->point_ids);
  permute(vertices, mesh.incidence, 1, &out->incidence);
  permute(vertices, mesh.changed, 1, &out->changed);
  permute(vertices, mesh.point_columns, &out->point_columns);

  const Vector<TetId> tets = by_smallest_vertex(mesh.tets, old2new);
  out->tets.resize(tets.size());
  std::transform(tets.begin(), tets.end(), out->tets.begin(),
                 [&](TetId t) { return renamed(mesh.tets[t], old2new); });
  permute(tets, mesh.remembered, 1, &out->remembered);
  permute(tets, mesh.cell_columns, &out->cell_columns);
  out->deviations.clear();
  out->removed.clear();
}

template void order_along_curve(const ShiftedCurve&, const WorkMesh<float>&, WorkMesh<float>*);
template void order_along_curve(const ShiftedCurve&, const WorkMesh<double>&, WorkMesh<double>*);

}  // namespace tetfusion
