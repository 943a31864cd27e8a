// What meshes are written as, and where to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/run_context.h"
#include "io/mesh_source.h"
#include "mesh/data_array.h"

namespace tetfusion {

enum class Encoding { kRaw, kZlib, kLz4, kInline, kAscii };

struct WriteOptions {
  Encoding encoding = Encoding::kRaw;
  std::function<void(double share)> progress;  // 0..1; may be empty
  // A cell array of whole numbers, of any type, that says what cells are: where a format has
  // references or groups and the mesh none of another format, they are this one's. It need not be
  // there.
  std::string label = {};
  bool label_comes_first = false;  // before those that the mesh has of any format
  // Told, as sentences, of cells that the format has no place for, and of arrays whose values do
  // not let them be what the format has for them; may be empty.
  std::function<void(std::string_view)> tell = {};

  // Sets progress and tell(): writing is what is left of a run when that share is done. The context
  // outlives what is written.
  void report_to(const RunContext& context, double done = 0);
};

// By the end of the name. "-" and devices take .vtu.
enum class MeshFormat { kVtu, kLegacyVtk, kMedit, kMeditBinary, kGmsh, kTetgen };

// Throws Error(kUsage) for a name that is none of a format that can be written.
MeshFormat output_format(const std::string& path);

// Throws what writing a mesh of that name would throw, before any work: Error(kUsage) for a format
// that cannot be written, or that has no such encoding, Error(kIo) where no file can be made.
// Creates nothing. "-" is standard output.
void check_mesh_output(const std::string& path, Encoding encoding = Encoding::kRaw);

// Writes the mesh to a file that is no .vtu: tetrahedra first, then the cells of lower dimension,
// in the memory of a few windows and these cells, where the source can be read in windows. Returns
// how many tetrahedra there are.
std::uint64_t write_mesh(MeshSource* source, const std::string& path, const WriteOptions& options);

// All files that a mesh of that name consists of, as far as the name tells: of TetGen several.
std::vector<std::string> files_of_mesh(const std::string& path);

// Throws Error(kUsage) when the file of an option would overwrite one of the others, or what
// belongs to them (files_of_mesh). Names that are empty or "-" are no files.
void refuse_same_file(std::string_view option, const std::string& path,
                      const std::vector<std::string>& others);

// Throws Error(kUsage) where a file that is to be written is one of those that the mesh consists of
// beside its own (MeshDescription::files). An empty name is none.
void refuse_piece(const std::string& path, const MeshDescription& mesh);
// The same for a mesh that is to be written, but where it has several files, too: these replace the
// others' together.
void refuse_piece_as_mesh(const std::string& path, const MeshDescription& mesh);

// A sentence about what of that mesh was not read; empty where all was.
std::string unread_of(const MeshDescription& mesh);

// The same, and what a file of that name cannot hold, as far as no value matters; the last two are
// those of WriteOptions.
std::string left_out_of(const std::string& path, const MeshDescription& mesh,
                        const std::string& label = {}, bool label_comes_first = false);

// A mesh that goes to memory. Cells are VTK's, as MeshView has them: tetrahedra first.
struct MeshLayout {
  std::uint64_t points = 0;
  std::uint64_t tets = 0;
  std::uint64_t cells = 0;    // those of lower dimension, too
  std::uint64_t corners = 0;  // of all cells
  ValueType point_type = ValueType::kFloat32;
  AttributeSet point_data, cell_data;  // tuples are ignored
};

// What numbers of points and offsets are to be, kInt32 or kInt64, where those of the input were
// `wanted`: kInt64 where that has no room for the number of corners, as when cells were split.
ValueType id_type_for(const MeshLayout& layout, ValueType wanted);

// Memory for a mesh of that layout, which somebody else owns.
struct MeshRoom {
  std::byte* points = nullptr;            // three coordinates each
  ValueType id_type = ValueType::kInt64;  // of the next two: kInt32, if they fit, or kInt64
  std::byte* connectivity = nullptr;
  std::byte* offsets = nullptr;   // one more than cells; may be null where all are tetrahedra
  std::uint8_t* types = nullptr;  // may be null where offsets are
  std::vector<std::byte*> point_arrays, cell_arrays;
};

class MeshSink {
 public:
  virtual ~MeshSink() = default;
  // Called once, before anything is put there.
  virtual MeshRoom make_room(const MeshLayout& layout) = 0;
};

}  // namespace tetfusion
