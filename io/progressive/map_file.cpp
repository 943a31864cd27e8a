#include "io/progressive/map_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "base/error.h"
#include "base/vector.h"
#include "io/vtk/cell_order.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

constexpr std::array<char, 8> kMagic{'T', 'F', 'P', 'T', 'S', 'M', 'A', 'P'};
constexpr std::uint32_t kByteOrder = 0x01020304;
constexpr std::uint32_t kVersion = 2;
constexpr std::uint64_t kAlignment = 8;

struct Header {
  std::array<char, 8> magic = kMagic;
  std::uint32_t byte_order = kByteOrder;
  std::uint32_t version = kVersion;
  std::uint64_t file_bytes = 0;
  std::uint64_t original_points = 0, original_cells = 0;
  std::uint64_t points = 0, tets = 0, cells = 0, corners = 0, shares = 0;
  std::uint64_t coordinate_bytes = 0;
  std::uint64_t tets_sum = 0;    // TetsChecksum of the original
  std::uint64_t sum = 0;         // of all that follows the header
  std::uint64_t header_sum = 0;  // of the header up to here
};
static_assert(sizeof(Header) == 112);
static_assert(sizeof(MapPlace) == 40 && sizeof(MapShare) == 24);
static_assert(sizeof(MapHome) == 8 && sizeof(MapOrigin) == 16);

std::uint64_t header_sum(const Header& header) {
  return checksum(std::as_bytes(std::span(&header, 1)).first(offsetof(Header, header_sum)));
}

}  // namespace

MapWriter::MapWriter(OutputFile* file, std::uint64_t original_points, std::uint64_t original_cells,
                     const Geometry& mesh)
    : file_(file) {
  const CellOrder cells{mesh.tets.size(), &mesh.lower};
  counts_ = {original_points,
             original_cells,
             point_count(mesh.points),
             mesh.tets.size(),
             cells.size(),
             4 * mesh.tets.size() + mesh.lower.connectivity.size(),
             0,
             point_type(mesh.points)};
  const Header header;
  file_->append(&header, sizeof header);
  std::visit([&](const auto& points) { append(std::as_bytes(std::span(points))); }, mesh.points);
  align();
  // In runs, as they are wider here.
  constexpr std::uint64_t kRun = std::uint64_t{1} << 16;
  Vector<std::int64_t> numbers;
  const auto put_all = [&](std::uint64_t count, auto number_at) {
    for (std::uint64_t first = 0; first < count; first += kRun) {
      numbers.clear();
      for (std::uint64_t i = first; i < std::min(first + kRun, count); ++i) {
        numbers.push_back(number_at(i));
      }
      append(std::as_bytes(std::span(numbers)));
    }
  };
  put_all(4 * counts_.tets, [&](std::uint64_t i) { return std::int64_t{mesh.tets[i / 4][i % 4]}; });
  put_all(mesh.lower.connectivity.size(),
          [&](std::uint64_t i) { return std::int64_t{mesh.lower.connectivity[i]}; });
  put_all(counts_.cells + 1,
          [&](std::uint64_t i) { return i == 0 ? std::int64_t{0} : cells.end(i - 1); });
  Vector<std::uint8_t> types(counts_.cells);
  for (std::uint64_t c = 0; c < counts_.cells; ++c) types[c] = cells.type(c);
  append(std::as_bytes(std::span(types)));
  align();
}

void MapWriter::put(std::span<const MapShare> shares) {
  counts_.shares += shares.size();
  append(std::as_bytes(shares));
}

void MapWriter::append(std::span<const std::byte> bytes) {
  sum_.add(bytes);
  file_->append(bytes.data(), bytes.size());
}

void MapWriter::align() {
  constexpr std::array<std::byte, kAlignment> kZeros{};
  append(std::span(kZeros).first((kAlignment - file_->size() % kAlignment) % kAlignment));
}

void MapWriter::finish(std::uint64_t tets_sum) {
  Header header;
  header.file_bytes = file_->size();
  header.original_points = counts_.original_points;
  header.original_cells = counts_.original_cells;
  header.points = counts_.points;
  header.tets = counts_.tets;
  header.cells = counts_.cells;
  header.corners = counts_.corners;
  header.shares = counts_.shares;
  header.coordinate_bytes = size_of(counts_.point_type);
  header.tets_sum = tets_sum;
  header.sum = sum_.value();
  header.header_sum = header_sum(header);
  file_->overwrite(0, &header, sizeof header);
}

MapFile::MapFile(MappedFile file) : file_(std::move(file)) {}

MapFile MapFile::open(const std::string& path) {
  MapFile map(MappedFile::open(path));
  map.read_header();
  map.find_sections();
  map.check_sum();
  map.check_numbers();
  map.check();
  return map;
}

void MapFile::fail(const std::string& what) const {
  file_.check();
  throw Error(ErrorCode::kBadInput, fmt::format("{}: {}: write it again with 'tetfusion simplify "
                                                "--map'",
                                                path(), what));
}

