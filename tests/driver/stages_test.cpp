#include "driver/request/check_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "base/error.h"

namespace tetfusion {
namespace {

using ::testing::HasSubstr;

std::string refusal(const std::function<void(BehaviourOptions*)>& change) {
  SimplifyRequest request;
  request.output = "{lod}.vtu";
  request.behaviour.lods = {0.25, 0.5};
  change(&request.behaviour);
  try {
    check_options(request);
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kUsage);
    return e.what();
  }
  return "";
}

TEST(CheckOptions, LevelsMustAscend) {
  EXPECT_EQ(refusal([](auto) {}), "");
  EXPECT_THAT(refusal([](auto b) { b->lods = {0.5, 0.25}; }), HasSubstr("must ascend"));
  EXPECT_THAT(refusal([](auto b) { b->lods = {0.125, 0.5, 0.5}; }), HasSubstr("two levels of 50%"));
  EXPECT_THAT(refusal([](auto b) { b->lods = {0.5, 1}; }), HasSubstr("less than 100%"));
}

TEST(CheckOptions, PiecesNeedAFileThatNamesThem) {
  SimplifyRequest request;
  request.output = "a.pvtu";
  request.pieces = 3;
  check_options(request);
  request.output = "a.vtu";
  EXPECT_THROW(check_options(request), Error);
  request.pieces = 0;
  check_options(request);
}

// Their numbers have 32 bits.
TEST(RefuseOutputs, OfAWayBackOrAMapForMoreCellsThanTheyCanNumber) {
  SimplifyRequest way_back, map;
  way_back.output = map.output = "a.vtu";
  way_back.progressive = "a.tfp";
  map.map = "a.map";
  MeshDescription mesh;
  mesh.cells = kMaxTets;
  refuse_outputs_among(mesh, way_back);
  ++mesh.cells;
  EXPECT_THROW(refuse_outputs_among(mesh, way_back), Error);
  way_back.progressive.clear();
  refuse_outputs_among(mesh, way_back);
  mesh.cells = kNoTet;
  refuse_outputs_among(mesh, map);
  ++mesh.cells;
  EXPECT_THROW(refuse_outputs_among(mesh, map), Error);
}

}  // namespace
}  // namespace tetfusion
