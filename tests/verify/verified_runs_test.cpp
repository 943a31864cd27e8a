// Runs that are verified: all that is promised is kept, however the result is written, and the
// bytes are those of a run that is not verified.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "base/resources.h"
#include "driver/simplify.h"
#include "support/damaged_meshes.h"
#include "support/file_request.h"
#include "support/mesh_file.h"
#include "support/temp_dir.h"
#include "verify/result_seam.h"

namespace tetfusion {
namespace {

using testing::bytes_of;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::MeshFile;
using testing::rich_box;
using testing::TempDir;
namespace fs = std::filesystem;

class VerifiedRun : public ::testing::Test {
 protected:
  SimplifyReport run() {
    request.verify = true;
    return simplify(request);
  }
  static double allowed(const Verification& v, const std::string& name) {
    for (const VerifiedCheck& check : v.checks) {
      if (check.name == name) return check.allowed;
    }
    return -1;
  }

  TempDir folder = TempDir::in_memory();
  SimplifyRequest request = [this] {
    SimplifyRequest r = testing::request_in(folder);
    r.behaviour.tets = 2500;
    return r;
  }();
};

TEST_F(VerifiedRun, HasTheBytesOfOneThatIsNot) {
  rich_box(10).write(request.input);
  request.behaviour.chunk_tets = 900;
  for (const Encoding encoding :
       {Encoding::kRaw, Encoding::kZlib, Encoding::kLz4, Encoding::kInline, Encoding::kAscii}) {
    request.encoding = encoding;
    request.verify = false;
    EXPECT_TRUE(simplify(request).verified.empty());
    const std::string bytes = bytes_of(request.output);
    for (const bool on_disk : {false, true}) {
      request.performance.on_disk = on_disk;
      const SimplifyReport report = run();
      ASSERT_EQ(report.verified.size(), 1u);
      EXPECT_EQ(report.verified[0].path, request.output);
      EXPECT_GT(report.verified[0].checks.size(), 12u);
      EXPECT_EQ(bytes_of(request.output) == bytes, true);
      EXPECT_THAT(to_json(report), HasSubstr("\"verified\": ["));
    }
  }
}

TEST_F(VerifiedRun, OfSeveralLevelsAndOfPieces) {
  rich_box(10).write(request.input);
  request.behaviour.tets.reset();
  request.behaviour.lods = {0.3, 0.5};
  request.output = folder.file("out_{lod}.vtu");
  EXPECT_EQ(run().verified.size(), 2u);
  request.output = folder.file("out_{lod}.pvtu");
  request.pieces = 3;
  const SimplifyReport report = run();
  ASSERT_EQ(report.verified.size(), 2u);
  EXPECT_EQ(report.verified[1].path, folder.file("out_2.pvtu"));
  // Three pieces and one of cells of lower dimension.
  const auto files = fs::directory_iterator(folder.file("out_2_pieces"));
  EXPECT_EQ(std::distance(files, {}), 4);
  request.pieces = 512;
  EXPECT_THROW(run(), Error);
}

TEST_F(VerifiedRun, SaysWhatItHasVerified) {
  rich_box(8).write(request.input);
  request.behaviour.arrays = {"f:3%", "cell:stress", "ids"};
  request.behaviour.max_error = 0.5;
  Verification v = run().verified.at(0);
  EXPECT_EQ(allowed(v, "error:f"), 0.03);
  EXPECT_EQ(allowed(v, "error:ids"), -1);
  EXPECT_THAT(v.not_verified,
              ElementsAre(HasSubstr("the error of cell:stress: its bound is for its "
                                    "means at the points, which no file holds"),
                          HasSubstr("the error of ids: its bound is for the smooth "
                                    "field through its whole numbers")));
  EXPECT_EQ(allowed(v, "boundary"), 0);
  EXPECT_EQ(allowed(v, "interfaces"), 0);
  EXPECT_EQ(allowed(v, "integral:f"), -1);
  request.behaviour = {};
  request.behaviour.tets = 1000;
  request.behaviour.regions = std::vector<std::string>{};
  request.behaviour.boundary = Boundary::kPlanar;
  request.behaviour.conserve = true;
  v = run().verified.at(0);
  EXPECT_EQ(allowed(v, "boundary"), 0x1p-40);
  EXPECT_EQ(allowed(v, "interfaces"), -1);
  EXPECT_GE(allowed(v, "integral:f"), 1e-6);
  EXPECT_GE(allowed(v, "integral:tensor"), 1e-12);
  EXPECT_LT(allowed(v, "integral:tensor"), 1e-11);
  EXPECT_EQ(allowed(v, "error:f"), -1);
}

// What was broken in the input may be as broken in the result.
TEST_F(VerifiedRun, OfMeshesThatAreBroken) {
  int verified = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    MeshFile file;
    file.geometry = testing::damaged_mesh(seed);
    file.point_arrays.push_back(testing::point_array<double>(
        file, "f", [](const testing::Point& p) { return p.x * p.x + p.y; }));
    file.write(request.input);
    request.behaviour.tets = 1;
    request.behaviour.max_error = seed % 2 == 0 ? std::optional(0.05) : std::nullopt;
    request.behaviour.boundary = seed % 3 == 0 ? Boundary::kPlanar : Boundary::kExact;
    try {
      run();
      ++verified;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("no boundary")) << seed;
    }
  }
  EXPECT_GT(verified, 50);
}

TEST_F(VerifiedRun, NeedsMemoryForIt) {
  rich_box(24).write(request.input);
  request.behaviour.tets = 60'000;
  request.behaviour.chunk_tets = 3000;
  request.performance.threads = 1;
  request.performance.memory = std::uint64_t{72} << 20;
  EXPECT_NO_THROW(simplify(request));
  try {
    run();
    ADD_FAILURE() << "it should have been refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kMemory);
  }
  set_thread_count(0);
}

}  // namespace
}  // namespace tetfusion
