// Lists of files, each one step of a series, with its time: ParaView's .pvd, and the JSON of its
// .vtu.series and the like.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace tetfusion {

struct ListedStep {
  std::optional<double> time;
  std::string path;
};

// Does the name end in .pvd, in letters of either case?
bool is_pvd_name(const std::string& path);

// In .pvd or .series?
bool is_list_name(const std::string& path);

// In the order of times, as paths from where the process is; where a list has no times, in its own
// order. Throws Error(kIo) where it cannot be read, Error(kBadInput) where it is
// no such list, is empty, has several files for a time, has times for some files alone, or names
// one that is not below its folder.
std::vector<ListedStep> read_series_list(const std::string& path);

// Names the files relative to its folder; a step without a time gets its number. It appears when it
// is whole. Throws Error(kIo).
void write_pvd(const std::string& path, const std::vector<ListedStep>& steps);

}  // namespace tetfusion
