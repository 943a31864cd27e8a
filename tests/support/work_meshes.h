// Small meshes as the kernel takes them.
#pragma once

#include <algorithm>
#include <cstring>
#include <span>

#include "mesh/geometry.h"
#include "mesh/predicates.h"
#include "mesh/work_mesh.h"
#include "support/meshes.h"

namespace tetfusion::testing {

// A mesh whose ids are the geometry's, marked as `inspect` finds it; without steering values and
// columns.
WorkMesh<double> to_work_mesh(Geometry geometry);
WorkMesh<float> to_float_work_mesh(Geometry geometry);

// Counts the incidence of every vertex.
template <class Real>
void count_incidence(WorkMesh<Real>* mesh) {
  mesh->incidence.assign(mesh->vertex_count(), 0);
  for (const Tet& t : mesh->tets) {
    for (const VertexId v : t) ++mesh->incidence[v];
  }
}

// One steering value a vertex: f(x, y, z).
template <class Real, class F>
void steer_by(F&& f, WorkMesh<Real>* mesh) {
  mesh->steering_width = 1;
  mesh->steering.clear();
  for (const Vec3<Real>& p : mesh->positions) mesh->steering.push_back(f(p.x, p.y, p.z));
}

template <class T>
Column make_column(std::uint32_t components, const Vector<T>& values) {
  Column column{value_type_of<T>(), components, {}};
  column.rows.resize(values.size() * sizeof(T));
  std::memcpy(column.rows.data(), values.data(), column.rows.size());
  return column;
}

template <class T>
std::span<const T> values_of(const Column& column) {
  return {reinterpret_cast<const T*>(column.rows.data()), column.rows.size() / sizeof(T)};
}

// Gives every tetrahedron its number as the last cell column, so that it is known again.
template <class Real>
void number_tets(WorkMesh<Real>* mesh) {
  mesh->cell_columns.push_back(make_column(1, count_up<TetId>(mesh->tets.size())));
}
template <class Real>
std::span<const TetId> tet_numbers(const WorkMesh<Real>& mesh) {
  return values_of<TetId>(mesh.cell_columns.back());
}

template <class Real>
double volume(const WorkMesh<Real>& mesh) {
  double sum = 0;
  for (const Tet& t : mesh.tets) sum += determinant(mesh.positions, t).value / 6;
  return sum;
}

template <class Real>
bool all_positive(const WorkMesh<Real>& mesh) {
  return std::all_of(mesh.tets.begin(), mesh.tets.end(),
                     [&](const Tet& t) { return determinant(mesh.positions, t).sign() == 1; });
}

template <class Real>
Geometry to_geometry(const WorkMesh<Real>& mesh) {
  Geometry geometry;
  geometry.points = mesh.positions;
  geometry.tets = mesh.tets;
  return geometry;
}

}  // namespace tetfusion::testing
