// A progressive file (FORMAT.md): a simplified mesh, and the fusions that led to it, in the order
// in which they are to be undone, so that any level between it and the original can be had.
//
// Points and cells go by their numbers in the original; a row holds one point's position and
// values, or one cell's values.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/vector.h"
#include "io/files/mapped_file.h"
#include "io/files/output_file.h"
#include "io/progressive/packed_columns.h"
#include "mesh/data_array.h"
#include "mesh/fusion_log.h"
#include "mesh/geometry.h"

namespace tetfusion {

// What is in the file, in all.
struct ProgressiveCounts {
  std::uint64_t points = 0;       // of the original; each is in the file once
  std::uint64_t cells = 0;        // those of lower dimension, too
  std::uint64_t tets = 0;         // of the original
  std::uint64_t base_points = 0;  // of the simplified mesh
  std::uint64_t base_tets = 0;
  std::uint64_t fusions = 0;
};

struct ProgressiveDescription {
  ValueType point_type = ValueType::kFloat32;  // or kFloat64
  AttributeSet point_data, cell_data;          // tuples do not count
  std::vector<DataArray> field_data;
  FusionErrors errors = FusionErrors::kNone;

  std::size_t point_row_bytes() const;
  std::size_t cell_row_bytes() const;
};

struct PointRows {
  Vector<VertexId> numbers;  // ascending
  Vector<std::byte> rows;
};

struct TetRows {
  Vector<TetId> numbers;  // ascending
  Vector<Tet> corners;    // numbers of points
  Vector<std::byte> rows;
};

struct LowerRows {
  Vector<TetId> numbers;  // ascending
  LowerCells cells;
  Vector<std::byte> rows;
};

// Writes front to back; the same bytes for any number of threads. The caller commits the file,
// which must allow Access::kPatch.
class ProgressiveWriter {
 public:
  ProgressiveWriter(OutputFile* file, const ProgressiveDescription& description);

  // Of the simplified mesh. In this order; points, tetrahedra, spare points and rewound ones in as
  // many calls as one likes, ascending: the bytes are the same.
  void put_points(const PointRows& points);
  void put_tets(const TetRows& tets);
  void put_lower(const LowerRows& lower);
  // The points of the original that no cell uses.
  void put_spare(const PointRows& points);
  // Tetrahedra of the original whose last two corners are the other way round.
  void put_rewound(std::span<const TetId> numbers);
  // In the order in which they are undone, the last one first; of which round of the run, and chunk
  // of the round, it is.
  void put(const FusionRecord& record, std::uint32_t round, std::uint32_t chunk);
  void finish();

 private:
  void put_rows(const PointRows& points, std::uint32_t kind);
  void end_points();
  void end_tets();
  void end_rewound();
  void end_block();
  void add(ColumnPacker columns, std::uint32_t kind, std::uint64_t rows);
  void write_waiting();

  OutputFile* file_;
  std::uint32_t version_;
  std::size_t point_row_ = 0, cell_row_ = 0;
  ProgressiveCounts counts_;
  std::vector<std::array<std::uint64_t, 6>> table_;
  struct Waiting {
    ColumnPacker columns;
    std::uint32_t kind = 0;
    std::uint64_t rows = 0;
  };
  std::vector<Waiting> waiting_;
  // Of a section that is not full.
  PointRows points_;
  std::uint32_t points_kind_ = 0;
  TetRows tets_;
  Vector<TetId> rewound_;
  FusionLog block_;
  Vector<std::uint32_t> chunks_;  // of its records
  std::uint32_t round_ = 0;
  // Of each block: the largest error, and the round.
  Vector<float> errors_;
  Vector<std::uint32_t> rounds_;
};

// Records of one block, one after another.
class FusionBlock {
 public:
  std::size_t size() const { return kept_.size(); }
  // The next record, of size() in all. Good until this object goes.
  FusionRecord next();
  std::span<const float> errors() const { return errors_; }
  // A round's chunks do not know each other: their records may be taken in any order but their own.
  std::span<const std::uint32_t> chunks() const { return chunks_; }
  // Of the records from the next one on; tetrahedra that come back with them.
  std::span<const VertexId> kept_ahead() const { return std::span(kept_).subspan(at_.record); }
  std::span<const TetId> tets_ahead() const { return std::span(tets_).subspan(at_.tet); }

