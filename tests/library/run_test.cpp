// Runs of the library: what it tells, asks, keeps and leaves.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <future>
#include <map>
#include <set>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "support/library_test.h"

namespace tetfusion {
namespace {

using ::testing::HasSubstr;
using testing::LibraryMesh;
using testing::MeshFile;
using testing::rich_box;
using testing::wavy_box;

using P = Vec3<double>;

class LibraryRun : public testing::LibraryTest {};

static_assert(type_of<char>() == Type::kInt8 || type_of<char>() == Type::kUInt8);
static_assert(type_of<std::uint8_t>() == Type::kUInt8 && type_of<std::int16_t>() == Type::kInt16);
static_assert(type_of<long>() == Type::kInt64 && type_of<long long>() == Type::kInt64);
static_assert(type_of<const unsigned>() == Type::kUInt32 && type_of<float>() == Type::kFloat32);

TEST_F(LibraryRun, ScratchOnDiskMakesTheSameMeshAndLeavesNothing) {
  const MeshFile file = wavy_box(24);
  options.reduction = 0.7;
  options.chunk_tets = 5000;
  options.threads = 1;
  const Result in_memory = run(file);
  ASSERT_TRUE(in_memory.status.ok());
  EXPECT_EQ(in_memory.report.scratch_bytes, 0u);

  options.memory = std::uint64_t{68} << 20;
  const Result refused = run(file);
  EXPECT_EQ(refused.status.code, Code::kMemory);
  EXPECT_THAT(refused.status.message, HasSubstr("give memory "));
  EXPECT_THAT(refused.status.message, HasSubstr("or scratch"));

  options.scratch = folder.path().string();
  const Result on_disk = run(file);
  ASSERT_TRUE(on_disk.status.ok()) << on_disk.status.message;
  EXPECT_GT(on_disk.report.scratch_bytes, 0u);
  const auto equal = [](auto a, auto b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  };
  EXPECT_TRUE(equal(on_disk.mesh.points.as<double>(), in_memory.mesh.points.as<double>()));
  EXPECT_TRUE(equal(on_disk.mesh.connectivity.as<std::int64_t>(),
                    in_memory.mesh.connectivity.as<std::int64_t>()));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));

  options.scratch = folder.file("missing");
  EXPECT_EQ(run(file).status.code, Code::kIo);
}

TEST_F(LibraryRun, PointsOfGhostCellsStay) {
  const MeshFile file = wavy_box(8);
  LibraryMesh<std::int64_t> input(file, false);
  const auto& points = std::get<Vector<P>>(file.geometry.points);
  // The last layer of cubes belongs to somebody else.
  const Vector<Tet>& tets = file.geometry.tets;
  const std::size_t own = tets.size() * 7 / 8;
  std::vector<std::uint8_t> ghosts(tets.size(), 0);
  std::fill(ghosts.begin() + static_cast<std::ptrdiff_t>(own), ghosts.end(), 1);
  input.mesh().ghosts = ghosts;
  options.boundary = BoundaryMode::kWithin;
  options.boundary_distance = 0.05;
  options.reduction = 0.9;
  const Result result = simplify(input.mesh(), options);
  ASSERT_TRUE(result.status.ok()) << result.status.message;
  EXPECT_EQ(result.report.input.tets, own);
  EXPECT_EQ(result.report.odd.ghost_cells, tets.size() - own);
  EXPECT_LT(result.report.output.tets, own / 2);
  EXPECT_LT(result.report.output.boundary_triangles, result.report.input.boundary_triangles);
  std::set<std::array<double, 3>> left;
  const auto x = result.mesh.points.as<double>();
  for (std::size_t i = 0; i < x.size(); i += 3) left.insert({x[i], x[i + 1], x[i + 2]});
  std::vector<std::uint8_t> users(points.size(), 0);  // 1: own cells, 2: others'
  for (std::size_t t = 0; t < tets.size(); ++t) {
    for (const VertexId v : tets[t]) users[v] |= t < own ? 1 : 2;
  }
  std::size_t kept = 0;
  for (std::size_t v = 0; v < points.size(); ++v) {
    if (users[v] != 3) continue;
    ++kept;
    EXPECT_EQ(left.count({points[v].x, points[v].y, points[v].z}), 1u) << v;
  }
  EXPECT_EQ(kept, 81u);
}

