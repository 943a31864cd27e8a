#include "driver/import/import.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "base/resources.h"
#include "mesh/inspection/inspect.h"
#include "mesh/split_cells.h"
#include "support/cut_meshes.h"
#include "support/damaged_meshes.h"
#include "support/import.h"
#include "support/mesh_file.h"
#include "support/meshes.h"
#include "support/temp_dir.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

using testing::contents;
using testing::Import;
using testing::ImportChoice;
using testing::MeshFile;
using testing::rich_box;

constexpr std::uint64_t kOneChunk = 1'000'000;

void expect_same_facts(const InputFacts& a, const InputFacts& b) {
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.tets, b.tets);
  EXPECT_EQ(a.boundary_faces, b.boundary_faces);
  EXPECT_NEAR(a.volume, b.volume, 1e-11 * std::abs(b.volume));
  EXPECT_EQ(a.rewound, b.rewound);
  EXPECT_EQ(a.degenerate, b.degenerate);
  EXPECT_EQ(a.inverted, b.inverted);
  EXPECT_EQ(a.duplicate_tets, b.duplicate_tets);
  EXPECT_EQ(a.nonconforming_faces, b.nonconforming_faces);
  EXPECT_EQ(a.nonmanifold_edges, b.nonmanifold_edges);
  EXPECT_EQ(a.unused_points, b.unused_points);
  EXPECT_EQ(a.merged_points, b.merged_points);
  EXPECT_EQ(a.ghost_cells, b.ghost_cells);
  EXPECT_EQ(a.locked_vertices, b.locked_vertices);
  EXPECT_EQ(a.between_regions, b.between_regions);
  EXPECT_EQ(a.carried_vertices, b.carried_vertices);
}

// Marks by the points' ids in the file; 0 for those of no tetrahedron.
template <class Real>
Vector<std::uint8_t> marks_by_id(const WorkMesh<Real>& mesh, std::size_t points) {
  Vector<std::uint8_t> marks;
  marks.assign(points, 0);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    marks[mesh.point_ids[v]] = mesh.marks[v] & (kOnBoundary | kLocked);
  }
  return marks;
}

// What inspect() and the cells of lower dimension say.
Vector<std::uint8_t> expected_marks(const Geometry& geometry, const Inspection& inspection) {
  Vector<std::uint8_t> marks;
  std::set<VertexId> used;
  for (const Tet& t : geometry.tets) used.insert(t.begin(), t.end());
  for (VertexId v = 0; v < point_count(geometry.points); ++v) {
    const std::uint8_t flags = inspection.vertex_flags[v];
    const int boundary = (flags & kBoundaryVertex) != 0 ? kOnBoundary : 0;
    const int locked = (flags & (kBrokenVertex | kCarriedVertex)) != 0 ? kLocked : 0;
    marks.push_back(used.contains(v) ? static_cast<std::uint8_t>(boundary | locked) : 0);
  }
  return marks;
}

class ImportMesh : public ::testing::Test {
 protected:
  ~ImportMesh() override { set_thread_count(0); }

  // Imports in one chunk, as a reference, and in chunks of other sizes.
  template <class Real = double>
  std::unique_ptr<Import<Real>> expect_same_in_chunks(const MeshFile& file,
                                                      ImportChoice choice = {}) {
    file.write(path);
    choice.chunk_tets = kOneChunk;
    auto whole = std::make_unique<Import<Real>>(path, choice);
    EXPECT_TRUE(whole->imported.mesh.whole);
    const std::vector<std::string> expected = contents(whole->joined());
    for (const std::uint64_t chunk_tets : {3000, 400, 37}) {
      SCOPED_TRACE(chunk_tets);
      choice.chunk_tets = chunk_tets;
      choice.on_disk = chunk_tets == 400;
      set_thread_count(chunk_tets == 37 ? 3 : 1);
      const Import<Real> cut(path, choice);
      const std::uint64_t cells = file.cells();
      EXPECT_EQ(cut.imported.mesh.chunks, (cells + chunk_tets - 1) / chunk_tets);
      expect_same_facts(cut.imported.facts, whole->imported.facts);
      const auto chunks = cut.chunks();
      testing::expect_chunks_know_their_vertices(chunks);
      expect_sizes(cut);
      EXPECT_EQ(contents(testing::join(chunks)) == expected, true);
      EXPECT_EQ(cut.imported.mesh.tets, whole->imported.mesh.tets);
      expect_same_lower(cut.imported.lower, whole->imported.lower);
      cut.scratch->remove();
    }
    return whole;
  }

