// Values that are lost where points are joined: how many, and by how much they differ.
#include "io/source/differing_copies.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/resources.h"
#include "io/source/mesh_stream.h"
#include "support/meshes.h"
#include "support/vtu_file_test.h"
#include "support/vtu_text.h"

namespace tetfusion {
namespace {

using testing::tet_piece;
using testing::uniform;
using testing::VtuArrayText;
using testing::VtuPieceText;
using testing::VtuStyle;
using testing::VtuText;

const double kNaN = std::numeric_limits<double>::quiet_NaN();

VtuArrayText array(const std::string& name, const std::string& type,
                   const std::vector<double>& values, unsigned components = 1) {
  return {name, type, values, components, "", "DataArray"};
}

// Two tetrahedra, one a piece: points 1, 2 and 3 of the first are 0, 1 and 2 of the second.
VtuText two_pieces(std::vector<VtuArrayText> first, std::vector<VtuArrayText> second) {
  VtuText mesh;
  mesh.pieces = {tet_piece({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0.1}, {0, 1, 2, 3}),
                 tet_piece({1, 0, 0, 0, 1, 0, 0, 0, 0.1, 1, 1, 0}, {3, 1, 0, 2})};
  mesh.pieces[0].point_data = std::move(first);
  mesh.pieces[1].point_data = std::move(second);
  return mesh;
}

class DifferingCopies : public testing::VtuFileTest {
 protected:
  void TearDown() override { set_thread_count(0); }

  // Read whole; windows say the same (open() has looked at the number).
  CopyDifferences found(const VtuText& mesh, const OpenOptions& options = {},
                        const VtuStyle& style = {}) {
    const auto source = open(mesh, options, style);
    const Geometry whole = source->read_geometry();
    const auto stream = open_stream(source.get());
    EXPECT_TRUE(stream->streams_from_disk());
    EXPECT_EQ(stream->differing_points(), whole.differing_points);
    EXPECT_EQ(stream->largest_difference().array, whole.largest_difference.array);
    EXPECT_EQ(stream->largest_difference().share, whole.largest_difference.share);
    return {whole.differing_points, whole.largest_difference};
  }
};

TEST_F(DifferingCopies, AcrossAFault) {
  const VtuText mesh =
      two_pieces({array("flat", "Float64", {5, 5, 5, 5}), array("u", "Float64", {0, 1, 2, 3})},
                 {array("flat", "Float64", {5, 5, 5, 5}), array("u", "Float64", {1, 0, -5, 1})});
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    const CopyDifferences d = found(mesh);
    EXPECT_EQ(d.points, 2u);
    EXPECT_EQ(d.largest.array, 1u);
    EXPECT_EQ(d.largest.share, 1.0);  // 3 and -5, of a range from -5 to 3
  }
}

TEST_F(DifferingCopies, AreNoneWhereValuesAreTheSame) {
  const VtuText mesh = two_pieces({array("u", "Float32", {7, 1, kNaN, -0.0})},
                                  {array("u", "Float32", {1, kNaN, 0, 9})});
  const CopyDifferences d = found(mesh);
  EXPECT_EQ(d.points, 0u);
  EXPECT_EQ(d.largest.share, 0);
}

TEST_F(DifferingCopies, OfPointsWithTheSameGlobalIds) {
  VtuText mesh = two_pieces(
      {array("GlobalNodeIds", "Int64", {0, 10, 20, 30}), array("u", "Float64", {0, 1, 2, 3})},
      {array("GlobalNodeIds", "Int64", {10, 20, 30, 40}), array("u", "Float64", {1, 2, 3.5, 4})});
  CopyDifferences d = found(mesh);
  EXPECT_EQ(d.points, 1u);
  EXPECT_EQ(d.largest.array, 1u);
  EXPECT_EQ(d.largest.share, 0.125);
  // Ids that tell the sides apart: nothing is joined, and nothing lost.
  mesh.pieces[1].point_data[0].values = {11, 21, 31, 40};
  d = found(mesh);
  EXPECT_EQ(d.points, 0u);
  // Joined all the same: then the ids are among what differs, but say nothing of how much.
  OpenOptions merged;
  merged.merge_points = true;
  d = found(mesh, merged);
  EXPECT_EQ(d.points, 3u);
  EXPECT_EQ(d.largest.array, 1u);
  EXPECT_EQ(d.largest.share, 0.125);
}

TEST_F(DifferingCopies, OfOnePieceWhosePointsAreMerged) {
  VtuText mesh;
  mesh.pieces = {
      tet_piece({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0.1, 1, 0, 0, 0, 1, 0, 0, 0, 0.1, 1, 1, 0},
                {0, 1, 2, 3, 7, 5, 4, 6})};
  mesh.pieces[0].point_data = {
      array("v", "Float32", {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 4, 3, 4}, 2)};
  OpenOptions merged;
  merged.merge_points = true;
  CopyDifferences d = found(mesh, merged);
  EXPECT_EQ(d.points, 1u);
  EXPECT_EQ(d.largest.share, 1.0);  // a vector's range is the diagonal of its components' box
  EXPECT_EQ(open(mesh)->read_geometry().differing_points, 0u);
  // How much NaN differs from a number nobody knows.
  mesh.pieces[0].point_data = {array("s", "Float64", {0, kNaN, 2, 3, 5, 2, 3, 4})};
  d = found(mesh, merged);
  EXPECT_EQ(d.points, 1u);
  EXPECT_EQ(d.largest.share, 0);
}

TEST_F(DifferingCopies, OfIntegersCountWhereNoOthersDiffer) {
  VtuText mesh =
      two_pieces({array("part", "UInt8", {0, 0, 0, 0}), array("u", "Float64", {0, 1, 2, 3})},
                 {array("part", "UInt8", {4, 4, 4, 4}), array("u", "Float64", {1, 2, 3, 4})});
  CopyDifferences d = found(mesh);
  EXPECT_EQ(d.points, 3u);
  EXPECT_EQ(d.largest.array, 0u);
  EXPECT_EQ(d.largest.share, 1.0);
  mesh.pieces[1].point_data[1].values[0] = 1.5;
  d = found(mesh);
  EXPECT_EQ(d.points, 3u);
  EXPECT_EQ(d.largest.array, 1u);
  EXPECT_EQ(d.largest.share, 0.125);
  // What marks ghosts says nothing of points.
  mesh = two_pieces({array("vtkGhostType", "UInt8", {0, 0, 0, 0})},
                    {array("vtkGhostType", "UInt8", {1, 1, 1, 0})});
  EXPECT_EQ(found(mesh).points, 0u);
}

TEST_F(DifferingCopies, OfPointsThatNoCellUsesAreNotLookedAt) {
  VtuText mesh =
      two_pieces({array("u", "Float64", {0, 1, 2, 3})}, {array("u", "Float64", {1, 2, 3, 4, 99})});
  mesh.pieces[1] = tet_piece({1, 0, 0, 0, 1, 0, 0, 0, 0.1, 1, 1, 0, 0, 0, 0}, {3, 1, 0, 2});
  mesh.pieces[1].point_data = {array("u", "Float64", {1, 2, 5, 4, 99})};
  const CopyDifferences d = found(mesh);
  EXPECT_EQ(d.points, 1u);
  EXPECT_EQ(d.largest.share, 0.4);
}

// More points than are read at once, in pieces of which some have no cells, in blocks.
TEST_F(DifferingCopies, OfManyPieces) {
  const Geometry whole = testing::five_split_cube(4, 0.1);
  VtuText mesh;
  std::uint64_t copies = 0, differing = 0;
  std::vector<std::uint8_t> seen(point_count(whole.points), 0);
  std::vector<double> first(seen.size(), 0);
  for (std::size_t p = 0; p < 5; ++p) {
    std::vector<double> xyz, ids, values;
    std::vector<double> local(seen.size(), -1);
    for (std::size_t t = whole.tets.size() * p / 5; t < whole.tets.size() * (p + 1) / 5; ++t) {
      for (const VertexId v : whole.tets[t]) {
        if (local[v] < 0) {
          local[v] = static_cast<double>(values.size());
          const Vec3<double> at = testing::point(whole, v);
          xyz.insert(xyz.end(), {at.x, at.y, at.z});
          const double value = uniform(v, p) < 0.5 ? static_cast<double>(p + 1) : 0;
          values.push_back(value);
          if (seen[v] != 0) ++copies;
          if (seen[v] != 0 && value != first[v]) ++differing;
          if (seen[v] == 0) first[v] = value;
          seen[v] = 1;
        }
        ids.push_back(local[v]);
      }
    }
    mesh.pieces.push_back(tet_piece(xyz, ids));
    mesh.pieces.back().point_data = {array("u", "Float32", values)};
    if (p == 2) mesh.pieces.push_back(VtuPieceText{});
  }
  VtuStyle style;
  style.compressor = "vtkZLibDataCompressor";
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    const auto source = open(mesh, {}, style);
    EXPECT_EQ(open_stream(source.get())->merged_points(), copies);
    EXPECT_EQ(found(mesh, {}, style).points, differing);
  }
}

