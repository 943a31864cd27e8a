#include "mesh/work_mesh.h"

#include <algorithm>

#include "base/copy_few.h"

namespace tetfusion {

namespace {

// Those of incidence 0. The others' new ids; their order is kept.
template <class Real>
Vector<VertexId> drop_unused_vertices(WorkMesh<Real>* mesh) {
  Vector<VertexId> new_ids(mesh->vertex_count());
  VertexId kept = 0;
  const std::size_t width = mesh->steering_width;
  const std::size_t numbers = mesh->quadric_width;
  for (std::size_t v = 0; v < new_ids.size(); ++v) {
    if (mesh->incidence[v] == 0) continue;
    const VertexId to = kept++;
    new_ids[v] = to;
    if (to == v) continue;
    mesh->positions[to] = mesh->positions[v];
    mesh->marks[to] = mesh->marks[v];
    mesh->point_ids[to] = mesh->point_ids[v];
    mesh->incidence[to] = mesh->incidence[v];
    mesh->changed[to] = mesh->changed[v];
    if (mesh->has_deviations) mesh->deviations[to] = mesh->deviations[v];
    copy_few(mesh->steering.data() + v * width, width, mesh->steering.data() + to * width);
    copy_few(mesh->quadrics.data() + v * numbers, numbers, mesh->quadrics.data() + to * numbers);
    for (Column& column : mesh->point_columns) column.move_row(v, to);
  }
  mesh->resize_vertices(kept);
  return new_ids;
}

}  // namespace

template <class Real>
void WorkMesh<Real>::resize_vertices(std::size_t vertices) {
  positions.resize(vertices);
  marks.resize(vertices);
  steering.resize(vertices * steering_width);
  quadrics.resize(vertices * quadric_width);
  deviations.resize(has_deviations ? vertices : 0);
  point_ids.resize(vertices);
  incidence.resize(vertices);
  changed.resize(vertices);
  for (Column& column : point_columns) column.resize(vertices);
}

template <class Real>
void WorkMesh<Real>::resize_tets(std::size_t count) {
  tets.resize(count);
  remembered.resize(count);
  if (removed.wanted()) removed.first.resize(count, kNoPoint);
  for (Column& column : cell_columns) column.resize(count);
}

template <class Real>
void mark_near_boundary(WorkMesh<Real>* mesh) {
  Vector<std::uint8_t>& marks = mesh->marks;
  for (const Tet& t : mesh->tets) {
    if (((marks[t[0]] | marks[t[1]] | marks[t[2]] | marks[t[3]]) & kOnBoundary) == 0) continue;
    for (const VertexId v : t) marks[v] |= kNearBoundary;
  }
}

template <class Real>
void drop_deleted(WorkMesh<Real>* mesh) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh->tets.size(); ++t) {
    if (is_deleted(mesh->tets[t])) continue;
    mesh->tets[kept] = mesh->tets[t];
    mesh->remembered[kept] = mesh->remembered[t];
    if (mesh->removed.wanted()) mesh->removed.first[kept] = mesh->removed.first[t];
    for (Column& column : mesh->cell_columns) column.move_row(t, kept);
    ++kept;
  }
  mesh->resize_tets(kept);
  const Vector<VertexId> new_ids = drop_unused_vertices(mesh);
  for (Tet& t : mesh->tets) {
    for (VertexId& v : t) v = new_ids[v];
  }
}

template struct WorkMesh<float>;
template struct WorkMesh<double>;
template void mark_near_boundary(WorkMesh<float>*);
template void mark_near_boundary(WorkMesh<double>*);
template void drop_deleted(WorkMesh<float>*);
template void drop_deleted(WorkMesh<double>*);

}  // namespace tetfusion
