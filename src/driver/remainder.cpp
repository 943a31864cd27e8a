#include "driver/remainder.h"

#include <algorithm>
#include <array>
#include <limits>

#include "kernel/fit/cell_means.h"
#include "mesh/predicates.h"

namespace tetfusion {

namespace {

constexpr std::size_t kBlock = 64;
constexpr std::uint32_t kUnreached = std::numeric_limits<std::uint32_t>::max();

// Fewer cells, or vertices, tell nothing, unless the whole part has no more.
constexpr double kFewCells = 20;
constexpr double kFewCellsOfAKind = 4;
constexpr double kFewVertices = 64;

bool are_enough(double count, double wanted, double in_all) {
  return count >= std::min(wanted, in_all);
}

template <class Real>
bool has_corner(const WorkMesh<Real>& mesh, const Tet& t, VertexMark mark) {
  return std::any_of(t.begin(), t.end(), [&](VertexId v) { return (mesh.marks[v] & mark) != 0; });
}

bool holds(const std::array<Vec3<double>, 4>& corners, const Vec3<double>& p) {
  for (std::size_t k = 0; k < 4; ++k) {
    std::array<Vec3<double>, 4> at = corners;
    at[k] = p;
    if (determinant(at[0], at[1], at[2], at[3]).value < 0) return false;
  }
  return true;
}

}  // namespace

template <class Real>
Remainder<Real>::Remainder(const WorkMesh<Real>& part) {
  find_depths(part);
  find_centres(part);
}

// Neighbours are near each other in the part, so a few sweeps are enough.
template <class Real>
void Remainder<Real>::find_depths(const WorkMesh<Real>& part) {
  Vector<std::uint32_t> of_vertex(part.vertex_count(), kUnreached);
  for (std::size_t v = 0; v < of_vertex.size(); ++v) {
    if ((part.marks[v] & kOnInterface) != 0) of_vertex[v] = 0;
  }
  const auto least_of = [&](const Tet& t) {
    return std::min({of_vertex[t[0]], of_vertex[t[1]], of_vertex[t[2]], of_vertex[t[3]]});
  };
  for (bool changes = true; changes;) {
    changes = false;
    for (const Tet& t : part.tets) {
      const std::uint32_t least = least_of(t);
      if (least == kUnreached) continue;
      for (const VertexId v : t) {
        if (of_vertex[v] <= least + 1) continue;
        of_vertex[v] = least + 1;
        changes = true;
      }
    }
  }
  for (const std::uint32_t depth : of_vertex) {
    if (depth != kUnreached) deepest_ = std::max(deepest_, depth);
  }
  boundary_vertices_.assign(deepest_ + 1, 0);
  for (std::size_t v = 0; v < of_vertex.size(); ++v) {
    if ((part.marks[v] & kOnBoundary) != 0) ++boundary_vertices_[std::min(of_vertex[v], deepest_)];
  }
  for (const Tet& t : part.tets) depths_.push_back(std::min(least_of(t), deepest_));
}

template <class Real>
void Remainder<Real>::find_centres(const WorkMesh<Real>& part) {
  for (const Tet& t : part.tets) {
    const Vec3<double> c = centre_of(part.positions, t);
    if (centres_.size() % kBlock == 0) blocks_.push_back({c, c});
    if (centres_.size() % (kBlock * kBlock) == 0) groups_.push_back({c, c});
    blocks_.back().add(c);
    groups_.back().add(c);
    centres_.push_back(c);
  }
}

template <class Real>
void Remainder<Real>::Bounds::add(const Vec3<double>& p) {
  lo = {std::min(lo.x, p.x), std::min(lo.y, p.y), std::min(lo.z, p.z)};
  hi = {std::max(hi.x, p.x), std::max(hi.y, p.y), std::max(hi.z, p.z)};
}

template <class Real>
bool Remainder<Real>::Bounds::meets(const Bounds& other) const {
  return lo.x <= other.hi.x && other.lo.x <= hi.x && lo.y <= other.hi.y && other.lo.y <= hi.y &&
         lo.z <= other.hi.z && other.lo.z <= hi.z;
}

// Centres in the cell that no other one has taken.
template <class Real>
void Remainder<Real>::find_inside(const WorkMesh<Real>& mesh, const Tet& tet,
                                  Vector<std::uint8_t>* taken,
                                  std::vector<std::uint32_t>* found) const {
  std::array<Vec3<double>, 4> corners;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec3<Real>& p = mesh.positions[tet[k]];
    corners[k] = {p.x, p.y, p.z};
  }
  Bounds box{corners[0], corners[0]};
  for (const Vec3<double>& p : corners) box.add(p);
  found->clear();
  const auto take = [&](std::size_t block) {
    const std::size_t end = std::min(centres_.size(), (block + 1) * kBlock);
    for (std::size_t i = block * kBlock; i < end; ++i) {
      const Bounds centre{centres_[i], centres_[i]};
      if ((*taken)[i] != 0 || !box.meets(centre) || !holds(corners, centres_[i])) continue;
      (*taken)[i] = 1;
      found->push_back(static_cast<std::uint32_t>(i));
    }
  };
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    if (!box.meets(groups_[g])) continue;
    const std::size_t end = std::min(blocks_.size(), (g + 1) * kBlock);
    for (std::size_t b = g * kBlock; b < end; ++b) {
      if (box.meets(blocks_[b])) take(b);
    }
  }
}

