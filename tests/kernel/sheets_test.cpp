#include "kernel/sheets/sheets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <map>
#include <random>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "kernel/quadrics/quadric.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

using testing::five_split_box;
using testing::five_split_cube;
using testing::make_column;
using testing::to_work_mesh;

// Sheets of a mesh that does not change.
struct Fixed {
  explicit Fixed(WorkMesh<double> m, std::vector<std::uint32_t> regions = {}, double angle = 40)
      : mesh(std::move(m)) {
    balls.reset(mesh.vertex_count(), mesh.tets);
    sheets.begin(&mesh, &balls, regions, angle);
  }
  WorkMesh<double> mesh;
  LiveBalls balls;
  Sheets<double> sheets;
};

// How many sides of the box of that size a point lies on.
int sides(const Vec3<double>& p, double n) {
  const auto on = [n](double x) { return x == 0 || x == n ? 1 : 0; };
  return on(p.x) + on(p.y) + on(p.z);
}

TEST(Sheets, PlacesOnACube) {
  Fixed f(to_work_mesh(five_split_cube(4, 0.2, 3)));
  for (VertexId v = 0; v < f.mesh.vertex_count(); ++v) {
    const std::array<SheetFeature, 4> expected{SheetFeature::kNone, SheetFeature::kSmooth,
                                               SheetFeature::kLine, SheetFeature::kCorner};
    EXPECT_EQ(f.sheets.feature(v), expected[sides(f.mesh.positions[v], 4)]) << v;
  }
}

// Its edges are bent by 90 degrees, on whatever axes they lie. They are straight, and stay lines.
TEST(Sheets, TheFeatureAngleSaysWhatIsSharp) {
  for (const auto& [angle, corner] :
       {std::pair(90.0, SheetFeature::kCorner), {90.1, SheetFeature::kSmooth}}) {
    for (const double turn : {0.0, 0.3, 1.1}) {
      WorkMesh<double> mesh = to_work_mesh(five_split_cube(3, 0.2, 3));
      std::vector<int> at;
      for (Vec3<double>& p : mesh.positions) {
        at.push_back(sides(p, 3));
        p = {std::cos(turn) * p.x - std::sin(turn) * p.y,
             std::sin(turn) * p.x + std::cos(turn) * p.y, p.z};
      }
      Fixed f(std::move(mesh), {}, angle);
      for (VertexId v = 0; v < f.mesh.vertex_count(); ++v) {
        if (at[v] < 2) continue;
        EXPECT_EQ(f.sheets.feature(v), at[v] == 2 ? SheetFeature::kLine : corner)
            << angle << ", " << turn;
      }
    }
  }
}

// The triangles of a fan look out: their mean normal does, and their corners are a ring.
TEST(Sheets, FansLookOut) {
  Fixed f(to_work_mesh(five_split_cube(4, 0.2, 3)));
  int fans = 0;
  for (VertexId v = 0; v < f.mesh.vertex_count(); ++v) {
    const Vec3<double>& p = f.mesh.positions[v];
    SheetFan fan;
    if (sides(p, 4) == 0) {
      EXPECT_FALSE(f.sheets.find_fan(v, &fan));
      continue;
    }
    ASSERT_TRUE(f.sheets.find_fan(v, &fan));
    ++fans;
    Point3 normal{};
    for (std::size_t i = 0; i < fan.size(); ++i) {
      const auto to = [&](VertexId u) {
        const Vec3<double>& q = f.mesh.positions[u];
        return Point3{q.x - p.x, q.y - p.y, q.z - p.z};
      };
      const Point3 n = cross(to(fan.at(i)), to(fan.at(i + 1)));
      for (std::size_t k = 0; k < 3; ++k) normal[k] += n[k];
    }
    EXPECT_GT(dot(normal, {p.x - 2, p.y - 2, p.z - 2}), 0);
    SheetFan turned = fan;
    ASSERT_TRUE(turned.turn_to(fan.ring[2]));
    EXPECT_EQ(turned.ring[0], fan.ring[2]);
    EXPECT_EQ(turned.sharp[0], fan.sharp[2]);
    EXPECT_EQ(turned.at(fan.size() - 2), fan.ring[0]);
    EXPECT_FALSE(turned.turn_to(v));
  }
  EXPECT_EQ(fans, 5 * 5 * 5 - 3 * 3 * 3);
}