// The faces of the box's tetrahedra, by the places of their corners, and how many have each.
using Place = std::array<double, 3>;
using Faces = std::map<std::array<Place, 3>, int>;

template <class PlaceOf>
void add_faces(const std::array<std::int64_t, 4>& corners, PlaceOf place, Faces* faces) {
  for (std::size_t k = 0; k < 4; ++k) {
    std::array<Place, 3> face = {place(corners[(k + 1) % 4]), place(corners[(k + 2) % 4]),
                                 place(corners[(k + 3) % 4])};
    std::sort(face.begin(), face.end());
    ++(*faces)[face];
  }
}

TEST_F(LibraryRun, PartsThatAreSimplifiedApartStillFit) {
  const MeshFile file = wavy_box(8);
  const auto& points = std::get<Vector<P>>(file.geometry.points);
  const Vector<Tet>& tets = file.geometry.tets;
  const auto original = [&](std::int64_t v) {
    const P& p = points[static_cast<std::size_t>(v)];
    return Place{p.x, p.y, p.z};
  };
  options.boundary = BoundaryMode::kWithin;
  options.boundary_distance = 0.05;
  options.reduction = 0.9;
  // Layers of cubes 0 to 3 and 4 to 7, each with one layer of the other.
  const std::size_t layer = tets.size() / 8;
  std::array<Faces, 2> before, after;
  for (const std::size_t part : {0, 1}) {
    MeshFile cut = file;
    const std::size_t begin = part == 0 ? 0 : 3 * layer;
    const auto first = tets.begin() + static_cast<std::ptrdiff_t>(begin);
    cut.geometry.tets.assign(first, first + static_cast<std::ptrdiff_t>(5 * layer));
    std::vector<std::uint8_t> ghosts(5 * layer, 0);
    std::fill_n(ghosts.begin() + static_cast<std::ptrdiff_t>(part == 0 ? 4 * layer : 0), layer,
                std::uint8_t{1});
    LibraryMesh<std::int64_t> input(cut, true);
    input.mesh().ghosts = ghosts;
    for (std::size_t t = 0; t < ghosts.size(); ++t) {
      const Tet& tet = cut.geometry.tets[t];
      if (ghosts[t] == 0) add_faces({tet[0], tet[1], tet[2], tet[3]}, original, &before[part]);
    }
    const Result result = simplify(input.mesh(), options);
    ASSERT_TRUE(result.status.ok()) << result.status.message;
    EXPECT_LT(result.report.output.boundary_triangles, result.report.input.boundary_triangles);
    const auto x = result.mesh.points.as<double>();
    const auto ids = result.mesh.connectivity.as<std::int64_t>();
    const auto place = [&](std::int64_t v) {
      const auto at = static_cast<std::size_t>(3 * v);
      return Place{x[at], x[at + 1], x[at + 2]};
    };
    for (std::size_t i = 0; i < 4 * result.mesh.tets; i += 4) {
      add_faces({ids[i], ids[i + 1], ids[i + 2], ids[i + 3]}, place, &after[part]);
    }
  }
  std::size_t between = 0;
  for (const auto& [face, count] : before[0]) {
    if (before[1].count(face) == 0) continue;
    ++between;
    EXPECT_EQ(after[0][face], 1);
    EXPECT_EQ(after[1][face], 1);
  }
  EXPECT_EQ(between, 2u * 8 * 8);
}

