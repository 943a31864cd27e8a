// The part of a VTK XML file that an XML parser needs to see: tags, without the data between them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "io/files/mapped_file.h"

namespace tetfusion {

struct XmlHead {
  // A complete XML document: the file without comments, declarations and text. The text of each
  // DataArray and Array element is replaced by its place in the file, "BEGIN END"; that of a label
  // of units in it stays. An AppendedData element is empty and the last one.
  std::string text;

  // The bytes between the underscore of an AppendedData element and its end tag (the end of the
  // file, when there is no end tag). has_appended is false when there is no such element.
  bool has_appended = false;
  std::uint64_t appended_begin = 0;
  std::uint64_t appended_end = 0;
};

// Walks over the tags of `file`, skipping from '<' to '<', up to appended data, which is not XML
// and is not looked at. Checks no more than it needs: whether the result is well formed is the
// parser's business. Does not leave the file's pages in memory. Throws
// Error(kBadInput).
XmlHead scan_xml_head(const MappedFile& file);

// The type attribute of the root element when that is <VTKFile>, else nothing: "UnstructuredGrid".
// Looks at the first few kilobytes alone.
std::string_view vtk_file_type(std::string_view file);

}  // namespace tetfusion
