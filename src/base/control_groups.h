// The control groups of this process (versions 1 and 2), as the kernel's files tell of them.
#pragma once

#include <functional>
#include <string>

namespace tetfusion {

// Calls look(folder, version2) for the folder of the process's group in each hierarchy that is
// mounted and has the controller ("memory", "cpu"), and for those of all groups above it. `root` is
// where /proc and /sys lie, for tests.
void for_each_own_group(const std::string& root, const std::string& controller,
                        const std::function<void(const std::string& folder, bool version2)>& look);

}  // namespace tetfusion
