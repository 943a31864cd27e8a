// The ends of file names, which say formats.
#pragma once

#include <string>

namespace tetfusion {

// ".vtu" of "a/b.VTU": in lower case; empty where there is none.
std::string suffix_of(const std::string& path);

// "a/b.ele" for "a/b.node" and ".ele", "a/b.ELE" for "a/b.NODE".
std::string with_suffix(const std::string& path, const std::string& suffix);

}  // namespace tetfusion