  // What the mesh says of its chunks before they are gathered.
  template <class Real>
  void expect_sizes(const Import<Real>& import) {
    const MacroLod<Real>& mesh = import.imported.mesh;
    if (mesh.whole) return;
    const auto chunks = import.chunks();
    ASSERT_EQ(mesh.sizes.size(), chunks.size());
    for (std::uint32_t c = 0; c < chunks.size(); ++c) {
      EXPECT_EQ(mesh.sizes[c].tets, chunks[c].tets.size());
      const auto is_free_now = [&](const InterfaceReport& r) { return r.low == c && r.high == c; };
      const auto is_free = [](std::uint8_t marks) { return (marks & kOnInterface) == 0; };
      EXPECT_EQ(static_cast<std::ptrdiff_t>(mesh.sizes[c].free_points) +
                    std::ranges::count_if(mesh.interface.entries(), is_free_now),
                std::ranges::count_if(chunks[c].marks, is_free));
    }
  }

  template <class Real>
  void expect_same_lower(const LowerPart<Real>& a, const LowerPart<Real>& b) {
    EXPECT_EQ(a.cells.types, b.cells.types);
    EXPECT_EQ(a.cells.offsets, b.cells.offsets);
    EXPECT_EQ(a.cells.connectivity, b.cells.connectivity);
    EXPECT_EQ(a.vertices, b.vertices);
    EXPECT_EQ(a.loose_ids, b.loose_ids);
    for (std::size_t c = 0; c < b.columns.size(); ++c) {
      EXPECT_EQ(a.columns[c].rows, b.columns[c].rows);
    }
    for (std::size_t c = 0; c < b.loose_columns.size(); ++c) {
      EXPECT_EQ(a.loose_columns[c].rows, b.loose_columns[c].rows);
    }
  }

  testing::TempDir folder = testing::TempDir::in_memory();
  std::string path = folder.file("in.vtu");
};

TEST_F(ImportMesh, TakesAllThatAFileHas) {
  const MeshFile file = rich_box(10);
  const auto whole = expect_same_in_chunks(file);
  Geometry geometry = file.geometry;
  const Inspection inspection = inspect(geometry);
  const WorkMesh<double> mesh = whole->joined();
  EXPECT_EQ(marks_by_id(mesh, file.points()), expected_marks(geometry, inspection));
  const auto& points = std::get<Vector<Vec3<double>>>(file.geometry.points);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    EXPECT_EQ(mesh.positions[v].x, points[mesh.point_ids[v]].x);
    for (std::size_t c = 0; c < file.point_arrays.size(); ++c) {
      const Column& column = mesh.point_columns[c];
      EXPECT_EQ(column.type, file.point_arrays[c].info.type);
      const auto* row = file.point_arrays[c].bytes.data() + mesh.point_ids[v] * column.stride();
      EXPECT_TRUE(std::equal(row, row + column.stride(), &column.rows[v * column.stride()]));
    }
  }
  const auto numbers = testing::values_of<std::int16_t>(mesh.cell_columns[2]);
  const auto stress = testing::values_of<double>(mesh.cell_columns[1]);
  std::set<std::int16_t> seen(numbers.begin(), numbers.end());
  EXPECT_EQ(seen.size(), file.geometry.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    EXPECT_EQ(stress[3 * t], numbers[t]);
    Tet ids = mesh.tets[t];
    for (VertexId& v : ids) v = mesh.point_ids[v];
    EXPECT_EQ(ids, file.geometry.tets[static_cast<std::size_t>(numbers[t])]);
  }

  const InputFacts& facts = whole->imported.facts;
  EXPECT_EQ(facts.points, 11u * 11 * 11 + 2);
  EXPECT_EQ(facts.unused_points, 5u);
  EXPECT_EQ(facts.tets, 5000u);
  EXPECT_EQ(facts.boundary_faces, 1200u);
  EXPECT_NEAR(facts.volume, 1000, 1e-9);
  const LowerPart<double>& lower = whole->imported.lower;
  EXPECT_EQ(lower.cells.connectivity, file.geometry.lower.connectivity);
  EXPECT_EQ(lower.loose_ids, (Vector<VertexId>{11 * 11 * 11 + 3, 11 * 11 * 11 + 5}));
  EXPECT_EQ(lower.loose_positions.at(1).y, 5);
}

