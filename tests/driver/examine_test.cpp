#include "driver/examine/examine.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <string>

#include "base/error.h"
#include "base/resources.h"
#include "io/open_mesh.h"
#include "support/damaged_meshes.h"
#include "support/mesh_file.h"
#include "support/meshes.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using testing::MeshFile;

void expect_same_distribution(const Distribution& a, const Distribution& b) {
  EXPECT_EQ(a.min, b.min);
  EXPECT_EQ(a.p1, b.p1);
  EXPECT_EQ(a.max, b.max);
  EXPECT_NEAR(a.mean, b.mean, 1e-12 * std::abs(a.mean));
}

// `sides_are_clear`: InterfaceInspection says when another side of a fold may count as inverted.
void expect_same(const Examination& whole, const Examination& cut, bool sides_are_clear) {
  const InspectionSummary &a = whole.mesh, &b = cut.mesh;
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.tets, b.tets);
  EXPECT_EQ(a.lower_vertices, b.lower_vertices);
  EXPECT_EQ(a.lower_lines, b.lower_lines);
  EXPECT_EQ(a.lower_triangles, b.lower_triangles);
  EXPECT_EQ(a.unused_points, b.unused_points);
  EXPECT_EQ(a.merged_points, b.merged_points);
  EXPECT_EQ(a.ghost_cells, b.ghost_cells);
  EXPECT_EQ(a.coincident_points, b.coincident_points);
  EXPECT_EQ(a.components, b.components);
  EXPECT_EQ(a.surface_components, b.surface_components);
  EXPECT_EQ(a.surface_euler(), b.surface_euler());
  EXPECT_EQ(a.degenerate, b.degenerate);
  EXPECT_EQ(a.duplicate_tets, b.duplicate_tets);
  EXPECT_EQ(a.foldover_faces, b.foldover_faces);
  EXPECT_EQ(a.overfull_faces, b.overfull_faces);
  EXPECT_EQ(a.nonmanifold_edges, b.nonmanifold_edges);
  EXPECT_EQ(a.boundary_faces, b.boundary_faces);
  EXPECT_NEAR(a.volume, b.volume, 1e-11 * a.volume);
  EXPECT_EQ(a.lower, b.lower);
  EXPECT_EQ(a.upper, b.upper);
  EXPECT_EQ(whole.quality.mean_ratio_bins, cut.quality.mean_ratio_bins);
  EXPECT_EQ(whole.quality.dihedral_bins, cut.quality.dihedral_bins);
  EXPECT_EQ(whole.quality.longest_edge, cut.quality.longest_edge);
  EXPECT_EQ(whole.quality.shortest_edge, cut.quality.shortest_edge);
  EXPECT_EQ(whole.quality.max_aspect, cut.quality.max_aspect);
  expect_same_distribution(whole.quality.mean_ratio, cut.quality.mean_ratio);
  expect_same_distribution(whole.quality.min_dihedral_deg, cut.quality.min_dihedral_deg);
  for (const Defect kind :
       {Defect::kDegenerate, Defect::kDuplicate, Defect::kFoldoverFace, Defect::kOverfullFace,
        Defect::kNonmanifoldEdge, Defect::kCoincidentPoint}) {
    EXPECT_EQ(a.first(kind), b.first(kind)) << static_cast<int>(kind);
    EXPECT_EQ(a.places_of(kind), b.places_of(kind)) << static_cast<int>(kind);
  }
  if (!sides_are_clear) return;
  EXPECT_EQ(a.inverted, b.inverted);
  EXPECT_EQ(a.rewound, b.rewound);
  EXPECT_EQ(a.nonmanifold_vertices, b.nonmanifold_vertices);
  EXPECT_EQ(a.first(Defect::kNonmanifoldVertex), b.first(Defect::kNonmanifoldVertex));
}

class Examine : public ::testing::Test {
 protected:
  Examination look(const ExamineOptions& options) const {
    return examine(open_mesh(path_).get(), options, {});
  }
  ExamineOptions in_chunks(std::uint64_t tets) const {
    ExamineOptions options;
    options.chunk_tets = tets;
    options.in_chunks = true;
    options.scratch = dir_.path().string();
    return options;
  }

  const testing::TempDir dir_;
  const std::string path_ = dir_.file("mesh.vtu");
};

TEST_F(Examine, DamagedMeshesAsTheWhole) {
  std::size_t odd = 0, inverted = 0, sampled = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(seed);
    MeshFile file;
    file.geometry = testing::damaged_mesh(seed);
    testing::shuffle(&file.geometry, seed);
    file.write(path_);
    const Examination whole = look({});
    const bool sides_are_clear = whole.mesh.foldover_faces == 0 || whole.mesh.overfull_faces == 0;
    for (const std::uint64_t tets :
         {std::uint64_t{1'000'000}, std::uint64_t{60}, std::uint64_t{9}}) {
      const Examination cut = look(in_chunks(tets));
      expect_same(whole, cut, sides_are_clear);
      const auto& samples = cut.mesh.first(Defect::kInverted);
      if (sides_are_clear && !samples.empty()) {
        EXPECT_EQ(samples, whole.mesh.first(Defect::kInverted));
        ++sampled;
      }
      inverted += sides_are_clear && cut.mesh.inverted > 0 ? 1 : 0;
    }
    odd += whole.mesh.components > 1 ? 1 : 0;
    if (HasFailure()) break;
  }
  EXPECT_GT(odd, 10u);
  EXPECT_GT(sampled, 15u) << "of " << inverted;
}

// Cells of lower dimension, points that only they use, and points of no cell; on disk, too.
TEST_F(Examine, AMeshWithEverything) {
  testing::rich_box(9).write(path_);
  const Examination whole = look({});
  EXPECT_GT(whole.mesh.lower_triangles, 0u);
  EXPECT_GT(whole.mesh.unused_points, 0u);
  ExamineOptions options = in_chunks(300);
  expect_same(whole, look(options), true);
  options.on_disk = true;
  expect_same(whole, look(options), true);
}

TEST_F(Examine, NothingStaysInTheScratchFolder) {
  testing::rich_box(6).write(path_);
  const std::string folder = dir_.file("scratch");
  std::filesystem::create_directory(folder);
  ExamineOptions options = in_chunks(300);
  options.on_disk = true;
  options.scratch = folder;
  look(options);
  EXPECT_TRUE(std::filesystem::is_empty(folder));
  const std::atomic<bool> stop = true;
  RunContext interrupted;
  interrupted.cancelled = &stop;
  EXPECT_ANY_THROW(examine(open_mesh(path_).get(), options, interrupted));
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

TEST_F(Examine, ThreadsChangeNothing) {
  MeshFile file;
  file.geometry = testing::five_split_cube(12, 0.2);
  file.write(path_);
  set_thread_count(1);
  const Examination one = look(in_chunks(500));
  set_thread_count(3);
  const Examination three = look(in_chunks(500));
  set_thread_count(0);
  expect_same(one, three, true);
  EXPECT_EQ(one.mesh.volume, three.mesh.volume);
  EXPECT_EQ(one.quality.mean_ratio.mean, three.quality.mean_ratio.mean);
}

TEST_F(Examine, SaysHowMuchMemoryItNeeds) {
  testing::rich_box(6).write(path_);
  ExamineOptions options;
  options.memory = 1 << 20;
  try {
    look(options);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kMemory);
    EXPECT_NE(std::string(e.what()).find("--memory"), std::string::npos);
  }
}

}  // namespace
}  // namespace tetfusion
