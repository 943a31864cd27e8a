#include "mesh/work_mesh.h"

#include <algorithm>

namespace tetfusion {

template <class Real>
void count_incidence(WorkMesh<Real>* mesh) {
  mesh->incidence.assign(mesh->vertex_count(), 0);
  for (const Tet& t : mesh->tets) {
    for (const VertexId v : t) ++mesh->incidence[v];
  }
}

template <class Real>
Vector<VertexId> drop_unused_vertices(WorkMesh<Real>* mesh) {
  Vector<VertexId> new_ids(mesh->vertex_count());
  VertexId kept = 0;
  const std::size_t width = mesh->steering_width;
  for (std::size_t v = 0; v < new_ids.size(); ++v) {
    if (mesh->incidence[v] == 0 && (mesh->marks[v] & (kLocked | kOnInterface)) == 0) continue;
    const VertexId to = kept++;
    new_ids[v] = to;
    mesh->positions[to] = mesh->positions[v];
    mesh->marks[to] = mesh->marks[v];
    mesh->point_ids[to] = mesh->point_ids[v];
    mesh->incidence[to] = mesh->incidence[v];
    mesh->changed[to] = mesh->changed[v];
    std::copy_n(mesh->steering.data() + v * width, width, mesh->steering.data() + to * width);
  }
  mesh->positions.resize(kept);
  mesh->marks.resize(kept);
  mesh->point_ids.resize(kept);
  mesh->incidence.resize(kept);
  mesh->changed.resize(kept);
  mesh->steering.resize(kept * width);
  return new_ids;
}

template void count_incidence(WorkMesh<float>*);
template void count_incidence(WorkMesh<double>*);
template Vector<VertexId> drop_unused_vertices(WorkMesh<float>*);
template Vector<VertexId> drop_unused_vertices(WorkMesh<double>*);

}  // namespace tetfusion