TEST_F(ImportMesh, TakesFloats) {
  MeshFile file = rich_box(9);
  file.geometry = testing::to_float(file.geometry);
  const auto whole = expect_same_in_chunks<float>(file, {.regions = {"material"}});
  EXPECT_GT(whole->imported.facts.locked_vertices, 50u);
  EXPECT_GT(whole->imported.facts.between_regions, 50u);
}

// Each reason for itself; what lies on the boundary stays anyway.
TEST_F(ImportMesh, CountsWhatHoldsVertices) {
  MeshFile file;
  file.geometry = testing::kuhn_box(6, 6, 6);
  const auto point = [](VertexId x, VertexId y, VertexId z) { return x + 7 * (y + 7 * z); };
  file.geometry.lower.types = {kVtkTriangle, kVtkLine};
  file.geometry.lower.offsets = {0, 3, 5};
  file.geometry.lower.connectivity = {point(2, 3, 3), point(3, 3, 3), point(3, 4, 3),
                                      point(0, 3, 3), point(0, 4, 3)};
  const auto whole = expect_same_in_chunks<double>(file, {});
  EXPECT_EQ(whole->imported.facts.locked_vertices, 3u);
  EXPECT_EQ(whole->imported.facts.carried_vertices, 3u);
  EXPECT_EQ(whole->imported.facts.between_regions, 0u);
}

TEST_F(ImportMesh, LocksVerticesWithoutASteeringValue) {
  MeshFile file = rich_box(8);
  auto values = file.point_arrays[0].as<float>();
  std::set<VertexId> odd;
  for (VertexId v = 0; v < 9 * 9 * 9; v += 13) {
    values[v] = v % 2 == 0 ? std::nanf("") : std::numeric_limits<float>::infinity();
    odd.insert(v);
  }
  const auto whole = expect_same_in_chunks(file, {.steering = {"f", "tensor"}});
  EXPECT_EQ(whole->layout.steering_width, 7u);
  const auto marks = marks_by_id(whole->joined(), file.points());
  for (const VertexId v : odd) EXPECT_NE(marks[v] & kLocked, 0) << v;
  EXPECT_LT(std::ranges::count_if(marks, [](int m) { return (m & kLocked) != 0; }), 100);
}

TEST_F(ImportMesh, CellArraysSteerAlikeInAllChunks) {
  expect_same_in_chunks(rich_box(7), {.steering = {"cell:stress"}});
}

TEST_F(ImportMesh, DropsGhostCells) {
  MeshFile file = rich_box(8);
  const std::size_t tets = file.geometry.tets.size();
  file.cell_arrays.push_back(testing::make_array<std::uint8_t>(
      "vtkGhostType", file.cells(), 1, [&](auto i, auto) { return i >= tets - 700 && i < tets; }));
  const auto whole = expect_same_in_chunks(file);
  EXPECT_EQ(whole->imported.facts.ghost_cells, 700u);
  EXPECT_EQ(whole->imported.facts.tets, tets - 700);
  Geometry rest = file.geometry;
  rest.tets.resize(tets - 700);
  const Inspection inspection = inspect(rest);
  EXPECT_EQ(marks_by_id(whole->joined(), file.points()), expected_marks(rest, inspection));
  EXPECT_EQ(whole->imported.facts.boundary_faces, inspection.boundary_faces);
  EXPECT_EQ(whole->layout.cell_columns.size(), 3u);
}

