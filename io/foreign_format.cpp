#include "io/foreign_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "base/error.h"
#include "io/files/mapped_file.h"
#include "io/formats/suffix.h"
#include "io/formats/text_tokens.h"

namespace tetfusion {
namespace {

std::string_view text_of(std::span<const std::byte> head) {
  constexpr std::size_t kEnough = 4096;
  return {reinterpret_cast<const char*>(head.data()), std::min(head.size(), kEnough)};
}

// The next line that has something and is no comment, without blanks round it; empty at the end.
std::string_view next_line(std::string_view* text) {
  while (!text->empty()) {
    std::string_view line = text->substr(0, text->find('\n'));
    text->remove_prefix(std::min(line.size() + 1, text->size()));
    while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
    while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
    if (!line.empty() && line.front() != '#') return line;
  }
  return {};
}

// The value of `name="..."` in the first tag that begins with `tag`; empty if there is none.
std::string_view attribute_of(std::string_view text, std::string_view tag, std::string_view name) {
  const std::size_t begin = text.find(tag);
  if (begin == std::string_view::npos) return {};
  text = text.substr(begin, text.find('>', begin) - begin);
  std::size_t at = text.find(name);
  if (at == std::string_view::npos) return {};
  at = text.find_first_of("\"'", at);
  if (at == std::string_view::npos) return {};
  const std::size_t end = text.find(text[at], at + 1);
  return end == std::string_view::npos ? std::string_view{} : text.substr(at + 1, end - at - 1);
}

FormatGuess guess_xml(std::string_view text) {
  const std::string_view type = attribute_of(text, "<VTKFile", "type");
  if (type == "PUnstructuredGrid") {
    return {ForeignFormat::kXmlVtk, "a VTK XML unstructured grid in several files"};
  }
  // Lists by other programs may leave the type out.
  const bool is_list =
      type == "Collection" || (type.empty() && text.find("<Collection") != std::string_view::npos);
  return {ForeignFormat::kXmlVtk,
          "a VTK XML file" + (type.empty() ? "" : " of type " + std::string(type)), is_list};
}

bool is_ensight_case(std::string_view text) {
  if (!next_line(&text).starts_with("FORMAT")) return false;
  const std::string_view type = next_line(&text);
  return type.starts_with("type:") && type.find("ensight") != std::string_view::npos;
}

// What comes before its first element may be long.
bool is_xdmf(const std::string& path, std::string_view text) {
  if (text.find("<Xdmf") != std::string_view::npos) return true;
  const std::string suffix = suffix_of(path);
  return text.starts_with('<') && (suffix == ".xdmf" || suffix == ".xmf");
}

// All that is given must hold.
struct UnreadFormat {
  std::string_view begin, inside, suffix;
  std::string_view what;
};

constexpr UnreadFormat kUnreadFormats[] = {
    {"\x1f\x8b", "", "", "is packed by gzip: unpack it first"},
    {"BZh", "", "", "is packed by bzip2: unpack it first"},
    {"\xfd\x37zXZ", "", "", "is packed by xz: unpack it first"},
    {"\x28\xb5\x2f\xfd", "", "", "is packed by zstd: unpack it first"},
    {"PK\x03\x04", "", "", "is packed by zip: unpack it first"},
    {"TFPROGRS", "", "", "is a progressive mesh: 'tetfusion refine' makes meshes of it"},
    {"TFPTSMAP", "", "", "says where points went, and holds no mesh: it is for 'tetfusion apply'"},
    {"", "master_server", ".case",
     "is an EnSight server-of-servers file, which is not read: give the .case files that it names"},
    {"", "master_server", ".sos",
     "is an EnSight server-of-servers file, which is not read: give the .case files that it names"},
    // VTK 9.1's reader crashes.
    {"", "type=\"vtkHierarchicalBoxDataSet\"", "",
     "is a mesh with refined blocks (AMR), which is not read: let ParaView save it as an "
     "unstructured grid, as .vtu"},
    // VTK 9.1 reads some of them, and hangs or crashes with those that list faces of a boundary.
    {"", "** GAMBIT NEUTRAL FILE", "",
     "is a GAMBIT neutral file, which is not read: let the program that made it export another "
     "format, as Exodus, CGNS or .msh of Gmsh"},
    {"*", "", ".inp", "is an Abaqus file, which is not read: meshio converts it to .vtu"},
};

constexpr UnreadFormat kUnreadNames[] = {
    // VTK reads those of AVS, and of what is cut off whatever lies in memory.
    {"", "", ".inp",
     "is an AVS UCD or Abaqus file, which is not read: ParaView or meshio convert it to .vtu"},
    {"", "", ".avs",
     "is an AVS UCD file, which is not read: ParaView or meshio convert it to .vtu"},
    {"", "", ".bdf", "is a NASTRAN file, which is not read: meshio converts it to .vtu"},
    {"", "", ".nas", "is a NASTRAN file, which is not read: meshio converts it to .vtu"},
    {"", "", ".su2", "is an SU2 file, which is not read: meshio converts it to .vtu"},
    {"", "", ".cas", "is a Fluent case, which is not read: ParaView converts it to .vtu"},
};

void refuse(const std::string& path, std::string_view text, std::span<const UnreadFormat> formats) {
  for (const UnreadFormat& format : formats) {
    if (!text.starts_with(format.begin) || text.find(format.inside) == std::string_view::npos ||
        (!format.suffix.empty() && suffix_of(path) != format.suffix)) {
      continue;
    }
    throw Error(ErrorCode::kBadInput,
                fmt::format("{} {}", path == "-" ? "standard input" : path, format.what));
  }
}

}  // namespace

bool is_openfoam_name(const std::string& path) {
  const std::string suffix = suffix_of(path);
  return suffix == ".foam" || suffix == ".openfoam" ||
         std::filesystem::path(path).filename() == "controlDict";
}

FormatGuess guess_format(const std::string& path, std::span<const std::byte> head) {
  const std::string_view text = text_of(head);
  if (text.starts_with("# vtk DataFile")) return {ForeignFormat::kLegacyVtk, "a legacy VTK file"};
  if (text.find("<VTKFile") != std::string_view::npos) return guess_xml(text);
  if (text.starts_with('{') && text.find("\"file-series-version\"") != std::string_view::npos) {
    return {ForeignFormat::kUnknown, "", true};
  }
  if (text.starts_with("CDF\001") || text.starts_with("CDF\002") || text.starts_with("CDF\005")) {
    return {ForeignFormat::kNetCdf, "a NetCDF file, as Exodus uses it"};
  }
  if (text.starts_with("\x89HDF\r\n")) {
    return {ForeignFormat::kHdf5, "an HDF5 file, as VTKHDF, CGNS and Exodus use it"};
  }
  // Before that "@(#)", whose highest bits may be set.
  if (text.substr(std::min<std::size_t>(4, text.size())).starts_with("ADF Database")) {
    return {ForeignFormat::kAdf, "a CGNS file (ADF)"};
  }
  if (is_xdmf(path, text)) return {ForeignFormat::kXdmf, "an XDMF file"};
  if (is_ensight_case(text)) return {ForeignFormat::kEnSight, "an EnSight case"};
  if (is_openfoam_name(path)) return {ForeignFormat::kOpenFoam, "an OpenFOAM case"};
  return {};
}

FormatGuess guess_format_of(const std::string& path) {
  std::error_code not_there;
  if (is_openfoam_name(path) && std::filesystem::file_size(path, not_there) == 0) {
    return guess_format(path, {});
  }
  const MappedFile file = MappedFile::open(path);
  return guess_format(path, file.bytes());
}

bool may_have_time_steps(ForeignFormat format) {
  switch (format) {
    case ForeignFormat::kNetCdf:
    case ForeignFormat::kHdf5:
    case ForeignFormat::kAdf:
    case ForeignFormat::kXdmf:
    case ForeignFormat::kEnSight:
    case ForeignFormat::kOpenFoam:
      return true;
    default:
      return false;
  }
}

void refuse_unread_formats(const std::string& path, std::span<const std::byte> head,
                           bool by_name_too) {
  const std::string_view text = text_of(head);
  refuse(path, text, kUnreadFormats);
  if (by_name_too) refuse(path, text, kUnreadNames);
}

}  // namespace tetfusion
