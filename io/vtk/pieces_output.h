// A mesh in several files: NAME.pvtu, and beside it a folder of its own with the pieces, each a
// .vtu, that it names.
//
// The folder is a new one: NAME_pieces, or NAME_pieces-2 and so on where that is taken. So a file
// of that name that is there, and its pieces, stay until commit() puts the new one in its place in
// one step; then the old pieces are removed. Without commit() the new folder is removed.
//
// Until the file names it the folder holds a marker, which is locked by the process that writes
// there; then the old folder has one. So what a process left that was killed can be told from
// pieces in use, and from folders of others: the next run that writes that name removes it. (But
// for a folder in which there was nothing yet.)
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "io/files/file_system.h"
#include "io/vtk/vtu_writer.h"

namespace tetfusion {

// Does the name end in .pvtu, in letters of either case?
bool is_pieces_name(const std::string& path);

// For such a name. Throws what PiecesOutput would throw, before any work. Creates nothing.
void check_pieces_output(const std::string& path);

// Removes the folders that processes have left which were killed while they wrote pieces of the
// file: the pieces in them, and nothing else. Does not fail. For the start of a run.
void remove_dead_pieces(const std::string& path) noexcept;

// Not thread-safe. Throws Error(kIo), or Error(kUsage) where NAME.pvtu is a link: pieces are looked
// for beside the name that a reader was given.
class PiecesOutput {
 public:
  explicit PiecesOutput(const std::string& path);
  ~PiecesOutput();
  PiecesOutput(const PiecesOutput&) = delete;
  PiecesOutput& operator=(const PiecesOutput&) = delete;

  // The file to write a piece to; they count from 0.
  std::string piece_path(std::uint32_t piece) const;

  // All pieces are written: the path of a file that names them, so that they can be read before
  // commit(). It goes with commit(), or with this object.
  std::string path_to_read(const VtuLayout& layout, std::uint32_t pieces) const;

  // All pieces are written. `layout` has the arrays of each; its counts do not matter. Call once.
  // `before_name` as of OutputFile::commit().
  void commit(const VtuLayout& layout, std::uint32_t pieces,
              const std::function<void()>& before_name = {});

 private:
  std::string text(const VtuLayout& layout, std::uint32_t pieces, const std::string& folder) const;

  std::string path_;
  std::string old_folder_;  // of the file that is there; empty: none
  std::string folder_;      // empty when it must not be removed
  Descriptor marker_;       // locked until the file names the folder
};

}  // namespace tetfusion