 private:
  friend class ProgressiveFile;
  // Are there so many fusions, and as many rows as they say?
  bool agrees(std::uint64_t fusions, std::size_t packed_bytes) const;
  // These two where they agree. False where a tetrahedron was no one's that is gone.
  bool unpack_star(std::span<const std::uint8_t> packed);
  // The file has numbers of points less the kept one's, of tetrahedra less the one before.
  void undo_differences();

  Vector<VertexId> kept_, points_, elsewhere_;
  Vector<std::array<std::uint32_t, 4>> heads_;  // gone and flags, points, star, tetrahedra
  Vector<float> errors_;
  Vector<std::uint32_t> chunks_;
  Vector<std::byte> rows_, tet_rows_;
  Vector<std::uint8_t> star_;
  Vector<TetId> tets_;
  Vector<std::array<CornerCode, 4>> corners_;
  std::size_t point_row_ = 0, cell_row_ = 0;
  struct {
    std::size_t record = 0, point = 0, row = 0, star = 0, tet = 0, elsewhere = 0;
  } at_;
};

// Opened and found to have its length; what is read of it agrees with its checksums. That numbers
// are in range whoever takes them has to see.
class ProgressiveFile {
 public:
  // Throws Error(kIo) where it cannot be read, Error(kBadInput) where it is no such file, one of
  // another version or byte order, or damaged.
  static ProgressiveFile open(const std::string& path);

  const std::string& path() const { return file_.path(); }
  std::uint64_t bytes() const { return file_.size(); }
  const ProgressiveCounts& counts() const { return counts_; }
  const ProgressiveDescription& description() const { return description_; }

  // Each in parts, which are to be taken one after another. Throws Error(kBadInput).
  std::size_t parts_of_points() const { return parts_[1].size(); }
  std::size_t parts_of_tets() const { return parts_[2].size(); }
  std::size_t parts_of_lower() const { return parts_[3].size(); }
  std::size_t parts_of_spare() const { return parts_[4].size(); }
  std::size_t blocks() const { return parts_[5].size(); }
  std::size_t parts_of_rewound() const { return parts_[6].size(); }
  PointRows points(std::size_t part) const { return read_points(parts_[1][part]); }
  TetRows tets(std::size_t part) const;
  LowerRows lower(std::size_t part) const;
  PointRows spare(std::size_t part) const { return read_points(parts_[4][part]); }
  FusionBlock block(std::size_t part) const;
  std::uint64_t fusions_of(std::size_t block) const { return parts_[5][block].rows; }
  std::uint64_t largest_block() const;  // in bytes, inflated; 0: there is none
  Vector<TetId> rewound(std::size_t part) const;
  // Of each block the largest error, and the round that it is of; the last round comes first.
  struct BlockFacts {
    Vector<float> errors;
    Vector<std::uint32_t> rounds;
  };
  BlockFacts facts() const;

  // Takes what has been read of the file out of this process; it comes back when it is read again.
  void let_go() const { file_.dont_need(0, file_.size()); }

  [[noreturn]] void fail(const std::string& what) const;
  // Throws Error(kIo) where the file was shortened since it was opened. To be called after reading.
  void check() const { file_.check(); }

 private:
  static constexpr std::size_t kKinds = 8;
  struct Section {
    std::uint64_t offset = 0, bytes = 0, raw_bytes = 0, checksum = 0, kind = 0, rows = 0;
  };
  explicit ProgressiveFile(MappedFile file);
  void read_head();
  void read_table(std::uint64_t offset, std::uint64_t sections, std::uint64_t sum);
  void read_description();
  void check_rows() const;
  std::span<const std::byte> bytes_of(const Section& section) const;
  ColumnReader columns_of(const Section& section) const;
  PointRows read_points(const Section& section) const;

  MappedFile file_;
  std::uint32_t version_ = 0;
  ProgressiveCounts counts_;
  std::uint64_t raw_bytes_ = 0;  // of all sections, inflated
  ProgressiveDescription description_;
  std::array<std::vector<Section>, kKinds> parts_;
};

}  // namespace tetfusion
