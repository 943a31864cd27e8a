#include "driver/rounds/rounds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <map>
#include <set>

#include "mesh/vertex_tets.h"
#include "support/brute_check.h"
#include "support/meshes.h"
#include "support/rounds_engine.h"
#include "support/temp_dir.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

using testing::contents;
using testing::five_split_cube;
using testing::RoundsEngine;
using testing::to_work_mesh;

// Boundary triangles by the ids of the beginning.
std::set<std::array<VertexId, 3>> boundary(const WorkMesh<double>& mesh,
                                           const testing::BruteReport& report) {
  std::set<std::array<VertexId, 3>> out;
  for (std::array<VertexId, 3> t : report.boundary) {
    for (VertexId& v : t) v = mesh.point_ids[v];
    std::sort(t.begin(), t.end());
    out.insert(t);
  }
  return out;
}

void expect_same_domain(const WorkMesh<double>& mesh, const WorkMesh<double>& before) {
  const auto report = testing::brute_check(testing::to_geometry(mesh));
  const auto expected = testing::brute_check(testing::to_geometry(before));
  EXPECT_TRUE(report.valid());
  EXPECT_EQ(report.nonmanifold_vertices, 0u);
  EXPECT_EQ(report.nonmanifold_edges, 0u);
  EXPECT_EQ(report.components, expected.components);
  EXPECT_EQ(boundary(mesh, report), boundary(before, expected));
  EXPECT_NEAR(double(report.volume / expected.volume), 1, 1e-12);
}

void expect_same_pieces(const MacroLod<double>& a, const MacroLod<double>& b) {
  ASSERT_EQ(a.chunks, b.chunks);
  for (std::uint32_t c = 0; c < a.chunks; ++c) {
    const auto p = a.pieces->read(c), q = b.pieces->read(c);
    EXPECT_TRUE(std::ranges::equal(p->pieces(), q->pieces(),
                                   [](auto x, auto y) { return std::ranges::equal(x, y); }))
        << "chunk " << c;
  }
}

TEST(Rounds, ChunksMakeAValidMesh) {
  const WorkMesh<double> before = to_work_mesh(five_split_cube(14, 0.2, 5));
  for (const std::uint64_t chunk_tets : {300, 2000, 7000}) {
    RoundsEngine engine(before, chunk_tets);
    EXPECT_GT(engine.lod.chunks, 1u);
    std::uint64_t fused = 0;
    for (int i = 0; i < 6; ++i) {
      const RoundStatistics round = engine.run();
      EXPECT_EQ(round.pass.tets_after, engine.lod.tets);
      fused += round.pass.fused;
    }
    const WorkMesh<double> mesh = engine.mesh();
    EXPECT_EQ(mesh.tets.size(), engine.lod.tets);
    expect_same_domain(mesh, before);
    EXPECT_LT(mesh.tets.size(), before.tets.size() * 19 / 20);
    // Three vertices a fusion, and now and then one that a cavity swallows.
    EXPECT_LE(mesh.vertex_count(), before.vertex_count() - 3 * fused);
  }
}

TEST(Rounds, StayValidOverManyRoundsAndPasses) {
  for (const BoundaryRule rule : {BoundaryRule::kVertices, BoundaryRule::kTets}) {
    const WorkMesh<double> before = to_work_mesh(testing::kuhn_box(13, 11, 9, 0.2, 5));
    RoundsEngine engine(before, 250, 3);
    engine.settings.limits.boundary_rule = rule;
    for (int i = 0; i < 20; ++i) {
      engine.settings.passes = 1 + i % 4;
      engine.settings.limits.paper.stretch_factor = i % 2 == 0 ? 3 : 20;
      engine.run();
    }
    const WorkMesh<double> mesh = engine.mesh();
    expect_same_domain(mesh, before);
    EXPECT_LT(mesh.tets.size(), before.tets.size() * (rule == BoundaryRule::kTets ? 9 : 7) / 10);
  }
}

// Tetrahedra at the boundary are as they were.
TEST(Rounds, TheTetsRuleHoldsInEveryChunk) {
  WorkMesh<double> before = to_work_mesh(five_split_cube(12, 0.2, 5));
  testing::number_tets(&before);
  RoundsEngine engine(before, 700);
  engine.settings.limits.boundary_rule = BoundaryRule::kTets;
  engine.run(5);
  const WorkMesh<double> mesh = engine.mesh();
  EXPECT_LT(mesh.tets.size(), before.tets.size() * 9 / 10);
  const auto at_boundary = [](const WorkMesh<double>& m) {
    std::set<TetId> numbers;
    for (std::size_t t = 0; t < m.tets.size(); ++t) {
      const auto on_boundary = [&](VertexId v) { return (m.marks[v] & kOnBoundary) != 0; };
      if (std::ranges::any_of(m.tets[t], on_boundary)) numbers.insert(testing::tet_numbers(m)[t]);
    }
    return numbers;
  };
  EXPECT_EQ(at_boundary(mesh), at_boundary(before));
}

