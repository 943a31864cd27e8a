#include "vtk/hyperslab.h"

namespace tetfusion {

std::optional<std::uint64_t> value_count(const Dimensions& dimensions) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 56;  // bytes of them can be counted, too
  std::uint64_t count = 1;
  for (const std::uint64_t length : dimensions) {
    if (length == 0) return 0;
  }
  for (const std::uint64_t length : dimensions) {
    if (count > kMost / length) return {};
    count *= length;
  }
  return count;
}

std::string extent_words(const Dimensions& dimensions) {
  std::string words;
  for (const std::uint64_t length : dimensions) {
    words += (words.empty() ? "" : " x ") + std::to_string(length);
  }
  return words.empty() ? "one value" : words;
}

bool Hyperslab::lies_in(const Dimensions& dimensions) const {
  for (std::size_t d = 0; d < dimensions.size(); ++d) {
    if (count[d] == 0) continue;
    if (stride[d] == 0 || start[d] >= dimensions[d]) return false;
    if (count[d] - 1 > (dimensions[d] - 1 - start[d]) / stride[d]) return false;
  }
  return true;
}

}  // namespace tetfusion
