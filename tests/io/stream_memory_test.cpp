// How much memory reading takes: resident, mapped pages included.
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/resources.h"
#include "io/open_mesh.h"
#include "io/source/mesh_stream.h"
#include "support/meshes.h"
#include "support/temp_dir.h"
#include "support/units.h"
#include "support/vtu_text.h"
#include "support/write_mesh.h"

namespace tetfusion {
namespace {

using testing::kMiB;
using testing::TempDir;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

// Of this process, in bytes: "VmRSS:" or "VmHWM:".
std::uint64_t resident(const std::string& name) {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word) {
    std::uint64_t kilobytes = 0;
    if (word == name && status >> kilobytes) return kilobytes << 10;
  }
  return 0;
}

// The most that was resident during f() beyond what was before. Nothing where the system cannot
// tell.
template <class F>
std::optional<std::uint64_t> peak_of(F f) {
  trim_memory();
  const std::uint64_t before = resident("VmRSS:");
  if (!(std::ofstream("/proc/self/clear_refs") << "5" << std::flush)) return std::nullopt;
  if (before == 0 || resident("VmHWM:") > before + (std::uint64_t{8} << 20)) return std::nullopt;
  f();
  return resident("VmHWM:") - before;
}

class StreamMemory : public ::testing::TestWithParam<Encoding> {
 protected:
  void SetUp() override {
    if (kSanitized) GTEST_SKIP() << "sanitizers take memory of their own";
    // As long as the threshold adapts itself, memory that is freed may stay.
    ::mallopt(M_MMAP_THRESHOLD, 1 << 20);
    set_thread_count(2);
    write();
  }
  void TearDown() override { set_thread_count(0); }

  // 1.3 million tetrahedra, 275,000 points, arrays: 76 MB when it is raw.
  void write() {
    const Geometry mesh = testing::five_split_cube(64);
    testing::OutputMesh out;
    out.points = &mesh.points;
    out.tets = &mesh.tets;
    out.point_data.arrays = {{"f", ValueType::kFloat64, 2, {}, 0}};
    out.cell_data.arrays = {{"g", ValueType::kFloat32, 1, {}, 0}};
    out.read_array = [&](Association association, std::size_t) {
      DataArray array;
      const bool of_points = association == Association::kPoint;
      array.info = of_points ? out.point_data.arrays[0] : out.cell_data.arrays[0];
      array.info.tuples = of_points ? point_count(mesh.points) : mesh.tets.size();
      array.bytes.assign(array.info.values() * size_of(array.info.type), std::byte{1});
      return array;
    };
    write_mesh(out, path_, {GetParam(), {}});
  }