// A vertex is locked where tetrahedra meet that differ in any of the arrays, also if they lie in
// different chunks.
TEST_F(ImportMesh, LocksBetweenRegions) {
  MeshFile file = rich_box(8);
  file.geometry.lower = {};
  file.cell_arrays = {
      testing::make_array<std::int8_t>("a", file.cells(), 1,
                                       [](auto t, auto) { return t % 640 < 320 ? 1 : -1; }),
      testing::make_array<std::uint64_t>("b", file.cells(), 1,
                                         [](auto t, auto) { return (t / 640) << 40; }),
      // The same as "a": zeros of either sign, and what is no number.
      testing::make_array<float>("c", file.cells(), 1,
                                 [](std::size_t t, auto) {
                                   const float sign = t % 2 == 0 ? -1.0F : 1.0F;
                                   return sign * (t % 640 < 320 ? 0.0F : std::nanf(""));
                                 }),
      testing::make_array<double>("d", file.cells(), 1, [](std::size_t t, auto) {
        return 1 + 0x1p-52 * static_cast<double>(t / 640);
      })};
  const auto a = file.cell_arrays[0].as<std::int8_t>();
  const auto b = file.cell_arrays[1].as<std::uint64_t>();
  for (const std::vector<std::string>& names :
       {std::vector<std::string>{"a"}, {"b", "a"}, {"c"}, {"d", "c"}}) {
    const bool both = names.size() == 2;
    ImportChoice choice;
    choice.regions = names;
    const auto whole = expect_same_in_chunks(file, choice);
    std::vector<std::set<std::pair<int, std::uint64_t>>> regions(file.points());
    for (std::size_t t = 0; t < file.geometry.tets.size(); ++t) {
      for (const VertexId v : file.geometry.tets[t]) regions[v].insert({a[t], both ? b[t] : 0});
    }
    const auto marks = marks_by_id(whole->joined(), file.points());
    std::size_t locked = 0;
    for (std::size_t v = 0; v < file.points(); ++v) {
      EXPECT_EQ((marks[v] & kLocked) != 0, regions[v].size() > 1) << v;
      locked += regions[v].size() > 1 ? 1 : 0;
    }
    EXPECT_GT(locked, 100u);
    choice.surfaces_move = true;
    const auto counted = expect_same_in_chunks(file, choice);
    EXPECT_EQ(counted->imported.facts.locked_vertices, 0u);
    EXPECT_EQ(counted->imported.facts.between_regions, whole->imported.facts.between_regions);
  }
}

// Small meshes with every kind of defect: what is broken is locked, whatever the chunks.
TEST_F(ImportMesh, JudgesDamagedMeshesAsTheWhole) {
  std::size_t late_locks = 0, locked = 0;
  for (std::uint64_t seed = 1; seed <= 120; ++seed) {
    SCOPED_TRACE(seed);
    MeshFile file;
    file.geometry = testing::damaged_mesh(seed);
    file.write(path);
    Geometry geometry = file.geometry;
    const Inspection inspection = inspect(geometry);
    const Vector<std::uint8_t> expected = expected_marks(geometry, inspection);
    // Where that is not so, another side of a fold may count as the inverted one.
    const bool sides_are_clear = inspection.foldover_faces == 0 || inspection.overfull_faces == 0;
    for (const std::uint64_t chunk_tets : {kOneChunk, std::uint64_t{60}, std::uint64_t{9}}) {
      const Import<double> cut(path, {.chunk_tets = chunk_tets});
      const InputFacts& facts = cut.imported.facts;
      EXPECT_EQ(facts.degenerate, inspection.degenerate);
      EXPECT_EQ(facts.duplicate_tets, inspection.duplicate_tets);
      EXPECT_EQ(facts.nonconforming_faces, inspection.foldover_faces + inspection.overfull_faces);
      EXPECT_EQ(facts.nonmanifold_edges, inspection.nonmanifold_edges);
      EXPECT_EQ(facts.boundary_faces, inspection.boundary_faces);
      EXPECT_NEAR(facts.volume, inspection.volume, 1e-11 * std::abs(inspection.volume));
      if (!sides_are_clear) continue;
      EXPECT_EQ(facts.inverted, inspection.inverted);
      EXPECT_EQ(facts.rewound, inspection.rewound);
      EXPECT_EQ(marks_by_id(cut.joined(), file.points()), expected);
      locked += facts.locked_vertices;
      late_locks += cut.imported.mesh.locks.size();
    }
    if (HasFailure()) break;
  }
  EXPECT_GT(locked, 200u);
  EXPECT_GT(late_locks, 0u);
}

