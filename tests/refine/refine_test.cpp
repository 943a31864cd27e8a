// From a mesh to its simplification and back, file by file.
#include "refine/refine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <tuple>

#include "base/error.h"
#include "driver/simplify.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "mesh/inspection/inspect.h"
#include "support/damaged_meshes.h"
#include "support/file_request.h"
#include "support/mesh_file.h"
#include "support/surfaces.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using testing::boundary_of;
using testing::bytes_of;
using ::testing::HasSubstr;
using testing::MeshFile;
using testing::rich_box;
using testing::TempDir;

class Refine : public ::testing::Test {
 protected:
  // Simplifies the file as the request says, with and without its way back.
  void simplify_both(const MeshFile& file) {
    file.write(request.input);
    request.progressive.clear();
    request.behaviour.fit_values = false;
    simplify(request);
    const std::string plain = bytes_of(request.output);
    request.progressive = folder.file("run.tfp");
    report = simplify(request);
    EXPECT_EQ(bytes_of(request.output), plain) << "a log changes the result";
  }
  RefineReport refine_to(std::optional<std::uint64_t> tets = std::nullopt) {
    RefineRequest r;
    r.input = request.progressive;
    r.output = folder.file("refined.vtu");
    r.tets = tets;
    return refine(r);
  }
  void expect_original() {
    const RefineReport r = refine_to();
    EXPECT_EQ(r.undone, r.counts.fusions);
    EXPECT_TRUE(bytes_of(folder.file("refined.vtu")) == bytes_of(request.input));
  }

  TempDir folder = TempDir::in_memory();
  SimplifyRequest request = testing::request_in(folder);
  SimplifyReport report;
};