  TempDir dir_;
  std::string path_ = dir_.file("mesh.vtu");
};

// All cells, points and, where there are, arrays.
void read_windows(const std::string& path, std::uint64_t window) {
  const auto source = open_mesh(path);
  const auto stream = open_stream(source.get());
  CellWindow cells;
  for (std::uint64_t first = 0; first < stream->cells(); first += window) {
    stream->read_cells(first, std::min(window, stream->cells() - first), &cells);
  }
  Vector<std::byte> rows(window * 3 * sizeof(double));
  for (std::uint64_t first = 0; first < stream->points(); first += window) {
    const std::uint64_t count = std::min(window, stream->points() - first);
    stream->read_points(first, count, rows);
    if (source->description().point_data.arrays.empty()) continue;
    stream->read_rows(Association::kPoint, 0, first, count, rows);
  }
  for (std::uint64_t first = 0; first < stream->cells(); first += window) {
    const std::uint64_t count = std::min(window, stream->cells() - first);
    if (source->description().cell_data.arrays.empty()) continue;
    stream->read_rows(Association::kCell, 0, first, count, rows);
  }
}

TEST_P(StreamMemory, DoesNotGrowWithTheFile) {
  constexpr std::uint64_t kWindow = 100'000;  // 1.6 MB of tetrahedra, 2.4 MB of points
  const auto peak = peak_of([&] { read_windows(path_, kWindow); });
  if (!peak) GTEST_SKIP() << "the system does not tell";
  EXPECT_LT(*peak, 32 * kMiB);
}

TEST_P(StreamMemory, OfTheWholeMeshIsKnownBefore) {
  const auto source = open_mesh(path_);
  const std::uint64_t estimate = source->memory_to_read();
  const auto peak = peak_of([&] {
    const Geometry mesh = source->read_geometry();
    const DataArray f = source->read_array(Association::kPoint, 0);
    const DataArray g = source->read_array(Association::kCell, 0);
  });
  if (!peak) GTEST_SKIP() << "the system does not tell";
  EXPECT_GT(estimate, *peak * 6 / 10);
  EXPECT_LT(estimate, *peak * 14 / 10);
}

// As some programs write them: each array compressed as one, so that it is decoded as one.
TEST(OneBlock, IsPartOfWhatReadingTakes) {
  if (kSanitized) GTEST_SKIP() << "sanitizers take memory of their own";
  TempDir dir;
  const std::string path = dir.file("mesh.vtu");
  {
    const Geometry mesh = testing::five_split_cube(64);
    std::vector<double> coordinates, ids;
    for (const Vec3<double>& p : std::get<Vector<Vec3<double>>>(mesh.points)) {
      coordinates.insert(coordinates.end(), {p.x, p.y, p.z});
    }
    for (const Tet& tet : mesh.tets) ids.insert(ids.end(), tet.begin(), tet.end());
    testing::VtuText text;
    text.pieces = {testing::tet_piece(coordinates, ids, "Float32", "Int64")};
    testing::VtuStyle style;
    style.data = testing::VtuData::kInline;
    style.compressor = "vtkZLibDataCompressor";
    style.block_bytes = ids.size() * sizeof(std::int64_t);
    testing::write_file(path, testing::to_vtu(text, style));
  }
  set_thread_count(2);
  const auto source = open_mesh(path);
  ASSERT_EQ(source->stream(), nullptr);
  const std::uint64_t estimate = source->memory_to_read();
  const auto peak = peak_of([&] { source->read_geometry(); });
  set_thread_count(0);
  if (!peak) GTEST_SKIP() << "the system does not tell";
  EXPECT_GT(estimate, *peak * 8 / 10);
  EXPECT_LT(estimate, *peak * 14 / 10);
}

// The other formats' readers: the same mesh, but for the arrays that have no place there.
class FormatMemory : public StreamMemory {};

TEST_P(FormatMemory, DoesNotGrowWithTheFile) {
  constexpr std::uint64_t kWindow = 100'000;
  for (const char* name : {"mesh.vtk", "mesh.msh", "mesh.mesh", "mesh.meshb", "mesh.node"}) {
    const std::string file = dir_.file(name);
    const bool binary_only = std::string(name) == "mesh.meshb";
    const Encoding encoding = binary_only ? Encoding::kRaw : GetParam();
    write_mesh(open_mesh(path_).get(), file, {encoding, {}});
    const auto peak = peak_of([&] { read_windows(file, kWindow); });
    if (!peak) GTEST_SKIP() << "the system does not tell";
    EXPECT_LT(*peak, 40 * kMiB) << name;
  }
}

std::string name_of_encoding(const ::testing::TestParamInfo<Encoding>& info) {
  constexpr std::array kNames = {"Raw", "Zlib", "Lz4", "Inline", "Ascii"};
  return kNames[static_cast<std::size_t>(info.param)];
}

INSTANTIATE_TEST_SUITE_P(Encodings, StreamMemory,
                         ::testing::Values(Encoding::kRaw, Encoding::kZlib, Encoding::kLz4,
                                           Encoding::kInline, Encoding::kAscii),
                         name_of_encoding);
INSTANTIATE_TEST_SUITE_P(Encodings, FormatMemory,
                         ::testing::Values(Encoding::kRaw, Encoding::kAscii), name_of_encoding);

}  // namespace
}  // namespace tetfusion