// What the first round is told of the chunks decides what it does, so it must not depend on how the
// file is read, which depends on the memory.
TEST_F(ImportMesh, WindowsOfAnySizeMakeTheSameFirstRound) {
  MeshFile file = testing::rich_box(14);
  file.write(path);
  const Import<double> one(path, {.chunk_tets = 2000, .first_round = true});
  const Import<double> many(path, {.chunk_tets = 2000, .first_round = true, .window = 300});
  ASSERT_GT(one.shares.size(), 5u);
  EXPECT_EQ(one.shares, many.shares);
  EXPECT_EQ(one.shares.back(), file.geometry.tets.size());
}

// The curve that cuts the mesh would have one cell for all of it else.
TEST_F(ImportMesh, APointFarAwayLeavesTheChunksAsLargeAsOthers) {
  MeshFile file;
  file.geometry = testing::five_split_cube(20, 0.1);
  auto& points = std::get<Vector<Vec3<double>>>(file.geometry.points);
  points.push_back({-3e9, 1e8, 5});
  // Some of these are among the samples that the curve is cut by.
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  points.insert(points.end(), 300, {kNone, kNone, kNone});
  file.write(path);
  const Import<double> cut(path, {.chunk_tets = 5000});
  EXPECT_EQ(cut.imported.facts.unused_points, 301u);
  EXPECT_EQ(cut.imported.box.lo.x, 0);
  EXPECT_LT(cut.imported.box.hi.y, 21);
  const auto chunks = cut.chunks();
  EXPECT_EQ(chunks.size(), 8u);
  for (const WorkMesh<double>& chunk : chunks) EXPECT_LT(chunk.tets.size(), 7000u);
}

// Nor does one that is used, in the cuts that follow.
TEST_F(ImportMesh, AVertexFarAwayLeavesTheNextChunksAsLargeAsOthers) {
  MeshFile file;
  file.geometry = testing::five_split_cube(20, 0.1);
  for (auto& p : std::get<Vector<Vec3<double>>>(file.geometry.points)) {
    if (p.x == 20 && p.y == 20 && p.z == 20) p = {6e8, 6e8, 6e8};
  }
  file.write(path);
  const Import<double> cut(path, {.chunk_tets = 5000, .first_round = true});
  ASSERT_TRUE(cut.imported.first_round_done);
  EXPECT_GT(cut.imported.box.hi.x, 5e8);
  const auto chunks = cut.chunks();
  EXPECT_GT(chunks.size(), 3u);
  for (const WorkMesh<double>& chunk : chunks) EXPECT_LT(chunk.tets.size(), 7000u);
}

// What was cut out of a larger mesh often has all the points of that still.
TEST_F(ImportMesh, PointsThatNobodyUsesLeaveTheChunksAsLargeAsOthers) {
  MeshFile file;
  file.geometry = testing::corner_of_a_cube(32);
  file.write(path);
  const Import<double> cut(path, {.chunk_tets = 5000});
  EXPECT_EQ(cut.imported.facts.unused_points, 33u * 33 * 33 - 17 * 17 * 17);
  const auto chunks = cut.chunks();
  EXPECT_EQ(chunks.size(), 5u);
  for (const WorkMesh<double>& chunk : chunks) {
    EXPECT_GT(chunk.tets.size(), 3000u);
    EXPECT_LT(chunk.tets.size(), 7000u);
  }
}

