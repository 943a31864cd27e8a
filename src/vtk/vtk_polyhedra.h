// Polyhedra, which are cut from a point in their middle: it sees all of a face where no vertex
// need do so.
#pragma once

#include <vtkIdList.h>
#include <vtkUnstructuredGrid.h>

#include <cstddef>
#include <span>
#include <string>

#include "base/error.h"
#include "vtk/vtk_load.h"

namespace tetfusion {

// Gives each polyhedron that stays a point of its own, behind the points of its piece, and says in
// file->centres which. It lies where the weights of its corners, by the volumes round them, put it;
// floating-point arrays have the values there that these weights give, so that what is linear stays
// so, others those of the first corner. Nothing is changed in place. Throws InvalidMesh where a
// cell has a vertex id that is out of range.
void add_centres(const std::string& path, LoadedFile* file);

// Calls f(vertices) for each face of a polyhedron. `stream` is scratch memory.
template <class F>
void for_each_face(vtkUnstructuredGrid* grid, vtkIdType cell, vtkIdList* stream, F f) {
  stream->Reset();
  grid->GetFaceStream(cell, stream);  // how many; of each its size and its vertices
  const auto size = static_cast<std::size_t>(stream->GetNumberOfIds());
  const std::span<const vtkIdType> ids(stream->GetPointer(0), size);
  for (std::size_t at = 1; at < size;) {
    const auto vertices = static_cast<std::size_t>(ids[at]);
    if (vertices >= size - at) throw InvalidMesh("a polyhedron's faces are damaged");
    f(ids.subspan(at + 1, vertices));
    at += 1 + vertices;
  }
}

}  // namespace tetfusion