TEST_F(LibraryRun, ReportSaysWhatWasDone) {
  MeshFile file = rich_box(8);
  options.reduction = 0.4;
  const Result result = run(file);
  ASSERT_TRUE(result.status.ok());
  const Report& r = result.report;
  EXPECT_TRUE(r.goal_reached);
  EXPECT_EQ(r.stop_sentence, "The goal was reached.");
  EXPECT_EQ(r.input.tets, file.geometry.tets.size());
  EXPECT_EQ(r.odd.unused_points, 5u);
  EXPECT_NEAR(r.reduction, 0.4, 0.01);
  EXPECT_THAT(r.steering, ::testing::ElementsAre("f"));
  EXPECT_THAT(r.regions, ::testing::ElementsAre("material"));
  EXPECT_NEAR(r.output.volume, r.input.volume, 1e-9);
  EXPECT_GT(r.rounds, 0u);
  EXPECT_THAT(r.json, HasSubstr("\"stop_reason\": \"goal\""));
}

TEST_F(LibraryRun, MemoryOfTheResultIsHandedOver) {
  options.reduction = 0.5;
  Result result = run(wavy_box(4));
  ASSERT_TRUE(result.status.ok());
  const double first = result.mesh.points.as<double>()[0];
  auto* points = static_cast<double*>(result.mesh.points.release());
  EXPECT_EQ(points[0], first);
  EXPECT_TRUE(result.mesh.points.empty());
  std::free(points);
}

TEST_F(LibraryRun, ProgressNeverFallsAndComesOnTheCallersThread) {
  options.reduction = 0.7;
  options.chunk_tets = 500;
  options.threads = 3;
  std::vector<double> shares;
  std::vector<std::string> notices;
  const std::thread::id here = std::this_thread::get_id();
  bool elsewhere = false;
  Observer observer;
  observer.progress = [&](double share, std::string_view) {
    shares.push_back(share);
    elsewhere = elsewhere || std::this_thread::get_id() != here;
  };
  observer.notice = [&](std::string_view s) { notices.emplace_back(s); };
  ASSERT_TRUE(run(rich_box(10), observer).status.ok());
  EXPECT_FALSE(elsewhere);
  ASSERT_FALSE(shares.empty());
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_GE(shares.front(), 0);
  EXPECT_EQ(shares.back(), 1);
  EXPECT_THAT(notices, ::testing::Contains("5 points are used by no cell: dropped"));
  EXPECT_THAT(notices, ::testing::Contains(HasSubstr("(regions none switches that off)")));
}

TEST_F(LibraryRun, CancellingEndsTheRun) {
  options.reduction = 0.9;
  Observer observer;
  double last = 0;
  observer.progress = [&](double share, std::string_view) { last = share; };
  observer.cancelled = [&] { return last > 0; };
  const Result result = run(wavy_box(30), observer);
  EXPECT_EQ(result.status.code, Code::kInterrupted);
  EXPECT_TRUE(result.mesh.points.empty());
  EXPECT_LT(last, 1);
  EXPECT_TRUE(run(wavy_box(3)).status.ok()) << "nothing is left of it";
}

TEST_F(LibraryRun, AnObserverThatThrowsEndsTheRun) {
  options.reduction = 0.9;
  Observer observer;
  observer.progress = [](double, std::string_view) { throw std::runtime_error("no more"); };
  const Result result = run(wavy_box(12), observer);
  EXPECT_EQ(result.status.code, Code::kInterrupted);
  EXPECT_EQ(result.status.message, "the observer threw: no more");
}