TEST(Rounds, TheBytesDoNotDependOnThreads) {
  const WorkMesh<double> before = to_work_mesh(testing::kuhn_box(14, 13, 12, 0.2, 8));
  RoundsEngine one(before, 700, 1);
  std::vector<std::unique_ptr<RoundsEngine>> others;
  for (const int threads : {2, 3, 8}) {
    others.push_back(std::make_unique<RoundsEngine>(before, 700, threads));
  }
  for (int round = 0; round < 5; ++round) {
    const RoundStatistics expected = one.run();
    EXPECT_GT(expected.pass.fused, 0u);
    for (const auto& other : others) {
      EXPECT_EQ(other->run().pass.rejected, expected.pass.rejected);
      expect_same_pieces(other->lod, one.lod);
    }
  }
}

// Nor on where the pieces are, and on how much memory there is: with room for two chunks or
// three, eight threads wait for each other.
TEST(Rounds, TheBytesDoNotDependOnMemory) {
  const testing::TempDir folder = testing::TempDir::in_memory();
  const WorkMesh<double> before = to_work_mesh(testing::kuhn_box(12, 12, 12, 0.2, 8));
  RoundsEngine ample(before, 500, 2);
  std::uint64_t largest = 0;
  for (std::uint32_t c = 0; c < ample.lod.chunks; ++c) {
    largest = std::max(largest, ample.lod.pieces->bytes(c));
  }
  RoundsEngine scarce(before, 500, 8, disk_scratch({folder.file("scratch"), "a test", false, 0}),
                      chunk_memory(largest) * 5 / 2);
  for (int round = 0; round < 4; ++round) {
    ample.run();
    scarce.run();
    expect_same_pieces(scarce.lod, ample.lod);
  }
}

// Interfaces dissolve: with several small chunks nearly as much is fused in the end as with one.
TEST(Rounds, CutsCostNothingInTheEnd) {
  const WorkMesh<double> before = to_work_mesh(testing::kuhn_box(16, 16, 16, 0.15, 2));
  RoundsEngine whole(before, 1'000'000), cut(before, 5000);
  EXPECT_TRUE(whole.lod.whole);
  EXPECT_FALSE(cut.lod.whole);
  whole.run(12);
  cut.run(24);
  EXPECT_LT(static_cast<double>(cut.lod.tets), 1.1 * static_cast<double>(whole.lod.tets));
}

TEST(Rounds, AMeshBecomesWholeWhenItIsSmallEnough) {
  WorkMesh<double> before = to_work_mesh(testing::kuhn_box(14, 14, 14, 0.1, 2));
  testing::number_tets(&before);
  RoundsEngine engine(before, before.tets.size() * 3 / 5);
  ASSERT_EQ(engine.lod.chunks, 2u);
  for (int i = 0; i < 10 && !engine.lod.whole; ++i) {
    EXPECT_EQ(engine.run().chunks, 2u);
    const double expected = engine.settings.shrink * double(engine.lod.tets);
    EXPECT_GE(engine.lod.chunks, 1u);
    EXPECT_LE(expected, double(before.tets.size()));
  }
  ASSERT_TRUE(engine.lod.whole);
  EXPECT_EQ(engine.lod.chunks, 1u);
  EXPECT_EQ(engine.lod.pieces, nullptr);
  EXPECT_TRUE(engine.lod.interface.entries().empty());
  EXPECT_EQ(engine.lod.whole->tets.size(), engine.lod.tets);
  const auto on_interface = [](std::uint8_t m) { return (m & kOnInterface) != 0; };
  EXPECT_EQ(std::ranges::count_if(engine.lod.whole->marks, on_interface), 0);
  const std::size_t left = engine.lod.tets;
  engine.run(3);
  EXPECT_LT(engine.lod.tets, left);
  expect_same_domain(engine.mesh(), before);
}