// Each region has one value or the other, in turns, where these mean the same.
template <class T>
WorkMesh<double> two_regions(Geometry g, double at, std::array<T, 2> low, std::array<T, 2> high) {
  WorkMesh<double> mesh = to_work_mesh(std::move(g));
  Vector<T> regions;
  for (const Tet& t : mesh.tets) {
    double x = 0;
    for (const VertexId v : t) x += mesh.positions[v].x / 4;
    regions.push_back((x < at ? low : high)[regions.size() % 2]);
  }
  mesh.cell_columns.push_back(make_column(1, regions));
  return mesh;
}

WorkMesh<double> two_regions(Geometry g, double at) {
  return two_regions<std::int32_t>(std::move(g), at, {7, 7}, {9, 9});
}

void expect_a_sheet_between(WorkMesh<double> mesh) {
  Fixed f(std::move(mesh), {0});
  for (VertexId v = 0; v < f.mesh.vertex_count(); ++v) {
    const Vec3<double>& p = f.mesh.positions[v];
    EXPECT_EQ(f.sheets.is_between_regions(v), p.x == 2);
    if (p.x != 2) continue;
    // Where it meets the boundary there are three sheets.
    EXPECT_EQ(f.sheets.feature(v),
              sides(p, 4) == 0 ? SheetFeature::kSmooth : SheetFeature::kCorner);
    for (const SheetEdge& e : f.sheets.edges_opposite(v)) {
      EXPECT_EQ(e.is_outer, f.mesh.positions[e.from].x != 2 || f.mesh.positions[e.to].x != 2);
    }
  }
}

TEST(Sheets, BetweenRegions) {
  expect_a_sheet_between(two_regions(five_split_cube(4), 2));
  Fixed none(two_regions(five_split_cube(4), 2));
  EXPECT_EQ(none.sheets.feature(2 + 2 * 5 + 2 * 25), SheetFeature::kNone);
}

TEST(Sheets, BetweenRegionsOfFloats) {
  const double nan = std::nan("");
  expect_a_sheet_between(
      two_regions<float>(five_split_cube(4), 2, {0.5F, 0.5F}, {0.5000001F, 0.5000001F}));
  expect_a_sheet_between(two_regions<double>(five_split_cube(4), 2, {0.0, -0.0}, {nan, -nan}));
}

TEST(Sheets, PlanesOfAFlatSheet) {
  Fixed f(to_work_mesh(five_split_cube(4)));
  std::array<float, quadric_size(0)> q{};
  f.sheets.add_planes(2 + 2 * 5, 0.25, q.data());  // in the middle of the side z = 0
  const float area = q[kQuadricW];
  EXPECT_GT(area, 0);
  EXPECT_EQ(q[5], area);
  EXPECT_EQ(value_at(reduce(q.data(), 0), {0.5F, -0.25F, 0.0F}), 0);
  EXPECT_EQ(value_at(reduce(q.data(), 0), {0.5F, -0.25F, 0.5F}), 0.25F * area);
}

// Through a plate one layer thick no two vertices of its two sides may become one, though a fan of
// each is sound; along a side they may.
TEST(Sheets, APlateIsNotPinched) {
  Fixed f(to_work_mesh(five_split_box(6, 6, 1)));
  int along = 0;
  for (VertexId v = 0; v < f.mesh.vertex_count(); ++v) {
    SheetFan fan;
    if (f.sheets.feature(v) != SheetFeature::kSmooth) continue;
    ASSERT_TRUE(f.sheets.find_fan(v, &fan));
    std::map<VertexId, bool> neighbours;
    for (const std::uint32_t entry : f.balls.of(v, f.mesh.incidence[v], f.mesh.tets)) {
      for (const VertexId u : f.mesh.tets[entry >> 2]) {
        if (u != v) neighbours[u] = f.mesh.positions[u].z == f.mesh.positions[v].z;
      }
    }
    for (const auto& [u, same_side] : neighbours) {
      EXPECT_EQ(same_side, std::ranges::count(fan.ring, u) == 1);
      const bool may = f.sheets.may_contract(v, fan, u);
      if (!same_side) {
        EXPECT_FALSE(may);
      } else {
        along += may ? 1 : 0;
      }
    }
  }
  EXPECT_GT(along, 50);
}