// Rows of more originals than fit into memory at once: the array is gone through again.
TEST(FindDifferences, InSeveralGoes) {
  constexpr std::uint64_t kOriginals = 30'000, kWidth = 50, kPoints = 3 * kOriginals;
  const auto value = [](std::uint64_t point, std::uint64_t k) {
    const std::uint64_t original = point % kOriginals;
    const bool other = point >= kOriginals && k == kWidth - 1 && uniform(3, point) < 0.1;
    return static_cast<double>(original + k) + (other ? 0.25 : 0);
  };
  Vector<VertexId> copy_of(kPoints);
  Vector<std::uint8_t> used(kPoints, std::uint8_t{1});
  std::uint64_t expected = 0;
  for (std::uint64_t v = 0; v < kPoints; ++v) {
    copy_of[v] = static_cast<VertexId>(v % kOriginals);
    if (value(v, kWidth - 1) != value(v % kOriginals, kWidth - 1)) ++expected;
  }
  ArrayInfo info;
  info.name = "wide";
  info.type = ValueType::kFloat64;
  info.components = kWidth;
  info.tuples = kPoints;
  Vector<double> rows;
  std::uint64_t most = 0;
  const auto read = [&](std::size_t, std::uint64_t first, std::uint64_t count) {
    most = std::max(most, count);
    rows.resize(count * kWidth);
    for (std::uint64_t i = 0; i < count * kWidth; ++i)
      rows[i] = value(first + i / kWidth, i % kWidth);
    return std::as_bytes(std::span<const double>(rows));
  };
  const CopyDifferences d = find_differences(copy_of, used, std::vector<ArrayInfo>{info}, read);
  EXPECT_GT(expected, 0u);
  EXPECT_EQ(d.points, expected);
  EXPECT_GT(d.largest.share, 0);
  EXPECT_LE(most, std::uint64_t{1} << 16);
}

}  // namespace
}  // namespace tetfusion