void MapFile::read_header() {
  Header header;
  const std::span<const std::byte> bytes = file_.bytes();
  if (bytes.size() < sizeof header || std::memcmp(bytes.data(), kMagic.data(), 8) != 0) {
    fail("this is no map of a simplification");
  }
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.byte_order != kByteOrder) fail("the map is of a machine with another byte order");
  if (header.version != kVersion) {
    fail(fmt::format("the map is of version {}, and this program reads {}", header.version,
                     kVersion));
  }
  if (header.header_sum != header_sum(header)) fail("the head of the map is damaged");
  if (header.file_bytes != file_.size()) {
    fail(fmt::format("the map has {} bytes, where {} were written", file_.size(),
                     header.file_bytes));
  }
  if (header.coordinate_bytes != 4 && header.coordinate_bytes != 8) {
    fail("the head of the map is damaged");
  }
  counts_ = {header.original_points,
             header.original_cells,
             header.points,
             header.tets,
             header.cells,
             header.corners,
             header.shares,
             header.coordinate_bytes == 4 ? ValueType::kFloat32 : ValueType::kFloat64};
  tets_sum_ = header.tets_sum;
  sum_ = header.sum;
}

// Each takes its part of what is left, so that no count is believed that the file is too short for.
void MapFile::find_sections() {
  std::span<const std::byte> left = file_.bytes().subspan(sizeof(Header));
  const auto take = [&]<class T>(std::span<const T>* section, std::uint64_t count) {
    if (count > left.size() / sizeof(T)) fail("the map is shorter than what it says to hold");
    *section = {reinterpret_cast<const T*>(left.data()), count};
    left = left.subspan(count * sizeof(T));
    const auto at = static_cast<std::uint64_t>(left.data() - file_.bytes().data());
    left = left.subspan(
        std::min<std::uint64_t>((kAlignment - at % kAlignment) % kAlignment, left.size()));
  };
  const std::uint64_t coordinate = size_of(counts_.point_type);
  if (counts_.points > left.size() / (3 * coordinate) || counts_.cells > left.size() ||
      counts_.tets > counts_.cells || 4 * counts_.tets > counts_.corners) {
    fail("the map is shorter than what it says to hold");
  }
  take(&points_, 3 * coordinate * counts_.points);
  take(&corners_, counts_.corners);
  take(&ends_, counts_.cells + 1);
  take(&types_, counts_.cells);
  take(&places_, counts_.original_points);
  take(&homes_, counts_.original_cells);
  take(&origins_, counts_.cells);
  take(&shares_, counts_.shares);
  if (!left.empty()) fail("the map is longer than what it says to hold");
}

void MapFile::check_sum() const {
  constexpr std::size_t kRun = std::size_t{1} << 24;
  RunningChecksum sum;
  const std::span<const std::byte> all = file_.bytes();
  for (std::size_t at = sizeof(Header); at < all.size(); at += kRun) {
    const std::size_t count = std::min(kRun, all.size() - at);
    sum.add(all.subspan(at, count));
    file_.dont_need(at, count);
  }
  if (sum.value() != sum_) fail("the map is damaged: it does not agree with its checksum");
}

// But for those of cells of lower dimension, which whoever opens mesh() checks.
void MapFile::check_numbers() const {
  const auto is_weight = [](double w) { return w >= 0 && w <= 1; };
  for (std::uint64_t t = 0; t < counts_.tets; ++t) {
    bool right = types_[t] == kVtkTetra && ends_[t] == static_cast<std::int64_t>(4 * t);
    for (const std::int64_t v : corners(t)) {
      right &= static_cast<std::uint64_t>(v) < counts_.points;
    }
    if (!right) fail(fmt::format("cell {} of the map is no tetrahedron of its points", t));
  }
  constexpr std::size_t kRun = std::size_t{1} << 18;
  const auto forget_run = [&](const auto& section, std::size_t i) {
    if (i % kRun == 0 && i > 0) forget(section.subspan(i - kRun, kRun));
  };
  for (std::size_t i = 0; i < places_.size(); ++i) {
    forget_run(places_, i);
    const MapPlace& place = places_[i];
    const bool right = (place.cell == kNoCell || place.cell < counts_.tets) &&
                       std::all_of(place.weights.begin(), place.weights.end(), is_weight);
    if (!right) fail(fmt::format("the place of point {} is none", i));
  }
  for (std::size_t i = 0; i < homes_.size(); ++i) {
    forget_run(homes_, i);
    const auto [tet, share] = homes_[i];
    const bool right =
        tet == kNoTet ? share == 0 : tet < counts_.tets && share > 0 && std::isfinite(share);
    if (!right) fail(fmt::format("the home of cell {} is none", i));
  }
  for (std::size_t i = 0; i < origins_.size(); ++i) {
    const auto [cell, is_mean] = origins_[i];
    const bool right = cell < counts_.original_cells && is_mean <= (i < counts_.tets ? 1U : 0U);
    if (!right) fail(fmt::format("the origin of cell {} is none", i));
  }
  const auto before = [](const MapShare& a, const MapShare& b) {
    return std::pair(a.original, a.point) < std::pair(b.original, b.point);
  };
  for (std::size_t i = 0; i < shares_.size(); ++i) {
    forget_run(shares_, i);
    const MapShare& share = shares_[i];
    const bool right = share.original < counts_.original_points && share.point < counts_.points &&
                       share.weight > 0 && share.weight <= 1 &&
                       (i == 0 || before(shares_[i - 1], share));
    if (!right) fail(fmt::format("share {} is none", i));
  }
}

MeshView MapFile::mesh() const {
  MeshView view;
  view.name = path();
  view.points = {counts_.point_type, points_};
  view.connectivity = {ValueType::kInt64, std::as_bytes(corners_)};
  view.offsets = {ValueType::kInt64, std::as_bytes(ends_)};
  view.types = types_;
  return view;
}

}  // namespace tetfusion