// Three times, while a level is written.
TEST_F(Refine, FieldDataTakesMemory) {
  MeshFile file = rich_box(5);
  request.behaviour.reduction = 0.5;
  const auto refusal = [&](std::size_t values) {
    file.field_arrays = {
        testing::make_array<double>("history", values, 1, [](auto, auto) { return 1.5; })};
    simplify_both(file);
    RefineRequest r;
    r.input = request.progressive;
    r.output = folder.file("refined.vtu");
    r.memory = std::uint64_t{140} << 20;
    try {
      refine(r);
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::kUsage;
  };
  EXPECT_EQ(refusal(1), ErrorCode::kUsage);  // none
  EXPECT_EQ(refusal(1 << 20), ErrorCode::kMemory);
}

using Choice = std::tuple<Method, Boundary, std::uint64_t>;
class RefineAll : public Refine, public ::testing::WithParamInterface<Choice> {
 protected:
  void choose() {
    const auto& [method, boundary, chunk_tets] = GetParam();
    BehaviourOptions& b = request.behaviour;
    b.method = method;
    b.boundary = boundary;
    b.boundary_distance = 0.02;
    b.chunk_tets = chunk_tets;
    b.reduction = 0.9;
    if (method == Method::kTetFuse) b.scalar_tolerance = {1e9};
  }
};

// Arrays of all types, cells of lower dimension, points that no cell uses.
TEST_P(RefineAll, EndsWithTheOriginal) {
  choose();
  simplify_both(rich_box(9));
  EXPECT_LT(report.output.tets, report.input.tets);
  expect_original();
}

TEST_P(RefineAll, LevelsAreMeshesOnTheWay) {
  choose();
  const MeshFile file = rich_box(9);
  simplify_both(file);
  const bool stays = std::get<1>(GetParam()) == Boundary::kExact;
  const auto boundary = boundary_of(file.geometry);
  std::uint64_t before = 0;
  for (int i = 0; i <= 10; ++i) {
    const std::uint64_t goal = report.output.tets + (report.input.tets - report.output.tets) *
                                                        static_cast<unsigned>(i) / 10;
    const RefineReport level = refine_to(goal);
    EXPECT_TRUE(level.reached);
    EXPECT_LE(level.tets, goal);
    EXPECT_GT(level.tets + 40, goal);
    EXPECT_TRUE(level.tets > before);
    before = level.tets;
    Geometry mesh = open_mesh(folder.file("refined.vtu"))->read_geometry();
    EXPECT_EQ(mesh.tets.size(), level.tets);
    if (stays) {
      EXPECT_EQ(boundary_of(mesh), boundary);
    }
    const Inspection found = inspect(mesh);
    EXPECT_EQ(found.degenerate + found.inverted + found.rewound + found.foldover_faces +
                  found.overfull_faces + found.duplicate_tets,
              0U);
  }
}

TEST_P(RefineAll, TheFileIsTheSameForAnyNumberOfThreadsAndWhereverTheMeshLies) {
  choose();
  rich_box(9).write(request.input);
  request.progressive = folder.file("run.tfp");
  std::string first;
  for (const bool on_disk : {false, true}) {
    for (const int threads : {1, 2, 3}) {
      request.performance.threads = threads;
      request.performance.on_disk = on_disk;
      simplify(request);
      const std::string bytes = bytes_of(request.progressive);
      if (first.empty()) first = bytes;
      EXPECT_TRUE(bytes == first) << threads << (on_disk ? " on disk" : "");
    }
  }
  expect_original();
}

INSTANTIATE_TEST_SUITE_P(Ways, RefineAll,
                         ::testing::Values(Choice{Method::kFuse, Boundary::kExact, 200'000},
                                           Choice{Method::kFuse, Boundary::kExact, 700},
                                           Choice{Method::kFuse, Boundary::kExact, 50},
                                           Choice{Method::kFuse, Boundary::kPlanar, 700},
                                           Choice{Method::kFuse, Boundary::kWithin, 200'000},
                                           Choice{Method::kFuse, Boundary::kWithin, 500},
                                           Choice{Method::kTetFuse, Boundary::kExact, 200'000},
                                           Choice{Method::kTetFuse, Boundary::kExact, 400}));

// Single precision, another encoding, a bound on the error.
TEST_F(Refine, OtherFilesAndBounds) {
  MeshFile file = rich_box(8);
  file.geometry = [&] {
    Geometry g = testing::to_float(file.geometry);
    g.lower = file.geometry.lower;
    return g;
  }();
  request.behaviour.max_error = 0.05;
  request.behaviour.chunk_tets = 900;
  simplify_both(file);
  EXPECT_LT(report.output.tets, report.input.tets);
  expect_original();
}

// Whatever is broken stays, and all the rest comes back.
TEST_F(Refine, MeshesWithSomethingWrong) {
  int simplified = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    MeshFile file;
    file.geometry = testing::damaged_mesh(seed);
    file.point_arrays.push_back(testing::point_array<double>(
        file, "f", [](const testing::Point& p) { return std::sin(p.x) + p.y * p.z; }));
    request.behaviour = {};
    request.behaviour.reduction = 0.9;
    request.behaviour.chunk_tets = seed % 2 == 0 ? 60 : 200'000;
    request.behaviour.method = seed % 3 == 0 ? Method::kTetFuse : Method::kFuse;
    if (seed % 5 == 0 && seed % 3 != 0) {
      request.behaviour.boundary = Boundary::kWithin;
      request.behaviour.boundary_distance = 0.05;
    }
    SCOPED_TRACE(seed);
    file.write(request.input);
    try {
      simplify_both(file);
    } catch (const Error& error) {
      EXPECT_NE(error.code(), ErrorCode::kBroken);
      continue;
    }
    ++simplified;
    expect_original();
    const std::string in_memory = bytes_of(request.progressive);
    request.performance.on_disk = true;
    simplify(request);
    request.performance.on_disk = false;
    EXPECT_TRUE(bytes_of(request.progressive) == in_memory);
  }
  EXPECT_GT(simplified, 20);
}

TEST_F(Refine, GoalsBelowTheBaseAndAboveTheOriginal) {
  request.behaviour.reduction = 0.6;
  simplify_both(rich_box(8));
  const RefineReport base = refine_to(10);
  EXPECT_FALSE(base.reached);
  EXPECT_EQ(base.undone, 0U);
  EXPECT_EQ(base.tets, report.output.tets);
  refine_to(report.input.tets + 5);
  EXPECT_TRUE(bytes_of(folder.file("refined.vtu")) == bytes_of(request.input));
}

// Every byte is covered by a checksum, or is one.
TEST_F(Refine, AFileThatIsDamagedIsRefused) {
  request.behaviour.reduction = 0.6;
  request.behaviour.chunk_tets = 300;
  simplify_both(rich_box(4));
  const std::string whole = bytes_of(request.progressive);
  const auto refuses = [&](const std::string& bytes, std::size_t at) {
    std::FILE* f = std::fopen(request.progressive.c_str(), "wb");
    ASSERT_EQ(std::fwrite(bytes.data(), 1, bytes.size(), f), bytes.size());
    std::fclose(f);
    try {
      refine_to();
      ADD_FAILURE() << "byte " << at << " does not matter";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBadInput) << at << ": " << error.what();
      EXPECT_THAT(error.what(), HasSubstr("run.tfp"));
    }
    EXPECT_FALSE(std::filesystem::exists(folder.file("refined.vtu")));
  };
  for (std::size_t i = 0; i < whole.size(); i += i < 4096 ? 1 : 7) {
    std::string bytes = whole;
    bytes[i] = static_cast<char>(bytes[i] ^ (1 << i % 8));
    refuses(bytes, i);
  }
  for (std::size_t i = 1; i < whole.size(); i += i < 512 ? 1 : 13) refuses(whole.substr(0, i), i);
}

TEST_F(Refine, WhatDoesNotGoTogetherYetIsRefused) {
  rich_box(4).write(request.input);
  request.progressive = folder.file("run.tfp");
  request.behaviour.reduction = 0.5;
  const auto refuses = [&](auto change, ErrorCode code) {
    SimplifyRequest changed = request;
    change(&changed);
    try {
      simplify(changed);
      ADD_FAILURE() << "it goes together";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      EXPECT_THAT(error.what(), HasSubstr("--progressive"));
    }
    EXPECT_FALSE(std::filesystem::exists(request.progressive));
    EXPECT_FALSE(std::filesystem::exists(request.output));
  };
  refuses([](auto* r) { r->behaviour.conserve = true; }, ErrorCode::kUsage);
  refuses([](auto* r) { r->behaviour.tetrahedralize = true; }, ErrorCode::kUsage);
  refuses([](auto* r) { r->behaviour.linearize = true; }, ErrorCode::kUsage);
  refuses([](auto* r) { r->progressive = "-"; }, ErrorCode::kUsage);
  refuses(
      [&](auto* r) {
        r->behaviour.lods = {0.2, 0.5};
        r->output = folder.file("out_{lod}.vtu");
      },
      ErrorCode::kUsage);
}

}  // namespace
}  // namespace tetfusion
