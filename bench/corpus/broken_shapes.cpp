#include <algorithm>

#include "shape_tools.h"

namespace corpus {

namespace {

Shape face_of_three_cells(Numbers* n) {
  Shape s = kuhn(n);
  for (std::size_t i = 1 + n->below(3); i > 0; --i) {
    const Tet t = n->pick(s.tets);
    Point middle{0.1, 0.07, 0.03};
    for (const std::int64_t v : t) {
      for (std::size_t c = 0; c < 3; ++c)
        middle[c] += 0.25 * s.points[static_cast<std::size_t>(v)][c];
    }
    s.points.push_back(middle);
    s.tets.push_back({t[0], t[1], t[2], static_cast<std::int64_t>(s.points.size()) - 1});
  }
  return s;
}
Shape duplicates(Numbers* n) {
  Shape s = n->chance(0.5) ? five(n) : delaunay_ball(n);
  for (std::size_t i = 1 + n->below(6); i > 0; --i) {
    Tet t = n->pick(s.tets);
    if (n->chance(0.5)) std::swap(t[n->below(4)], t[n->below(4)]);
    s.tets.push_back(t);
  }
  return s;
}
Shape vertex_named_twice(Numbers* n) {
  Shape s = kuhn(n);
  for (std::size_t i = 1 + n->below(4); i > 0; --i) {
    Tet t = n->pick(s.tets);
    t[1] = t[0];
    if (n->chance(0.3)) t[2] = t[3];
    s.tets.push_back(t);
  }
  return s;
}
// Vertices pushed through their neighbours: inverted cells.
Shape folded(Numbers* n) {
  Shape s = n->chance(0.5) ? kuhn(n) : delaunay_ball(n);
  for (std::size_t i = 1 + n->below(4); i > 0; --i) {
    Point& p = s.points[n->below(s.points.size())];
    for (double& c : p) c += n->between(-1.5, 1.5);
  }
  return s;
}
Shape collapsed(Numbers* n) {
  Shape s = lattice({6, 5, 5}, true);
  for (std::size_t i = 1 + n->below(3); i > 0; --i) {
    const Point at{static_cast<double>(1 + n->below(4)), static_cast<double>(1 + n->below(4)), 2};
    s.points[nearest(s, at)] = s.points[nearest(s, {at[0] + 1, at[1], at[2]})];
  }
  return s;
}
Shape overlapping(Numbers* n) {
  const Shape a = five(n);
  return joined(a, moved(kuhn(n), {0.3, 0.4, 0.5}));
}
Shape one_place(Numbers* n) {
  Shape s;
  s.points.assign(20, in_ball(n));
  for (int i = 0; i < 30; ++i) {
    Tet t{};
    for (std::int64_t& v : t) v = static_cast<std::int64_t>(n->below(20));
    s.tets.push_back(t);
  }
  return s;
}
Shape soup(Numbers* n) {
  Shape s;
  for (int i = 0; i < 40; ++i) s.points.push_back(in_ball(n));
  for (int i = 0; i < 80; ++i) {
    Tet t{};
    for (std::int64_t& v : t) v = static_cast<std::int64_t>(n->below(40));
    s.tets.push_back(t);
  }
  return s;
}
// Holes, copies and turned cells in what was a good mesh.
Shape riddled(Numbers* n) {
  Shape s = n->chance(0.5) ? five(n) : delaunay_ball(n);
  std::erase_if(s.tets, [&](const Tet&) { return n->chance(0.1); });
  if (s.tets.empty()) return single(n);
  if (n->chance(0.5)) s.tets.push_back(n->pick(s.tets));
  if (n->chance(0.5)) s.points[n->below(s.points.size())][2] += 0.8;
  const Tet t = n->pick(s.tets);
  if (n->chance(0.5))
    s.points[static_cast<std::size_t>(t[0])] = s.points[static_cast<std::size_t>(t[1])];
  return s;
}

}  // namespace

std::vector<Kind> broken_kinds() {
  return {{"face of three cells", face_of_three_cells},
          {"duplicate cells", duplicates},
          {"vertex named twice", vertex_named_twice},
          {"folded over", folded},
          {"collapsed cells", collapsed},
          {"overlapping parts", overlapping},
          {"all in one place", one_place},
          {"soup", soup},
          {"riddled", riddled}};
}

}  // namespace corpus
