#include "io/foreign_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "base/error.h"
#include "io/mapped_file.h"
#include "io/suffix.h"

namespace tetfusion {
namespace {

std::string_view text_of(std::span<const std::byte> head) {
  constexpr std::size_t kEnough = 4096;
  return {reinterpret_cast<const char*>(head.data()), std::min(head.size(), kEnough)};
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
  return {ForeignFormat::kXmlVtk,
          "a VTK XML file" + (type.empty() ? "" : " of type " + std::string(type)),
          type == "Collection"};
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
    {"", "<Xdmf", "", "is an XDMF file, which is not read: ParaView or meshio convert it to .vtu"},
    {"*", "", ".inp", "is an Abaqus file, which is not read: meshio converts it to .vtu"},
};

constexpr UnreadFormat kUnreadNames[] = {
    {"", "", ".xdmf", "is an XDMF file, which is not read: ParaView or meshio convert it to .vtu"},
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

FormatGuess guess_format(std::span<const std::byte> head) {
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
    return {ForeignFormat::kHdf5, "an HDF5 file, as NetCDF-4 and Exodus use it"};
  }
  return {};
}

FormatGuess guess_format_of(const std::string& path) {
  const MappedFile file = MappedFile::open(path);
  return guess_format(file.bytes());
}

bool may_have_time_steps(ForeignFormat format) {
  return format == ForeignFormat::kNetCdf || format == ForeignFormat::kHdf5;
}

void refuse_unread_formats(const std::string& path, std::span<const std::byte> head,
                           bool by_name_too) {
  const std::string_view text = text_of(head);
  refuse(path, text, kUnreadFormats);
  if (by_name_too) refuse(path, text, kUnreadNames);
}

}  // namespace tetfusion
