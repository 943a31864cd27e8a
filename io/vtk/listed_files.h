// .pvtu and .pvd files: XML that names other files. These lie below the folder of the file that
// names them, so that one from a stranger cannot make the program read any file there is.
#pragma once

#include <pugixml.hpp>
#include <string>
#include <string_view>

#include "io/files/mapped_file.h"

namespace tetfusion {

// Throws Error(kBadInput) where it is damaged.
pugi::xml_document parse_list(const MappedFile& file);

// The path of a file that the list at `list` calls `name`. Throws Error(kBadInput), which calls it
// `what`, if there is no name, or it leads elsewhere.
std::string listed_path(const std::string& list, std::string_view what, const std::string& name);

}  // namespace tetfusion
