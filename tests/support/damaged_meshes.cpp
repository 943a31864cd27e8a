#include "support/damaged_meshes.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "support/meshes.h"

namespace tetfusion::testing {

namespace {

class Damage {
 public:
  explicit Damage(std::uint64_t seed) : seed_(seed) {
    mesh_ = pick(2) == 0 ? five_split_box(4, 3, 3, 0.15, seed) : kuhn_box(3, 3, 2, 0.1, seed);
  }

  Geometry run() {
    if (pick(3) == 0) add_component();
    // Half of the meshes have only one or two kinds of defects: one hides the other.
    for (int kind = 0; kind < 9; ++kind) {
      const bool chosen = seed_ % 2 == 0 || pick(6) == 0;
      if (!chosen) continue;
      for (std::size_t n = pick(3); n > 0; --n) damage(kind);
    }
    return std::move(mesh_);
  }

 private:
  std::size_t pick(std::size_t size) {
    return static_cast<std::size_t>(uniform(seed_, ++next_) * static_cast<double>(size));
  }
  Tet& any_tet() { return mesh_.tets[pick(mesh_.tets.size())]; }
  VertexId any_vertex() { return static_cast<VertexId>(pick(points().size())); }
  Vector<Vec3<double>>& points() { return std::get<Vector<Vec3<double>>>(mesh_.points); }

  void add_component() {
    const auto shift = static_cast<VertexId>(points().size());
    const Geometry ball = icosahedron_ball();
    for (VertexId v = 0; v < point_count(ball.points); ++v) {
      const Point p = point(ball, v);
      points().push_back({p.x + 20, p.y, p.z});
    }
    for (const Tet& t : ball.tets) {
      mesh_.tets.push_back({t[0] + shift, t[1] + shift, t[2] + shift, t[3] + shift});
    }
  }

  void damage(int kind) {
    switch (kind) {
      case 0:
        mesh_.tets.erase(mesh_.tets.begin() + static_cast<std::ptrdiff_t>(pick(mesh_.tets.size())));
        break;
      case 1:
        for (std::size_t n = pick(9); n > 0; --n) flip_winding(&any_tet());
        break;
      case 2: {  // a copy, perhaps of a copy, perhaps wound otherwise
        Tet t = any_tet();
        if (pick(2) == 0) flip_winding(&t);
        mesh_.tets.push_back(t);
        if (pick(3) == 0) mesh_.tets.push_back(t);
        break;
      }
      case 3: {  // one more cell on a face
        Tet t = any_tet();
        points().push_back({-1 - uniform(seed_, ++next_), 0.3, 0.2});
        t[pick(4)] = static_cast<VertexId>(points().size() - 1);
        mesh_.tets.push_back(t);
        break;
      }
      case 4: {  // names a vertex twice
        Tet t = any_tet();
        t[3] = t[pick(3)];
        mesh_.tets.push_back(t);
        break;
      }
      case 5:  // folds
        points()[any_vertex()].x += 3 * uniform(seed_, ++next_);
        break;
      case 6: {  // flat, without a rounding error
        const Tet t = any_tet();
        for (const VertexId v : t) points()[v].z = points()[t[0]].z;
        break;
      }
      case 7: {  // a cell with any four vertices
        mesh_.tets.push_back({any_vertex(), any_vertex(), any_vertex(), any_vertex()});
        break;
      }
      default: {  // two vertices become one: pinches, edges of four triangles, flat cells
        const VertexId from = any_vertex(), to = any_vertex();
        for (Tet& t : mesh_.tets) std::replace(t.begin(), t.end(), from, to);
        break;
      }
    }
  }

  Geometry mesh_;
  std::uint64_t seed_;
  std::uint64_t next_ = 1000;
};

}  // namespace

Geometry damaged_mesh(std::uint64_t seed) { return Damage(seed).run(); }

void shuffle(Geometry* mesh, std::uint64_t seed) {
  auto& points = std::get<Vector<Vec3<double>>>(mesh->points);
  Vector<VertexId> new_id = count_up<VertexId>(points.size());
  std::uint64_t next = 0;
  const auto below = [&](std::size_t n) {
    return static_cast<std::size_t>(uniform(seed, ++next) * static_cast<double>(n));
  };
  for (std::size_t i = new_id.size(); i > 1; --i) std::swap(new_id[i - 1], new_id[below(i)]);
  const auto old = points;
  for (std::size_t v = 0; v < old.size(); ++v) points[new_id[v]] = old[v];
  for (Tet& t : mesh->tets) {
    for (VertexId& v : t) v = new_id[v];
  }
  auto& tets = mesh->tets;
  for (std::size_t i = tets.size(); i > 1; --i) std::swap(tets[i - 1], tets[below(i)]);
}

}  // namespace tetfusion::testing
