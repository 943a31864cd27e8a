#include "driver/fingerprint.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

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

TEST(Fingerprint, KnowsHowAMeshIsFused) {
  using Change = void (*)(BehaviourOptions*);
  constexpr std::array<Change, 10> kChanges{
      [](BehaviourOptions* b) { b->method = Method::kTetFuse; },
      [](BehaviourOptions* b) { b->min_quality = 0.1; },
      [](BehaviourOptions* b) { b->max_rms = 0.1; },
      [](BehaviourOptions* b) { b->max_error = 0.1; },
      [](BehaviourOptions* b) { b->max_volume = 0.1; },
      [](BehaviourOptions* b) { b->boundary = Boundary::kWithin; },
      [](BehaviourOptions* b) {
        b->boundary = Boundary::kWithin;
        b->boundary_distance = 0.1;
      },
      [](BehaviourOptions* b) { b->conserve = true; },
      [](BehaviourOptions* b) { b->interest = {"f>0"}; },
      [](BehaviourOptions* b) { b->weight = std::string("f"); }};
  SimplifyRequest request;
  MeshDescription mesh;
  mesh.spooled_checksum = 1;
  std::set<std::string> all{fingerprint(request, mesh)};
  for (const Change change : kChanges) {
    SimplifyRequest other = request;
    change(&other.behaviour);
    all.insert(fingerprint(other, mesh));
  }
  EXPECT_EQ(all.size(), kChanges.size() + 1);
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
