#include "mesh/vertex_tets.h"

#include "mesh/incidence.h"

namespace tetfusion {

void build_vertex_tets(std::size_t vertices, std::span<const Tet> tets, VertexTets* out) {
  build_incidence<4>(vertices, tets, &out->offsets, &out->entries);
}

}  // namespace tetfusion
