// The file that says where each point and each cell of a mesh went when that was simplified
// (FORMAT.md): it holds the result's mesh, a place in it for each point of the original, what each
// point of the result takes of the original's values, and the same of cells.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "io/files/checksum.h"
#include "io/files/mapped_file.h"
#include "io/files/output_file.h"
#include "io/source/mesh_view.h"
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

// In which tetrahedron of the result the centre of a cell of the original lies, and the cell's
// volume as a share of that one's. kNoTet: its values count nowhere, as it is no tetrahedron, has
// no volume, has none of the result round it, or one in another region, or is there still.
struct MapHome {
  TetId tet = kNoTet;
  float share = 0;  // above 0, but for kNoTet
};

// Of which cell of the original a cell of the result has its values. With `is_mean` it has, of
// floating-point arrays that are more than whole numbers, the means of those whose home it is.
struct MapOrigin {
  std::uint64_t cell = 0;
  std::uint64_t is_mean = 0;  // or 1
};

// What the sections hold; shares only when all is written.
struct MapCounts {
  std::uint64_t original_points = 0;
  std::uint64_t original_cells = 0;  // those of lower dimension, too
  std::uint64_t points = 0;
  std::uint64_t tets = 0;
  std::uint64_t cells = 0;    // tetrahedra first, those of lower dimension, too
  std::uint64_t corners = 0;  // of all cells
  std::uint64_t shares = 0;
  ValueType point_type = ValueType::kFloat32;  // or kFloat64
};

// Tells meshes apart whose tetrahedra, window by window, are not the same.
class TetsChecksum {
 public:
  // `row` is a tetrahedron's number among the cells.
  void add(std::uint64_t row, const Tet& corners) {
    const std::array<std::uint64_t, 3> words{row, std::uint64_t{corners[0]} << 32 | corners[1],
                                             std::uint64_t{corners[2]} << 32 | corners[3]};
    sum_.add(std::as_bytes(std::span(words)));
  }
  std::uint64_t value() const { return sum_.value(); }

 private:
  RunningChecksum sum_;
};

// Writes a map front to back. The caller commits the file, which must allow Access::kPatch.
class MapWriter {
 public:
  // Writes the mesh.
  MapWriter(OutputFile* file, std::uint64_t original_points, std::uint64_t original_cells,
            const Geometry& mesh);

  // All places, in the order of the original's points; all homes, in that of its cells; origins, in
  // that of the result's; and shares, ascending by the original's point, then by the result's: one
  // list after the other, each in runs of any length.
  void put(std::span<const MapPlace> places) { append(std::as_bytes(places)); }
  void put(std::span<const MapHome> homes) { append(std::as_bytes(homes)); }
  void put(std::span<const MapOrigin> origins) { append(std::as_bytes(origins)); }
  void put(std::span<const MapShare> shares);
  void finish(std::uint64_t tets_sum);  // of the original

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
  std::uint64_t tets_sum() const { return tets_sum_; }  // of the original
  // The result's mesh, without arrays. Refers to this object.
  MeshView mesh() const;
  // The four corners of a tetrahedron.
  std::span<const std::int64_t, 4> corners(std::uint64_t tet) const {
    return std::span<const std::int64_t, 4>(corners_.data() + 4 * tet, 4);
  }
  std::span<const MapPlace> places() const { return places_; }
  std::span<const MapHome> homes() const { return homes_; }
  std::span<const MapOrigin> origins() const { return origins_; }
  std::span<const MapShare> shares() const { return shares_; }
  // Takes rows of a section that were read out of this process's memory; they can be read again.
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
  std::uint64_t sum_ = 0, tets_sum_ = 0;
  std::span<const std::byte> points_;
  std::span<const std::int64_t> corners_, ends_;
  std::span<const std::uint8_t> types_;
  std::span<const MapPlace> places_;
  std::span<const MapHome> homes_;
  std::span<const MapOrigin> origins_;
  std::span<const MapShare> shares_;
};

}  // namespace tetfusion
