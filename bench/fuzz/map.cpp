// A map of a simplification, and another step's arrays that follow it.
#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <numeric>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/run_context.h"
#include "base/vector.h"
#include "follow/apply_map.h"
#include "follow/point_weights.h"
#include "fuzz/read_all.h"
#include "fuzz/targets.h"
#include "io/files/checksum.h"
#include "io/files/file_system.h"
#include "io/files/output_file.h"
#include "io/progressive/map_file.h"
#include "io/source/mesh_view.h"
#include "mesh/geometry.h"
#include "support/mesh_file.h"
#include "support/temp_dir.h"
#include "support/vtu_text.h"

namespace tetfusion::fuzz {

namespace {

// io/FORMAT.md.
constexpr std::size_t kHeaderBytes = 112;
constexpr std::size_t kLengthAt = 16, kSumAt = 96, kHeaderSumAt = 104;

const std::string& path() {
  static const testing::TempDir dir = testing::TempDir::in_memory();
  static const std::string name = dir.file("input.map");
  return name;
}

void put(std::string* bytes, std::size_t at, std::uint64_t value) {
  std::memcpy(bytes->data() + at, &value, sizeof value);
}

void seal(std::string* bytes) {
  if (bytes->size() < kHeaderBytes) return;
  const auto sum = [&](std::size_t from, std::size_t count) {
    return checksum(std::as_bytes(std::span(*bytes).subspan(from, count)));
  };
  put(bytes, kLengthAt, bytes->size());
  put(bytes, kSumAt, sum(kHeaderBytes, bytes->size() - kHeaderBytes));
  put(bytes, kHeaderSumAt, sum(0, kHeaderSumAt));
}

// A value and a number for each point, or cell.
struct NumberedRows {
  explicit NumberedRows(std::uint64_t count) : values(count), numbers(count) {
    std::iota(values.begin(), values.end(), 1.5);
    std::iota(numbers.begin(), numbers.end(), 1);
  }
  std::vector<ArrayView> arrays() const {
    return {{"f", 1, {ValueType::kFloat64, std::as_bytes(std::span(values))}},
            {"i", 1, {ValueType::kInt32, std::as_bytes(std::span(numbers))}}};
  }
  std::vector<double> values;
  std::vector<std::int32_t> numbers;
};

// A mesh of so many points.
std::vector<MovedArray> follow(const MapFile& map) {
  const std::uint64_t count = map.counts().original_points;
  const std::vector<float> xyz(3 * count);
  const std::vector<std::int64_t> tet(count < 4 ? 0 : 4);
  const NumberedRows rows(count);
  MeshView step;
  step.tets_only = true;
  step.points = {ValueType::kFloat32, std::as_bytes(std::span(xyz))};
  step.connectivity = {ValueType::kInt64, std::as_bytes(std::span(tet))};
  step.point_arrays = rows.arrays();
  const auto source = open_view(step);
  auto arrays = apply_map(map, source.get(), {}, RunContext{});
  const PointWeights weights(map, temporary_folder());
  apply_map(map, source.get(), {}, RunContext{}, true, &weights);
  const auto moved = open_moved(map, arrays, {}, source.get());
  read_all(moved.get());
  return arrays;
}

// The same of cells: as many tetrahedra, all in one place.
void follow_cells(const MapFile& map) {
  const std::uint64_t count = map.counts().original_cells;
  const std::vector<float> xyz(3 * 4);
  const std::vector<std::int64_t> corners(4 * count);
  const NumberedRows rows(count);
  MeshView step;
  step.tets_only = true;
  step.points = {ValueType::kFloat32, std::as_bytes(std::span(xyz))};
  step.connectivity = {ValueType::kInt64, std::as_bytes(std::span(corners))};
  step.cell_arrays = rows.arrays();
  const auto source = open_view(step);
  if (count > 0 && has_cells_of(map, source.get(), {})) throw std::logic_error("not that mesh");
  const auto moved = CellMover(map).move(source.get(), {0, 1}, {});
  const auto wrong = [&](auto value) {
    return !(value >= 1 && value <= static_cast<double>(count) + 0.5);
  };
  const auto floats = moved[0].array.as<double>();
  const auto integers = moved[1].array.as<std::int32_t>();
  if (std::any_of(floats.begin(), floats.end(), wrong) ||
      std::any_of(integers.begin(), integers.end(), wrong)) {
    throw std::logic_error("a value that no cell had");
  }
}

void read_one(const std::string& bytes) try {
  testing::write_file(path(), bytes);
  const MapFile map = MapFile::open(path());
  const std::vector<MovedArray> arrays = follow(map);
  if (arrays.size() != 2) throw std::logic_error("an array did not follow");
  // An integer is one of the original's, or none where nothing says which.
  const auto original = static_cast<std::int64_t>(map.counts().original_points);
  for (const std::int32_t number : arrays[1].array.as<std::int32_t>()) {
    if (number < 0 || number > original) throw std::logic_error("a number that no point had");
  }
  follow_cells(map);
} catch (const Error&) {
}

template <class Real>
std::string map_of() {
  Geometry mesh;
  mesh.points = Vector<Vec3<Real>>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  mesh.tets = {{0, 1, 2, 3}, {4, 1, 3, 2}};
  const std::array<MapPlace, 6> places{{{0, {1, 0, 0, 0}},
                                        {0, {0, 1, 0, 0}},
                                        {1, {0.25, 0.25, 0.25, 0.25}},
                                        {kNoCell, {}},
                                        {1, {1, 0, 0, 0}},
                                        {0, {0, 0, 0.5, 0.5}}}};
  const std::array<MapShare, 6> shares{
      {{0, 0, 1}, {1, 1, 1}, {2, 2, 0.5}, {4, 4, 1}, {5, 2, 0.5}, {5, 3, 1}}};
  const std::array<MapHome, 5> homes{{{0, 0.5F}, {1, 1}, {}, {0, 0.25F}, {1, 0.125F}}};
  const std::array<MapOrigin, 2> origins{{{2, 1}, {1, 0}}};
  OutputFile file(path(), OutputFile::Access::kPatch);
  MapWriter writer(&file, places.size(), homes.size(), mesh);
  writer.put(places);
  writer.put(homes);
  writer.put(origins);
  writer.put(shares);
  writer.finish(1);
  file.commit();
  return testing::bytes_of(path());
}

}  // namespace

void read_map(Input input) {
  std::string bytes(input.begin(), input.end());
  read_one(bytes);
  seal(&bytes);
  read_one(bytes);
}

std::vector<std::string> map_seeds() { return {map_of<float>(), map_of<double>()}; }

}  // namespace tetfusion::fuzz
