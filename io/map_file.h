// The file that says where each point of a mesh went when that was simplified (FORMAT.md): it holds
// the result's mesh, a place in it for each point of the original, and what each point of the
// result takes of the original's values.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "io/checksum.h"
#include "io/mapped_file.h"
#include "io/mesh_view.h"
#include "io/output_file.h"
#include "mesh/geometry.h"

namespace tetfusion {

inline constexpr std::uint64_t kNoCell = ~std::uint64_t{0};

// Where a point of the original lies in the result: between the corners of one of its tetrahedra.
// A point that no tetrahedron of the original uses lies in none.
struct MapPlace {
  std::uint64_t cell = kNoCell;
  std::array<double, 4> weights{};  // 0 to 1
};

// So much of the value at a point of the original belongs to that at a point of the result.
struct MapShare {
  std::uint64_t original = 0;
  std::uint64_t point = 0;
  double weight = 0;  // above 0, at most 1; 1 alone: the value itself
};

// What the sections hold; shares only when all is written.
struct MapCounts {
  std::uint64_t original_points = 0;
  std::uint64_t points = 0;
  std::uint64_t tets = 0;
  std::uint64_t cells = 0;    // tetrahedra first, those of lower dimension, too
  std::uint64_t corners = 0;  // of all cells
  std::uint64_t shares = 0;
  ValueType point_type = ValueType::kFloat32;  // or kFloat64
};

// Writes a map front to back. The caller commits the file, which must allow Access::kPatch.
class MapWriter {
 public:
  // Writes the mesh.
  MapWriter(OutputFile* file, std::uint64_t original_points, const Geometry& mesh);

  // All places, in the order of the original's points, in runs of any length; then all shares,
  // ascending by the original's point, then by the result's.
  void put(std::span<const MapPlace> places) { append(std::as_bytes(places)); }
  void put(std::span<const MapShare> shares);
  void finish();

 private:
  void append(std::span<const std::byte> bytes);
  void align();

  OutputFile* file_;
  MapCounts counts_;
  RunningChecksum sum_;
};

// A map that was read and found whole: every number in it is in range.
class MapFile {
 public:
  // Throws Error(kIo) where it cannot be read, Error(kBadInput) where it is no map, one of another
  // version or byte order, or damaged.
  static MapFile open(const std::string& path);

  const std::string& path() const { return file_.path(); }
  std::span<const std::byte> bytes() const { return file_.bytes(); }  // of the whole file
  const MapCounts& counts() const { return counts_; }
  // The result's mesh, without arrays. Refers to this object.
  MeshView mesh() const;
  // The four corners of a tetrahedron.
  std::span<const std::int64_t, 4> corners(std::uint64_t tet) const {
    return std::span<const std::int64_t, 4>(corners_.data() + 4 * tet, 4);
  }
  std::span<const MapPlace> places() const { return places_; }
  std::span<const MapShare> shares() const { return shares_; }
  // Takes places or shares that were read out of this process's memory; they can be read again.
  template <class T>
  void forget(std::span<const T> read) const {
    const auto* begin = reinterpret_cast<const std::byte*>(read.data());
    file_.dont_need(static_cast<std::uint64_t>(begin - file_.bytes().data()), read.size_bytes());
  }
  // Throws Error(kIo) where the file was shortened since it was opened. To be called after reading.
  void check() const { file_.check(); }

 private:
  explicit MapFile(MappedFile file);
  void read_header();
  void find_sections();
  void check_sum() const;
  void check_numbers() const;
  [[noreturn]] void fail(const std::string& what) const;

  MappedFile file_;
  MapCounts counts_;
  std::uint64_t sum_ = 0;
  std::span<const std::byte> points_;
  std::span<const std::int64_t> corners_, ends_;
  std::span<const std::uint8_t> types_;
  std::span<const MapPlace> places_;
  std::span<const MapShare> shares_;
};

}  // namespace tetfusion
