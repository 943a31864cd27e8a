#include "base/name_list.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetfusion {

std::string list_names(const std::vector<std::string>& names, std::size_t most) {
  const std::size_t named = std::min(names.size(), most);
  const auto end = names.begin() + static_cast<std::ptrdiff_t>(named);
  return fmt::format("{}{}", fmt::join(names.begin(), end, ", "),
                     named < names.size() ? fmt::format(" and {} more", names.size() - named) : "");
}

}  // namespace tetfusion