template <class Real>
auto Remainder<Real>::layers_of(const WorkMesh<Real>& left) const -> std::vector<Layer> {
  std::vector<Layer> layers(deepest_ + 1);
  Vector<std::uint8_t> taken(centres_.size(), 0);
  std::vector<std::uint32_t> found;
  double cells = 0, empty = 0;
  for (const Tet& t : left.tets) {
    find_inside(left, t, &taken, &found);
    if (!has_corner(left, t, kOnInterface)) {
      ++cells;
      if (found.empty()) ++empty;
    }
    const bool at_boundary = has_corner(left, t, kOnBoundary);
    const double share = found.empty() ? 0 : 1 / static_cast<double>(found.size());
    for (const std::uint32_t i : found) {
      Layer& layer = layers[depths_[i]];
      (at_boundary ? layer.cells_at_boundary : layer.cells_inside) += share;
      ++(at_boundary ? layer.tets_at_boundary : layer.tets_inside);
    }
  }
  // Those in which no centre came to lie count with the others.
  const double more = empty < cells ? cells / (cells - empty) : 1;
  Layer deeper;
  for (std::size_t d = layers.size(); d-- > 0;) {
    Layer& layer = layers[d];
    layer.boundary_vertices = deeper.boundary_vertices + boundary_vertices_[d];
    layer.cells_inside = deeper.cells_inside + more * layer.cells_inside;
    layer.cells_at_boundary = deeper.cells_at_boundary + more * layer.cells_at_boundary;
    layer.tets_inside += deeper.tets_inside;
    layer.tets_at_boundary += deeper.tets_at_boundary;
    deeper = layer;
  }
  return layers;
}

template <class Real>
double Remainder<Real>::of_mesh(const WorkMesh<Real>& left, double tets,
                                double boundary_vertices) const {
  if (centres_.empty()) return tets;
  const std::vector<Layer> layers = layers_of(left);
  const Layer& all = layers.front();
  double least = tets;
  for (const Layer& l : layers) {
    if (!are_enough(l.cells_inside + l.cells_at_boundary, kFewCells,
                    all.cells_inside + all.cells_at_boundary) ||
        !are_enough(l.cells_inside, kFewCellsOfAKind, all.cells_inside) ||
        !are_enough(l.cells_at_boundary, kFewCellsOfAKind, all.cells_at_boundary) ||
        !are_enough(l.boundary_vertices, kFewVertices, all.boundary_vertices)) {
      break;
    }
    const double times = l.boundary_vertices > 0 ? boundary_vertices / l.boundary_vertices : 0;
    const double inside = std::max(0.0, tets - times * l.tets_at_boundary);
    const double density = l.tets_inside > 0 ? l.cells_inside / l.tets_inside : 0;
    least = std::min(least, times * l.cells_at_boundary + density * inside);
  }
  return least;
}

template class Remainder<float>;
template class Remainder<double>;

}  // namespace tetfusion
