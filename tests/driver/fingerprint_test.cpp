#include "driver/fingerprint.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
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
  SimplifyRequest request;
  MeshDescription mesh;
  mesh.spooled_checksum = 1;
  const std::string one = fingerprint(request, mesh);
  SimplifyRequest other = request;
  other.behaviour.method = Method::kTetFuse;
  EXPECT_NE(fingerprint(other, mesh), one);
  other = request;
  other.behaviour.min_quality = 0.1;
  EXPECT_NE(fingerprint(other, mesh), one);
  other = request;
  other.behaviour.max_rms = 0.1;
  EXPECT_NE(fingerprint(other, mesh), one);
  other = request;
  other.behaviour.boundary = Boundary::kWithin;
  const std::string within = fingerprint(other, mesh);
  EXPECT_NE(within, one);
  other.behaviour.boundary_distance = 0.1;
  EXPECT_NE(fingerprint(other, mesh), within);
  other = request;
  other.behaviour.max_error = 0.1;
  EXPECT_NE(fingerprint(other, mesh), one);
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
