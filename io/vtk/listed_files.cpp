#include "io/vtk/listed_files.h"

#include <fmt/format.h>

#include <filesystem>

#include "base/error.h"
#include "io/formats/format_file.h"

namespace tetfusion {

pugi::xml_document parse_list(const MappedFile& file) {
  pugi::xml_document document;
  const auto result = document.load_buffer(file.bytes().data(), file.size());
  file.check();
  if (result) return document;
  throw Error(ErrorCode::kBadInput, fmt::format("{}: the XML is damaged or cut off: {}",
                                                file.path(), result.description()));
}

std::string listed_path(const std::string& list, std::string_view what, const std::string& name) {
  const std::filesystem::path below = std::filesystem::path(name).lexically_normal();
  const auto fail = [&](const std::string& why) {
    throw Error(ErrorCode::kBadInput, fmt::format("{}: {} {}", list, what, why));
  };
  if (name.empty()) fail("names no file");
  if (below.is_absolute()) {
    fail("is " + tetfusion::quoted(name) +
         ", an absolute path: the file must lie below the folder of this one, and be named from "
         "there on");
  }
  if (*below.begin() == "..") {
    fail("is " + tetfusion::quoted(name) +
         ", which is not below the folder of this file: put it there, and name it so");
  }
  return (std::filesystem::path(list).parent_path() / below).lexically_normal().string();
}

}  // namespace tetfusion
