// ParaView's .pvd: a list of files, each one step of a series, with its time.
#pragma once

#include <string>
#include <vector>

namespace tetfusion {

struct PvdStep {
  double time = 0;
  std::string path;
};

// Does the name end in .pvd, in letters of either case?
bool is_pvd_name(const std::string& path);

// In the order of times, as paths from where the process is. Throws Error(kIo) where it cannot be
// read, Error(kBadInput) where it is no such list, is empty, has several files for a time, or names
// one that is not below its folder.
std::vector<PvdStep> read_pvd(const std::string& path);

// Names the files relative to its folder. It appears when it is whole. Throws Error(kIo).
void write_pvd(const std::string& path, const std::vector<PvdStep>& steps);

}  // namespace tetfusion