// The next cut expects the mesh to shrink as it did.
TEST(Rounds, ChunksBecomeFewer) {
  RoundsEngine engine(to_work_mesh(testing::kuhn_box(12, 12, 12, 0.1, 2)), 500);
  EXPECT_EQ(engine.lod.chunks, 21u);
  engine.settings.shrink = 0.5;
  engine.run();
  EXPECT_EQ(engine.lod.chunks, 11u);
  engine.settings.shrink = 1;
  const std::uint64_t tets = engine.lod.tets;
  engine.run();
  EXPECT_EQ(engine.lod.chunks, (tets + 499) / 500);
}

TEST(Rounds, TheQuotaIsSharedAndNeverExceeded) {
  const WorkMesh<double> before = to_work_mesh(five_split_cube(14, 0.1, 5));
  for (const std::uint64_t chunk_tets : {400, 2000, 6000}) {
    for (const std::uint64_t quota : {0, 1, 11, 30, 100, 1500, 13'000, 13'720}) {
      for (const bool spread : {true, false}) {
        RoundsEngine engine(before, chunk_tets);
        engine.settings.limits.quota = quota;
        engine.settings.limits.spread = spread;
        engine.settings.passes = 3;
        engine.run();
        EXPECT_LE(before.tets.size() - engine.lod.tets, quota);
      }
    }
  }
}

// A quota that is spread takes from every chunk alike; one that is not can be met to a few
// tetrahedra.
TEST(Rounds, TheQuotaIsUsed) {
  WorkMesh<double> before = to_work_mesh(five_split_cube(16, 0.1, 5));
  testing::number_tets(&before);
  RoundsEngine engine(before, 2000);
  engine.settings.limits.quota = 1500;
  engine.run();
  EXPECT_GT(before.tets.size() - engine.lod.tets, 1000u);
  std::array<int, 4> left{};  // by the quarter of the numbers, which run through the box in z
  const WorkMesh<double> mesh = engine.mesh();
  for (const TetId t : testing::tet_numbers(mesh))
    ++left.at(4 * std::size_t{t} / before.tets.size());
  for (const int l : left) EXPECT_NEAR(l, double(engine.lod.tets) / 4, 120);

  // However little the first chunks may give.
  RoundsEngine trim(before, 2000);
  trim.settings.limits.spread = false;
  trim.settings.limits.quota = 2700;
  trim.run();
  EXPECT_LT(trim.lod.tets - (before.tets.size() - 2700), 20u);
}

// What a mesh remembers of refused flips saves time; the result is the same without it.
TEST(Rounds, RememberedFlipsChangeNothing) {
  for (const std::uint64_t chunk_tets : {300, 1500, 4000}) {
    const WorkMesh<double> before = to_work_mesh(five_split_cube(11, 0.2, 7));
    RoundsEngine knowing(before, chunk_tets), forgetting(before, chunk_tets);
    std::ptrdiff_t remembered = 0;
    for (int round = 0; round < 12; ++round) {
      const double stretch = round % 3 == 0 ? 2 : 6;
      knowing.settings.limits.paper.stretch_factor =
          forgetting.settings.limits.paper.stretch_factor = stretch;
      knowing.settings.passes = forgetting.settings.passes = 1 + round % 3;
      const RoundStatistics a = knowing.run(), b = forgetting.run();
      EXPECT_EQ(a.pass.fused, b.pass.fused);
      EXPECT_EQ(a.pass.rejected, b.pass.rejected);
      ASSERT_EQ(contents(knowing.mesh()), contents(forgetting.mesh())) << "round " << round;
      forgetting.forget_flips();
      for (std::uint32_t c = 0; !knowing.lod.whole && c < knowing.lod.chunks; ++c) {
        const WorkMesh<double> chunk = knowing.chunk(c);
        remembered += std::ranges::count(chunk.remembered, 1);
      }
      if (knowing.lod.whole) {
        const auto& flipped = knowing.lod.whole->remembered;
        remembered += std::ranges::count_if(flipped, [](std::uint16_t f) { return f > 0; });
      }
    }
    EXPECT_GT(remembered, 0);
  }
}