// The numbers of points in use say nothing: every seventh is looked at, and of none is the number
// a multiple of seven.
TEST_F(ImportMesh, CutsByEverySoManyPointsInUse) {
  MeshFile file;
  file.geometry = testing::five_split_cube(32, 0.1);
  auto& points = std::get<Vector<Vec3<double>>>(file.geometry.points);
  Vector<Vec3<double>> spread(7 * points.size(), Vec3<double>{1, 1, 1});
  for (std::size_t p = 0; p < points.size(); ++p) spread[7 * p + 1] = points[p];
  points = std::move(spread);
  for (Tet& t : file.geometry.tets) {
    for (VertexId& v : t) v = 7 * v + 1;
  }
  file.write(path);
  const auto chunks = Import<double>(path, {.chunk_tets = 20'000}).chunks();
  EXPECT_EQ(chunks.size(), 9u);
  for (const WorkMesh<double>& chunk : chunks) EXPECT_LT(chunk.tets.size(), 24'000u);
}

// So large that its cells, and its points, come in several windows.
TEST_F(ImportMesh, TakesMeshesOfSeveralWindows) {
  MeshFile file;
  file.geometry = testing::five_split_cube(48, 0.1);
  auto& points = std::get<Vector<Vec3<double>>>(file.geometry.points);
  constexpr std::size_t kUnused = 210'000;
  points.insert(points.begin(), kUnused, Vec3<double>{24, 24, 24});
  for (Tet& t : file.geometry.tets) {
    for (VertexId& v : t) v += kUnused;
  }
  file.cell_arrays = {testing::make_array<std::uint32_t>("number", file.cells(), 1,
                                                         [](auto i, auto) { return i; })};
  file.write(path);
  for (const std::uint64_t chunk_tets : {kOneChunk, std::uint64_t{60'000}}) {
    const Import<double> cut(path, {.chunk_tets = chunk_tets});
    EXPECT_EQ(cut.imported.facts.unused_points, kUnused);
    EXPECT_EQ(cut.imported.facts.points, points.size() - kUnused);
    EXPECT_EQ(cut.imported.facts.boundary_faces, 48u * 48 * 12);
    EXPECT_NEAR(cut.imported.facts.volume, 48 * 48 * 48, 1e-6);
    std::size_t wrong = 0, seen = 0;
    for (const WorkMesh<double>& chunk : cut.chunks()) {
      const auto numbers = testing::tet_numbers(chunk);
      for (std::size_t t = 0; t < chunk.tets.size(); ++t, ++seen) {
        for (std::size_t k = 0; k < 4; ++k) {
          const VertexId v = chunk.tets[t][k], id = file.geometry.tets[numbers[t]][k];
          if (chunk.point_ids[v] != id || chunk.positions[v].z != points[id].z) ++wrong;
        }
      }
    }
    EXPECT_EQ(seen, file.geometry.tets.size());
    EXPECT_EQ(wrong, 0u);
  }
}

// The first round may be done with the import: the mesh is then the one that this round would have
// made of what was imported.
TEST_F(ImportMesh, MayDoTheFirstRoundAtOnce) {
  rich_box(11).write(path);
  for (const std::uint64_t chunk_tets : {kOneChunk, std::uint64_t{2000}, std::uint64_t{300}}) {
    ImportChoice choice{.chunk_tets = chunk_tets, .regions = {"material"}};
    Import<double> after(path, choice);
    choice.first_round = true;
    choice.on_disk = true;
    const Import<double> at_once(path, choice);
    expect_same_facts(at_once.imported.facts, after.imported.facts);
    expect_same_lower(at_once.imported.lower, after.imported.lower);
    EXPECT_EQ(at_once.imported.first_round_done, chunk_tets != kOneChunk);
    if (at_once.imported.first_round_done) {
      const RoundStatistics expected = after.run_first_round();
      EXPECT_GT(expected.pass.fused, 20u);
      EXPECT_EQ(at_once.first_round.pass.fused, expected.pass.fused);
      EXPECT_EQ(at_once.first_round.chunks, expected.chunks);
    }
    EXPECT_EQ(at_once.imported.mesh.tets, after.imported.mesh.tets);
    expect_sizes(at_once);
    EXPECT_TRUE(contents(at_once.joined(), false) == contents(after.joined(), false));
    at_once.scratch->remove();
  }
}

// An excerpt has all tetrahedra of its points but for those on its interface, as they are in the
// mesh, which does not become another for it.
TEST_F(ImportMesh, MakesAnExcerpt) {
  rich_box(11).write(path);
  Import<double> whole(path, {.regions = {"material"}, .first_round = true, .excerpt = true});
  EXPECT_TRUE(whole.excerpt.tets.empty());  // nobody needs it
  const WorkMesh<double> mesh = whole.joined();
  std::map<std::uint64_t, VertexId> by_id;
  for (VertexId v = 0; v < mesh.vertex_count(); ++v) by_id[mesh.point_ids[v]] = v;
  std::set<std::set<std::uint64_t>> tets;
  for (const Tet& t : mesh.tets) {
    tets.insert(
        {mesh.point_ids[t[0]], mesh.point_ids[t[1]], mesh.point_ids[t[2]], mesh.point_ids[t[3]]});
  }
  ImportChoice choice{.chunk_tets = 2000, .regions = {"material"}, .first_round = true};
  const Import<double> without(path, choice);
  choice.excerpt = choice.on_disk = true;
  choice.window = 400;
  const Import<double> with(path, choice);
  EXPECT_TRUE(contents(with.joined(), false) == contents(without.joined(), false));
  expect_same_facts(with.imported.facts, without.imported.facts);

  const WorkMesh<double>& excerpt = with.excerpt;
  for (const Tet& t : excerpt.tets) {
    EXPECT_TRUE(tets.contains({excerpt.point_ids[t[0]], excerpt.point_ids[t[1]],
                               excerpt.point_ids[t[2]], excerpt.point_ids[t[3]]}));
  }
  std::size_t complete = 0;
  for (VertexId v = 0; v < excerpt.vertex_count(); ++v) {
    const VertexId same = by_id.at(excerpt.point_ids[v]);
    EXPECT_EQ(excerpt.positions[v].x, mesh.positions[same].x);
    if ((excerpt.marks[v] & kOnInterface) != 0) continue;
    ++complete;
    EXPECT_EQ(excerpt.incidence[v], mesh.incidence[same]);
    EXPECT_EQ(excerpt.marks[v] & (kOnBoundary | kLocked),
              mesh.marks[same] & (kOnBoundary | kLocked));
  }
  EXPECT_GE(complete, mesh.vertex_count() / 4);
  EXPECT_LT(excerpt.tets.size(), mesh.tets.size());
}

// Broken things between chunks that only show when all chunks are there: the round is dropped.
TEST_F(ImportMesh, DropsAFirstRoundThatDidNotKnowEnough) {
  int done = 0, dropped = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    MeshFile file;
    file.geometry = testing::damaged_mesh(seed);
    file.write(path);
    Import<double> after(path, {.chunk_tets = 25});
    const Import<double> at_once(path, {.chunk_tets = 25, .on_disk = true, .first_round = true});
    expect_same_facts(at_once.imported.facts, after.imported.facts);
    EXPECT_EQ(at_once.imported.first_round_done, after.imported.mesh.locks.empty());
    if (at_once.imported.first_round_done) after.run_first_round();
    EXPECT_TRUE(contents(at_once.joined(), false) == contents(after.joined(), false));
    ++(at_once.imported.first_round_done ? done : dropped);
    at_once.scratch->remove();
  }
  EXPECT_GT(done, 3);
  EXPECT_GT(dropped, 3);
}

TEST_F(ImportMesh, RefusesTooManyChunks) {
  MeshFile file;
  file.geometry = testing::five_split_cube(19);  // 34,295 tetrahedra
  file.write(path);
  try {
    Import<double>(path, {.chunk_tets = 1});
    FAIL() << "was not refused";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kUsage);
    EXPECT_NE(std::string(e.what()).find("at least 2"), std::string::npos) << e.what();
  }
  const Import<double> just(path, {.chunk_tets = 2});
  EXPECT_EQ(just.imported.mesh.chunks, 17'148u);
  EXPECT_EQ(just.imported.facts.boundary_faces, 19u * 19 * 12);
}

TEST_F(ImportMesh, StopsWhenCancelled) {
  rich_box(5).write(path);
  const std::atomic<bool> cancelled{true};
  RunContext context;
  context.cancelled = &cancelled;
  EXPECT_THROW(Import<double>(path, {.chunk_tets = 50}, context), Error);
}

}  // namespace
}  // namespace tetfusion