// Each with threads of its own.
TEST_F(LibraryRun, RunsFromSeveralThreadsGoOnAtOnce) {
  options.reduction = 0.5;
  options.chunk_tets = 200;
  const MeshFile file = wavy_box(6);
  const Result alone = run(file);
  std::vector<std::thread> threads;
  std::atomic<int> same{0};
  for (int i = 1; i <= 4; ++i) {
    threads.emplace_back([&, i] {
      LibraryMesh<std::int64_t> input(file, false);
      Options own = options;
      own.threads = i;
      const Result result = simplify(input.mesh(), own);
      const auto before = alone.mesh.points.as<double>(), after = result.mesh.points.as<double>();
      if (result.status.ok() && result.report.threads == i &&
          std::equal(before.begin(), before.end(), after.begin(), after.end())) {
        ++same;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(same, 4);
}

// Its observer may need what that thread holds.
TEST_F(LibraryRun, WaitsForNoOtherThreadsRun) {
  options.reduction = 0.5;
  std::promise<void> begun, other_ended;
  bool is_first = true;
  Observer observer;
  observer.progress = [&](double, std::string_view) {
    if (!std::exchange(is_first, false)) return;
    begun.set_value();
    const auto ended = other_ended.get_future().wait_for(std::chrono::minutes(5));
    if (ended != std::future_status::ready) throw std::runtime_error("the other one waits");
  };
  std::thread other([&] {
    begun.get_future().wait();
    EXPECT_TRUE(run(wavy_box(4)).status.ok());
    other_ended.set_value();
  });
  const Result result = run(wavy_box(6), observer);
  other.join();
  EXPECT_TRUE(result.status.ok()) << result.status.message;
}

// They hold their points.
TEST_F(LibraryRun, PatchesAreDropped) {
  const MeshFile file = wavy_box(6);
  LibraryMesh<std::int64_t> input(file, true);
  Mesh& mesh = input.mesh();
  options.reduction = 0.5;
  const Result alone = simplify(mesh, options);
  const auto ids = [&](const Values& v) {
    const auto* from = static_cast<const std::int64_t*>(v.data());
    return std::vector<std::int64_t>(from, from + v.size());
  };
  std::vector<std::int64_t> connectivity = ids(mesh.connectivity), offsets = ids(mesh.offsets);
  std::vector<std::uint8_t> types(mesh.types.begin(), mesh.types.end());
  connectivity.insert(connectivity.end(), {0, 1, 2, 3});
  offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  types.push_back(4);  // a polyline
  mesh.connectivity = connectivity;
  mesh.offsets = offsets;
  mesh.types = types;
  EXPECT_THAT(failure(mesh).message, HasSubstr("drop_patches leaves such cells out"));
  options.drop_patches = true;
  const Result result = simplify(mesh, options);
  ASSERT_TRUE(result.status.ok()) << result.status.message;
  EXPECT_EQ(result.mesh.types.size(), result.mesh.tets);
  EXPECT_EQ(result.mesh.tets, alone.mesh.tets);
}

TEST_F(LibraryRun, SomePatchesAreDropped) {
  const MeshFile file = wavy_box(6);
  LibraryMesh<std::int64_t> input(file, true);
  Mesh& mesh = input.mesh();
  const auto* from = static_cast<const std::int64_t*>(mesh.connectivity.data());
  std::vector<std::int64_t> connectivity(from, from + mesh.connectivity.size());
  from = static_cast<const std::int64_t*>(mesh.offsets.data());
  std::vector<std::int64_t> offsets(from, from + mesh.offsets.size());
  std::vector<std::uint8_t> types(mesh.types.begin(), mesh.types.end());
  std::vector<std::int32_t> patch(types.size(), 7);  // the tetrahedra's, too, which stay
  for (const std::int32_t number : {7, 8, 7}) {
    connectivity.insert(connectivity.end(), {0, 1, 8});
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
    types.push_back(5);
    patch.push_back(number);
  }
  mesh.connectivity = connectivity;
  mesh.offsets = offsets;
  mesh.types = types;
  mesh.cell_arrays = {{"patch", 1, patch}};
  options.reduction = 0.5;
  options.regions.emplace();
  EXPECT_EQ(simplify(mesh, options).mesh.types.size(), simplify(mesh, options).mesh.tets + 3);
  options.drop_patch = {"patch=7"};
  const Result result = simplify(mesh, options);
  ASSERT_TRUE(result.status.ok()) << result.status.message;
  EXPECT_EQ(result.mesh.types.size(), result.mesh.tets + 1);
  options.drop_patch = {"patch=9"};
  EXPECT_THAT(failure(mesh).message,
              HasSubstr("drop_patch patch=9: no triangle, line or point of the mesh has that"));
}

TEST(LibraryVersion, IsTheProjects) { EXPECT_STREQ(library_version(), TETFUSION_VERSION); }

}  // namespace
}  // namespace tetfusion