// Would fusing the tetrahedron turn another one over?
bool flips(const WorkMesh<double>& mesh, const VertexTets& balls, const Tet& prey) {
  const auto mean = [&](auto coordinate) {
    return mean_of_four(coordinate(mesh.positions[prey[0]]), coordinate(mesh.positions[prey[1]]),
                        coordinate(mesh.positions[prey[2]]), coordinate(mesh.positions[prey[3]]));
  };
  using Point = Vec3<double>;
  const Point target{mean([](const Point& p) { return p.x; }),
                     mean([](const Point& p) { return p.y; }),
                     mean([](const Point& p) { return p.z; })};
  const auto in_prey = [&](VertexId v) { return std::ranges::count(prey, v) > 0; };
  for (const VertexId v : prey) {
    for (const std::uint32_t entry : balls.of(v)) {
      const Tet& tet = mesh.tets[entry >> 2];
      if (std::ranges::count_if(tet, in_prey) != 1) continue;
      std::array<Point, 4> corners;
      for (std::size_t k = 0; k < 4; ++k) corners[k] = mesh.positions[tet[k]];
      corners[entry & 3u] = target;
      if (determinant(corners[0], corners[1], corners[2], corners[3]).sign() != 1) return true;
    }
  }
  return false;
}

// The tetrahedra that a mesh remembers as flips and that are none. Counts all that it remembers.
std::size_t wrong_flips(const RoundsEngine& engine, std::size_t* remembered) {
  const WorkMesh<double> mesh = engine.mesh();
  VertexTets balls;
  build_vertex_tets(mesh.vertex_count(), mesh.tets, &balls);
  std::map<TetId, const Tet*> by_number;
  const auto numbers = testing::tet_numbers(mesh);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) by_number[numbers[t]] = &mesh.tets[t];
  std::size_t wrong = 0;
  for (std::uint32_t c = 0; c < engine.lod.chunks; ++c) {
    const WorkMesh<double> chunk = engine.chunk(c);
    for (std::size_t t = 0; t < chunk.tets.size(); ++t) {
      const auto is_older = [&](VertexId v) { return chunk.changed[v] < chunk.remembered[t]; };
      if (!std::ranges::all_of(chunk.tets[t], is_older)) continue;
      ++*remembered;
      wrong += flips(mesh, balls, *by_number.at(testing::tet_numbers(chunk)[t])) ? 0 : 1;
    }
  }
  return wrong;
}

// Also where the balls of vertices on the interface have changed in another chunk since.
TEST(Rounds, WhatIsRememberedAsAFlipIsOne) {
  std::size_t remembered = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    WorkMesh<double> before = to_work_mesh(five_split_cube(13, 0.2, seed));
    testing::number_tets(&before);
    RoundsEngine engine(before, 600);
    for (int round = 0; round < 16; ++round) {
      engine.settings.limits.paper.stretch_factor = 2 + round / 4;
      engine.run();
      EXPECT_EQ(wrong_flips(engine, &remembered), 0u);
    }
  }
  EXPECT_GT(remembered, 10'000u);
}

// What is round each vertex, by the ids of the vertices: tetrahedra, by number, and where their
// corners are.
std::map<VertexId, std::set<std::vector<double>>> balls_of(const WorkMesh<double>& mesh) {
  std::map<VertexId, std::set<std::vector<double>>> balls;
  const auto numbers = testing::tet_numbers(mesh);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    std::vector<double> tet{static_cast<double>(numbers[t])};
    for (const VertexId v : mesh.tets[t]) {
      const Vec3<double>& p = mesh.positions[v];
      tet.insert(tet.end(), {p.x, p.y, p.z});
    }
    for (const VertexId v : mesh.tets[t]) balls[mesh.point_ids[v]].insert(tet);
  }
  return balls;
}

// Every chunk of the next round knows which vertices of the last interface have been touched.
TEST(Rounds, TouchesOnTheInterfaceAreToldOn) {
  WorkMesh<double> before = to_work_mesh(five_split_cube(12, 0.2, 4));
  testing::number_tets(&before);
  RoundsEngine engine(before, 600);
  std::size_t touched = 0, untouched = 0;
  for (int round = 0; round < 4; ++round) {
    std::set<VertexId> interface;
    for (std::uint32_t c = 0; c < engine.lod.chunks; ++c) {
      const WorkMesh<double> chunk = engine.chunk(c);
      for (std::size_t v = 0; v < chunk.vertex_count(); ++v) {
        if ((chunk.marks[v] & kOnInterface) != 0) interface.insert(chunk.point_ids[v]);
      }
    }
    const auto old_balls = balls_of(engine.mesh());
    engine.settings.passes = 1 + round % 2;
    engine.run();
    const auto balls = balls_of(engine.mesh());
    for (std::uint32_t c = 0; c < engine.lod.chunks; ++c) {
      const WorkMesh<double> chunk = engine.chunk(c);
      for (std::size_t v = 0; v < chunk.vertex_count(); ++v) {
        const VertexId id = chunk.point_ids[v];
        const bool told = interface.contains(id) && balls.at(id) != old_balls.at(id);
        EXPECT_EQ(chunk.changed[v], told ? 1 : 0);
        ++(told ? touched : untouched);
      }
    }
  }
  EXPECT_GT(touched, 500u);
  EXPECT_GT(untouched, 500u);
}

