// Unstructured grids in several files (.pvtu), read without VTK where all pieces are .vtu files.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "io/files/mapped_file.h"
#include "io/source/mesh_source.h"

namespace tetfusion {

// Each takes a descriptor and a mapping.
inline constexpr std::size_t kMaxPiecesRead = 512;

// Opens the pieces that the file names, beside it, and describes them as one mesh. Its points are
// merged and its ghosts dropped as those of a .vtu with several pieces are (vtu_reader.h). Field
// data are those of the first piece.
//
// Nothing where reading it takes more than that, and is VTK's business: pieces of another format,
// of different arrays, more of them than files should be open at once, cells to be split or
// linearized, or compressed blocks that are too large for windows. `why` then gets which of these:
// "a .pvtu " and so on. Throws Error for a file that is damaged, or a piece that is missing or not
// below the file's folder.
std::unique_ptr<MeshSource> open_pvtu(const MappedFile& file, const OpenOptions& options,
                                      std::string* why);

// The pieces that such a file names, in their order. Throws Error(kBadInput) for a file that is
// damaged, or a piece that is missing or not below its folder.
std::vector<std::string> pieces_of_pvtu(const MappedFile& file);

}  // namespace tetfusion
