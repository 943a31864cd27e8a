#include "driver/fingerprint.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "support/temp_dir.h"

namespace tetfusion {
namespace {

TEST(Fingerprint, KnowsASpooledInputByItsBytes) {
  SimplifyRequest request;
  MeshDescription mesh;
  mesh.path = "-";
  mesh.file_bytes = 100;
  mesh.spooled_checksum = 1;
  const std::string one = fingerprint(request, mesh);
  EXPECT_EQ(fingerprint(request, mesh), one);
  mesh.spooled_checksum = 2;
  EXPECT_NE(fingerprint(request, mesh), one);
}

TEST(Fingerprint, KnowsEachOption) {
  using Change = void (*)(SimplifyRequest*);
  const std::vector<Change> changes{
      [](auto r) { r->behaviour.method = Method::kTetFuse; },
      [](auto r) { r->behaviour.boundary_rule = BoundaryRule::kTets; },
      [](auto r) { r->behaviour.reduction = 0.5; },
      [](auto r) { r->behaviour.tets = 50; },
      [](auto r) { r->behaviour.scalar_tolerance = {0.1}; },
      [](auto r) { r->behaviour.stretch_factor = {2}; },
      [](auto r) { r->behaviour.aspect_ratio = 2; },
      [](auto r) { r->behaviour.max_volume = 0.1; },
      [](auto r) { r->behaviour.min_quality = 0.1; },
      [](auto r) { r->behaviour.max_rms = 0.1; },
      [](auto r) { r->behaviour.give_up_rms = 0.1; },
      [](auto r) { r->behaviour.max_error = 0.1; },
      [](auto r) { r->behaviour.conserve = true; },
      [](auto r) { r->behaviour.boundary = Boundary::kWithin; },
      [](auto r) { r->behaviour.boundary_distance = 0.1; },
      [](auto r) { r->behaviour.feature_angle = 90; },
      [](auto r) { r->behaviour.arrays = {"f"}; },
      [](auto r) { r->behaviour.regions.emplace(); },
      [](auto r) { r->behaviour.regions = {"f"}; },
      [](auto r) { r->behaviour.interest = {"f>0"}; },
      [](auto r) { r->behaviour.fit_values = false; },
      [](auto r) { r->behaviour.weight = std::string("f"); },
      [](auto r) { r->behaviour.lods = {0.5}; },
      [](auto r) { r->behaviour.chunk_tets = 1000; },
      [](auto r) { r->behaviour.original_ids = true; },
      [](auto r) { r->behaviour.tetrahedralize = true; },
      [](auto r) { r->behaviour.linearize = true; },
      [](auto r) { r->behaviour.merge_points = true; },
      [](auto r) { r->behaviour.drop_patches = true; },
      [](auto r) { r->behaviour.dropped_patches = {"wall"}; },
      [](auto r) { r->output = "o.vtu"; },
      [](auto r) { r->encoding = Encoding::kAscii; },
      [](auto r) { r->pieces = 2; },
      [](auto r) { r->progressive = "o.tfp"; },
      [](auto r) { r->map = "o.map"; }};
  MeshDescription mesh;
  mesh.spooled_checksum = 1;
  std::set<std::string> all{fingerprint({}, mesh)};
  for (const Change change : changes) {
    SimplifyRequest request;
    change(&request);
    all.insert(fingerprint(request, mesh));
  }
  mesh.time_step = 1;
  all.insert(fingerprint({}, mesh));
  EXPECT_EQ(all.size(), changes.size() + 2);
}

// The time of change apart: a file may have been written over within one tick of the clock.
TEST(Fingerprint, KnowsAFileByItsSizeTimeAndSamples) {
  const testing::TempDir dir;
  SimplifyRequest request;
  MeshDescription mesh;
  mesh.path = dir.file("a");
  mesh.file_bytes = 300'000;
  const auto write = [&](char first) {
    std::ofstream(mesh.path, std::ios::binary) << first << std::string(299'999, 'x');
  };
  write('x');
  const auto time = std::filesystem::last_write_time(mesh.path);
  const std::string one = fingerprint(request, mesh);
  std::filesystem::last_write_time(mesh.path, time + std::chrono::seconds(1));
  EXPECT_NE(fingerprint(request, mesh), one);
  write('y');
  std::filesystem::last_write_time(mesh.path, time);
  EXPECT_NE(fingerprint(request, mesh), one);
  write('x');
  std::filesystem::last_write_time(mesh.path, time);
  EXPECT_EQ(fingerprint(request, mesh), one);
}

}  // namespace
}  // namespace tetfusion