// On a tetrahedron, and on an edge whose ends have a third neighbour in common, the links meet.
TEST(Sheets, LinksThatMeet) {
  Fixed one(to_work_mesh(testing::single_tet()));
  SheetFan fan;
  ASSERT_TRUE(one.sheets.find_fan(0, &fan));
  EXPECT_EQ(fan.size(), 3u);
  EXPECT_FALSE(one.sheets.may_contract(0, fan, 1));
  Fixed two(to_work_mesh(testing::two_tets_sharing_face()));
  for (VertexId a = 0; a < 5; ++a) {
    ASSERT_TRUE(two.sheets.find_fan(a, &fan));
    for (const VertexId b : fan.ring) {
      EXPECT_FALSE(two.sheets.may_contract(a, fan, b) && fan.size() == 4 &&
                   two.mesh.incidence[b] == 2);
    }
  }
}

// A vertex's link, by the definition: vertices, and edges as pairs.
struct Link {
  std::set<VertexId> vertices;
  std::set<std::pair<VertexId, VertexId>> edges;
};

Link link_of(std::span<const Tet> tets, std::initializer_list<VertexId> simplex) {
  Link link;
  for (const Tet& tet : tets) {
    const auto has = [&](VertexId v) { return std::ranges::count(tet, v) == 1; };
    if (!std::ranges::all_of(simplex, has)) continue;
    std::vector<VertexId> others;
    for (const VertexId u : tet) {
      if (std::ranges::count(simplex, u) == 0) others.push_back(u);
    }
    std::ranges::sort(others);
    link.vertices.insert(others.begin(), others.end());
    for (std::size_t i = 0; i < others.size(); ++i) {
      for (std::size_t k = i + 1; k < others.size(); ++k) {
        link.edges.insert({others[i], others[k]});
      }
    }
  }
  return link;
}

template <class T>
std::set<T> common(const std::set<T>& a, const std::set<T>& b) {
  std::set<T> both;
  std::ranges::set_intersection(a, b, std::inserter(both, both.begin()));
  return both;
}

// In random parts of a box, with edges, pinches and holes: two vertices may become one exactly
// where their links share the link of the edge and nothing else, in the volume and on the sheet.
TEST(Sheets, MayContractByTheLinks) {
  int allowed = 0, refused_by_volume = 0, refused_by_sheet = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    Geometry part = five_split_cube(4, 0.2, seed);
    std::mt19937 random(seed);
    std::erase_if(part.tets, [&](const Tet&) { return random() % 8 < seed % 4; });
    Fixed f(to_work_mesh(part));
    for (VertexId a = 0; a < f.mesh.vertex_count(); ++a) {
      SheetFan fan;
      if (f.mesh.incidence[a] == 0 || !f.sheets.find_fan(a, &fan)) continue;
      for (const VertexId b : std::vector<VertexId>(fan.ring)) {
        SheetFan other;
        if (!f.sheets.find_fan(b, &other)) continue;
        const Link of_a = link_of(f.mesh.tets, {a}), of_b = link_of(f.mesh.tets, {b});
        const Link of_both = link_of(f.mesh.tets, {a, b});
        const bool by_volume = common(of_a.vertices, of_b.vertices) == of_both.vertices &&
                               common(of_a.edges, of_b.edges) == of_both.edges;
        const auto vertices = [](const SheetFan& of) {
          return std::set<VertexId>(of.ring.begin(), of.ring.end());
        };
        const auto edges = [](const SheetFan& of) {
          std::set<std::pair<VertexId, VertexId>> all;
          for (std::size_t i = 0; i < of.size(); ++i) {
            all.insert(std::minmax({of.at(i), of.at(i + 1)}));
          }
          return all;
        };
        const bool by_sheet = common(vertices(fan), vertices(other)).size() == 2 &&
                              common(edges(fan), edges(other)).empty();
        ASSERT_EQ(f.sheets.may_contract(a, fan, b), by_volume && by_sheet)
            << seed << ": " << a << ", " << b;
        allowed += by_volume && by_sheet ? 1 : 0;
        refused_by_volume += by_volume ? 0 : 1;
        refused_by_sheet += by_volume && !by_sheet ? 1 : 0;
      }
    }
  }
  EXPECT_GT(allowed, 100);
  EXPECT_GT(refused_by_volume, 100);
  EXPECT_GE(refused_by_sheet, 1);
}

}  // namespace
}  // namespace tetfusion
