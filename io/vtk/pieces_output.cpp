#include "io/vtk/pieces_output.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "io/files/file_system.h"
#include "io/files/mapped_file.h"
#include "io/files/output_file.h"
#include "io/formats/suffix.h"
#include "io/formats/xml_text.h"
#include "io/vtk/vtu_markup.h"

namespace tetfusion {

namespace {

constexpr int kMaxFolders = 10000;
constexpr const char* kMarker = ".unfinished";
constexpr const char* kIndex = ".tetfusion-index.part";  // is_temporary_name()

std::string stem_of(const std::string& path) { return std::filesystem::path(path).stem().string(); }

bool is_number(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

std::string folder_name(const std::string& stem, int n) {
  return n == 1 ? stem + "_pieces" : fmt::format("{}_pieces-{}", stem, n);
}

std::string piece_name(const std::string& stem, std::uint32_t piece) {
  return fmt::format("{}_{}.vtu", stem, piece);
}

bool is_piece_name(std::string_view name, const std::string& stem) {
  constexpr std::string_view kEnd = ".vtu";
  if (!name.starts_with(stem + "_") || !name.ends_with(kEnd)) return false;
  name.remove_prefix(stem.size() + 1);
  return is_number(name.substr(0, name.size() - std::min(name.size(), kEnd.size())));
}

std::string beside(const std::string& path, const std::string& name) {
  return (std::filesystem::path(path).parent_path() / name).string();
}

// Throws Error where that cannot be told.
bool exists(const std::string& path) {
  struct stat status {};
  if (file_system().fstatat(AT_FDCWD, path.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0) return true;
  if (errno == ENOENT) return false;
  throw Error(ErrorCode::kIo, fmt::format("cannot look at {}: {}", path, std::strerror(errno)));
}

// The folder that the file names, if it is one that this program made for a file of this name; else
// nothing. Throws Error where the file is there, but cannot be read.
std::string folder_named_by(const std::string& path) {
  const std::string stem = stem_of(path);
  if (!exists(path)) return {};
  const MappedFile file = MappedFile::open(path);
  const std::string_view text(reinterpret_cast<const char*>(file.bytes().data()), file.size());
  constexpr std::string_view kSource = "<Piece Source=\"";
  const std::string expected = xml_escape(folder_name(stem, 1));
  const std::size_t at = text.find(kSource);
  if (at == std::string_view::npos) return {};
  std::string_view source = text.substr(at + kSource.size());
  if (!source.starts_with(expected)) return {};
  source.remove_prefix(expected.size());
  const std::string_view number = source.substr(0, source.find('/'));
  if (!number.empty() && (number[0] != '-' || !is_number(number.substr(1)))) return {};
  return beside(path, folder_name(stem, 1) + std::string(number));
}

Descriptor open_folder(const std::string& folder) {
  return Descriptor(file_system().openat(AT_FDCWD, folder.c_str(),
                                         O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC, 0));
}

bool lock(const Descriptor& file) {
  return retry([&] { return file_system().flock(file.get(), LOCK_EX | LOCK_NB); }) == 0;
}

// Removes the pieces in the folder, and the folder if nothing else is in it. The marker goes last:
// who is killed here, too, leaves the rest to the next.
void remove_pieces(const std::string& folder, const std::string& stem) noexcept {
  try {
    FileSystem& system = file_system();
    {
      const Descriptor opened = open_folder(folder);
      if (!opened) return;
      std::vector<std::string> names;
      if (system.list(opened.get(), &names) != 0) return;
      for (const std::string& name : names) {
        if (is_piece_name(name, stem) || is_temporary_name(name))
          system.unlinkat(opened.get(), name.c_str(), 0);
      }
      system.unlinkat(opened.get(), kMarker, 0);
    }
    system.unlinkat(AT_FDCWD, folder.c_str(), AT_REMOVEDIR);
  } catch (const std::exception&) {  // no memory for names
  }
}

// Marks a new folder as one in work. False, and errno, where that fails; EEXIST where somebody has
// taken the folder for a dead one in the meantime.
bool mark(const std::string& folder, Descriptor* marker) {
  const Descriptor opened = open_folder(folder);
  if (!opened) return false;
  *marker = Descriptor(retry([&] {
    return file_system().openat(opened.get(), kMarker, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  }));
  if (!*marker) return false;
  // Where files cannot be locked nobody takes the folder for a dead one.
  const bool taken = !lock(*marker) && errno == EWOULDBLOCK;
  struct stat status {};
  const bool gone = file_system().fstat(marker->get(), &status) == 0 && status.st_nlink == 0;
  if (!taken && !gone) return true;
  marker->close();
  errno = EEXIST;
  return false;
}

// Leaves a folder that nobody will need to whoever comes next, should this process be killed.
void give_up(const std::string& folder) {
  const Descriptor opened = open_folder(folder);
  if (!opened) return;
  const Descriptor marker(
      file_system().openat(opened.get(), kMarker, O_RDWR | O_CREAT | O_CLOEXEC, 0666));
}

void remove_marker(const std::string& folder) {
  file_system().unlinkat(AT_FDCWD, (folder + "/" + kMarker).c_str(), 0);
}

// Was it left by a process that lives no more? `named` is the folder that the file names: all is
// there, even if the process was killed before it took the marker away.
bool is_dead(const std::string& folder, const std::string& named, Descriptor* marker) {
  if (folder == named) return false;
  const Descriptor opened = open_folder(folder);
  if (!opened) return false;
  *marker =
      Descriptor(file_system().openat(opened.get(), kMarker, O_RDWR | O_NOFOLLOW | O_CLOEXEC, 0));
  return *marker && lock(*marker);
}

void remove_if_dead(const std::string& folder, const std::string& path) {
  Descriptor marker;  // locked until all is gone
  if (is_dead(folder, folder_named_by(path), &marker)) remove_pieces(folder, stem_of(path));
}

std::string section(const char* element, const AttributeSet& set) {
  std::string text = fmt::format("    <{}{}>\n", element, active_attributes(set));
  for (const ArrayInfo& info : set.arrays) {
    const std::string units = units_element(info);
    text += fmt::format("      <PDataArray {}{}\n", array_attributes(info),
                        units.empty() ? "/>" : ">" + units + "</PDataArray>");
  }
  return text + fmt::format("    </{}>\n", element);
}

}  // namespace

bool is_pieces_name(const std::string& path) { return suffix_of(path) == ".pvtu"; }

void check_pieces_output(const std::string& path) {
  struct stat status {};
  if (file_system().fstatat(AT_FDCWD, path.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0 &&
      S_ISLNK(status.st_mode)) {
    throw Error(ErrorCode::kUsage,
                fmt::format("cannot write {}: it is a link, and the pieces are looked for beside "
                            "it; give the name of the file itself",
                            path));
  }
  if (!is_xml_text(stem_of(path))) {
    throw Error(
        ErrorCode::kUsage,
        fmt::format("cannot write {}: a .pvtu file holds names in UTF-8: give another one", path));
  }
  if (folder_name(stem_of(path), kMaxFolders).size() > NAME_MAX) {
    throw Error(ErrorCode::kIo,
                fmt::format("cannot write {}: its name is too long for a folder with \"_pieces\" "
                            "added to it",
                            path));
  }
  check_output_path(path);
}

void remove_dead_pieces(const std::string& path) noexcept {
  try {
    // There are as many folders in a row as runs were killed at once, and one in use.
    for (int n = 1; n <= kMaxFolders; ++n) {
      const std::string folder = beside(path, folder_name(stem_of(path), n));
      const std::string next = beside(path, folder_name(stem_of(path), n + 1));
      if (!exists(folder) && !exists(next)) return;
      remove_if_dead(folder, path);
    }
  } catch (const std::exception&) {  // no memory for names, or a file that cannot be read
  }
}

PiecesOutput::PiecesOutput(const std::string& path) : path_(path) {
  check_pieces_output(path);
  try {
    old_folder_ = folder_named_by(path);
  } catch (const Error&) {
    // Nobody knows what it named: that stays.
  }
  remove_dead_pieces(path);
  for (int n = 1; n <= kMaxFolders; ++n) {
    const std::string folder = beside(path, folder_name(stem_of(path), n));
    if (retry([&] { return file_system().mkdir(folder.c_str(), 0777); }) == 0) {
      if (mark(folder, &marker_)) {
        folder_ = folder;
        if (old_folder_ == folder) old_folder_.clear();  // it is gone already
        return;
      }
      const int error = errno;
      file_system().unlinkat(AT_FDCWD, folder.c_str(), AT_REMOVEDIR);
      errno = error;
    }
    if (errno == EEXIST) continue;
    break;
  }
  throw Error(ErrorCode::kIo, fmt::format("cannot make a folder for the pieces of {}: {}", path,
                                          std::strerror(errno)));
}

PiecesOutput::~PiecesOutput() {
  if (folder_.empty()) return;
  remove_pieces(folder_, stem_of(path_));
  if (!old_folder_.empty()) remove_marker(old_folder_);
}

std::string PiecesOutput::piece_path(std::uint32_t piece) const {
  return folder_ + "/" + piece_name(stem_of(path_), piece);
}

// `folder` is what goes before the names of the pieces.
std::string PiecesOutput::text(const VtuLayout& layout, std::uint32_t pieces,
                               const std::string& folder) const {
  AttributeSet points;
  points.arrays = {{"Points", layout.point_type, 3, {}, 0}};
  std::string text = vtk_file_tag("PUnstructuredGrid") + "  <PUnstructuredGrid GhostLevel=\"0\">\n";
  text += section("PPointData", layout.point_data) + section("PCellData", layout.cell_data) +
          section("PPoints", points);
  for (std::uint32_t i = 0; i < pieces; ++i) {
    text += fmt::format("    <Piece Source=\"{}\"/>\n",
                        xml_escape(folder + piece_name(stem_of(path_), i)));
  }
  return text + "  </PUnstructuredGrid>\n</VTKFile>\n";
}

std::string PiecesOutput::path_to_read(const VtuLayout& layout, std::uint32_t pieces) const {
  const std::string index = folder_ + "/" + kIndex;
  const std::string content = text(layout, pieces, "");
  OutputFile file(index);
  file.append(content.data(), content.size());
  file.commit();
  return index;
}

void PiecesOutput::commit(const VtuLayout& layout, std::uint32_t pieces,
                          const std::function<void()>& before_name) {
  const std::string folder = std::filesystem::path(folder_).filename().string();
  const std::string content = text(layout, pieces, folder + "/");
  file_system().unlinkat(AT_FDCWD, (folder_ + "/" + kIndex).c_str(), 0);
  OutputFile file(path_);
  file.append(content.data(), content.size());
  // As long as the file names the old folder, its marker counts for nothing.
  if (!old_folder_.empty()) give_up(old_folder_);
  file.commit(before_name);
  remove_marker(folder_);
  folder_.clear();
  marker_.close();
  if (!old_folder_.empty()) remove_pieces(old_folder_, stem_of(path_));
}

}  // namespace tetfusion
