// Files of EnSight Gold that are text: VTK takes zeros for the lines that they lack.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>

namespace tetfusion {

// What is wrong with them, in words; empty: nothing, or nothing that is known: where they hold what
// is not walked through here (structured parts, values of some points alone), or make no sense,
// which VTK says. `text` is trusted to be valid as long as the function runs.
class EnSightGold {
 public:
  std::string fault_of_geometry(std::string_view text);
  // After the geometry: so many numbers for each node or element.
  std::string fault_of_variable(std::string_view text, std::uint64_t components) const;

 private:
  struct Part {
    std::uint64_t nodes = 0;
    std::map<std::string, std::uint64_t, std::less<>> elements;  // by their type
  };
  std::map<std::uint64_t, Part> parts_;
  bool is_known_ = false;
};

}  // namespace tetfusion
