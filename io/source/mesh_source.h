// Where a mesh comes from: a file of any format, opened and described but not yet read.
//
// The order of use: open_mesh() reads and checks the head; description() says what is there;
// read_geometry() and read_array() bring the parts, each when it is wanted, so that no more than
// one carried array needs to be in memory at a time.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "mesh/data_array.h"
#include "mesh/geometry.h"

namespace tetfusion {

struct MeshDescription {
  std::string path;    // as the user gave it; "-" for standard input
  std::string format;  // "VTK XML unstructured grid, appended raw, zlib, UInt64 headers"
  std::uint64_t pieces = 1;
  bool joins_points = false;  // of several pieces, or as OpenOptions::merge_points says
  std::uint64_t points = 0;   // all pieces, before merging
  std::uint64_t cells = 0;    // all pieces, ghosts too
  ValueType point_type = ValueType::kFloat32;
  std::uint64_t file_bytes = 0;
  std::vector<std::string> files;  // that the file at `path` names, where it is several
  // Of an input that can be read only once, and was therefore copied: checksum() of its bytes.
  std::optional<std::uint64_t> spooled_checksum;
  std::vector<double> time_steps;  // that the file itself has; empty: its format has none
  std::size_t time_step = 0;       // the one of these that is read
  AttributeSet point_data;
  AttributeSet cell_data;
  AttributeSet field_data;
  // Arrays of points and cells that have strings or bits: nothing is done with them.
  std::vector<std::string> unread;
  // What else is not read of the file, in its format's words: sections, or arrays that VTK read.
  std::vector<std::string> left_out;
};

inline constexpr std::uint64_t kLastTimeStep = std::numeric_limits<std::uint64_t>::max();

struct OpenOptions {
  // Split hexahedra, voxels, wedges and pyramids, and the quadrilaterals on them, by smallest
  // vertex id; with VTK polyhedra, too, each from a new point behind those of its piece.
  bool tetrahedralize = false;
  // Keep no more than the corners of cells of higher order, as ten-node tetrahedra, and of the
  // faces and edges beside them.
  bool linearize = false;
  // On the disk of this folder (MappedFile::spool) lies the copy of an input that can be read only
  // once. Empty: in $TMPDIR or /tmp.
  std::string spool_folder = {};
  // Of a file that has several itself, counted from 0, or kLastTimeStep. Absent: the first, and
  // MeshDescription::left_out names the others.
  std::optional<std::uint64_t> time_step = {};
  // The file was read before, and this step of it: that it does no harm is known.
  bool was_read = false;
  // Bytes that the caller may take. Of a file that VTK reads, and that may be damaged, the first
  // try ends when it takes twice as much, but 256 MiB are always free to it. 0: as much as the
  // machine has to spare. Other files' readers do not look at it.
  std::uint64_t memory = 0;
  // RunContext::cancelled: becomes true when the caller wants that try, or the copy of what can be
  // read only once, to end.
  const std::atomic<bool>* cancelled = nullptr;
  // Points with the same coordinates are one, with the values of the first, before cells are split.
  // Throws Error(kUsage) for Medit's, Gmsh's and TetGen's files.
  bool merge_points = false;
  // Cells of lower dimension are left out, also ones that could not be read, and points that only
  // these use are used by no cell.
  bool drop_patches = false;
  // Of these cells, some: by patches, as without_patches() takes them (chosen_patches.h).
  std::vector<std::string> dropped_patches = {};
};

class MeshStream;

class MeshSource {
 public:
  virtual ~MeshSource() = default;
  virtual const MeshDescription& description() const = 0;

  // Throws Error(kBadInput) for a cell that is neither a tetrahedron nor of lower dimension and for
  // no tetrahedra at all, InvalidMesh for an index out of range and a coordinate that is not finite
  // of a point that is used; Error(kIo) when reading fails.
  virtual Geometry read_geometry() = 0;

  // All tuples of the array at `index` of that association's AttributeSet, pieces one after
  // another, in the order of the file. Geometry's *_source arrays index its rows.
  virtual DataArray read_array(Association association, std::size_t index) = 0;
  std::vector<DataArray> read_field_data();  // all of it

  // Windows of the file, or nullptr where the whole mesh must be read. open_stream()
  // (mesh_stream.h) gives a stream in any case.
  virtual std::unique_ptr<MeshStream> stream();
  // The same for arrays and points alone: cells of it are not read, and need not be looked at.
  virtual std::unique_ptr<MeshStream> stream_of_rows();

  // A checksum of the bytes in the file that say what its points and cells are, not decoded, for a
  // source that is one piece of one file: sources with the same one, opened with the same options,
  // have the same mesh, which is in order if one of them is. Different ones say nothing. Throws
  // Error, and what context.check() throws.
  virtual std::optional<std::uint64_t> mesh_checksum(const RunContext& context);

  // About how many bytes of memory reading the whole mesh takes at its worst moment, when all point
  // and cell arrays are kept and what the source itself holds is counted. Looks at no more than the
  // types of the cells.
  virtual std::uint64_t memory_to_read();
};

}  // namespace tetfusion