// A cut alone changes nothing.
TEST(Rounds, ARoundWithoutFusionsKeepsTheMesh) {
  WorkMesh<double> before = to_work_mesh(five_split_cube(9, 0.2, 7));
  testing::number_tets(&before);
  testing::steer_by([](double x, double y, double) { return x - y; }, &before);
  RoundsEngine engine(before, 250);
  engine.settings.limits.quota = 0;
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(engine.run().pass.fused, 0u);
    EXPECT_EQ(contents(engine.mesh()), contents(before));
  }
}

TEST(Rounds, LateLocksHold) {
  const WorkMesh<double> before = to_work_mesh(five_split_cube(12, 0.1, 6));
  RoundsEngine engine(before, 600);
  for (VertexId v = 0; v < before.vertex_count(); v += 2) engine.lod.locks.push_back(v);
  engine.run(4);  // the first round takes them over
  EXPECT_TRUE(engine.lod.locks.empty());
  const WorkMesh<double> mesh = engine.mesh();
  std::set<VertexId> ids(mesh.point_ids.begin(), mesh.point_ids.end());
  for (VertexId v = 0; v < before.vertex_count(); v += 2) EXPECT_TRUE(ids.contains(v));
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.point_ids[v] % 2 != 0) continue;
    EXPECT_EQ(mesh.positions[v].x, before.positions[mesh.point_ids[v]].x);
  }
  RoundsEngine all(before, 600);
  all.lod.locks = count_up<VertexId>(before.vertex_count());
  EXPECT_EQ(all.run().pass.fused, 0u);
}

// Counts the pieces that are added, and calls `added` after each source.
class WatchedStore : public PieceStore {
 public:
  WatchedStore(std::unique_ptr<PieceStore> store, std::function<void()> added)
      : store_(std::move(store)), added_(std::move(added)) {}
  void add(std::uint32_t source, std::span<const PieceRef> pieces) override {
    store_->add(source, pieces);
    added_();
  }
  void seal() override { store_->seal(); }
  void will_read(std::uint32_t bucket) const override { store_->will_read(bucket); }
  std::unique_ptr<BucketPieces> read(std::uint32_t bucket) const override {
    return store_->read(bucket);
  }
  void forget(std::uint32_t bucket) override { store_->forget(bucket); }
  std::uint64_t bytes(std::uint32_t bucket) const override { return store_->bytes(bucket); }
  std::uint64_t bytes() const override { return store_->bytes(); }

 private:
  std::unique_ptr<PieceStore> store_;
  std::function<void()> added_;
};

class WatchedScratch : public Scratch {
 public:
  explicit WatchedScratch(std::function<void()> added) : added_(std::move(added)) {}
  std::unique_ptr<PieceStore> begin(const std::string& name) override {
    return std::make_unique<WatchedStore>(scratch_->begin(name), added_);
  }
  void commit(const std::string&, std::span<const std::byte>) override {}
  void keep(const std::string&) override {}
  std::optional<Checkpoint> resume() override { return {}; }
  void check() const override {}
  void drop_spares() override {}
  void remove() override {}
  std::uint64_t peak_bytes() const override { return 0; }

 private:
  std::unique_ptr<Scratch> scratch_ = memory_scratch();
  std::function<void()> added_;
};

TEST(Rounds, StopBetweenChunksWhenCancelled) {
  const WorkMesh<double> mesh = to_work_mesh(five_split_cube(10, 0.1, 6));
  std::atomic<bool> cancelled{true};
  RunContext context;
  context.cancelled = &cancelled;
  RoundsEngine none(mesh, 500), whole(mesh, 10'000);
  EXPECT_THROW(none.run(context), Error);
  EXPECT_THROW(whole.run(context), Error);
  for (const int threads : {1, 3}) {
    std::atomic<int> chunks{0};
    cancelled = false;
    RoundsEngine engine(mesh, 500, threads, std::make_unique<WatchedScratch>([&] {
                          if (++chunks == 5) cancelled = true;
                        }));
    chunks = 0;  // but for the one that made the first cut
    try {
      engine.run(context);
      FAIL() << "was not interrupted";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kInterrupted);
    }
    EXPECT_GE(chunks, 5);
    EXPECT_LT(chunks, 5 + threads);
  }
}

}  // namespace
}  // namespace tetfusion
