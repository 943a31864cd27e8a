// What meshes are written as, and under which names.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "io/source/mesh_source.h"
#include "io/vtk/encoding.h"

namespace tetfusion {

// By the end of the name. "-" and devices take .vtu.
enum class MeshFormat { kVtu, kLegacyVtk, kMedit, kMeditBinary, kGmsh, kTetgen };

// Throws Error(kUsage) for a name that is none of a format that can be written.
MeshFormat output_format(const std::string& path);

// Throws what writing a mesh of that name would throw, before any work: Error(kUsage) for a format
// that cannot be written, or that has no such encoding, or a name that holds "{step}" or "{lod}",
// Error(kIo) where no file can be made. Creates nothing. "-" is standard output.
void check_mesh_output(const std::string& path, Encoding encoding = Encoding::kRaw);

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

}  // namespace tetfusion
