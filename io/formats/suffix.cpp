#include "io/formats/suffix.h"

#include <algorithm>
#include <filesystem>

namespace tetfusion {

namespace {

bool is_capital(char c) { return c >= 'A' && c <= 'Z'; }
bool is_small(char c) { return c >= 'a' && c <= 'z'; }

}  // namespace

std::string suffix_of(const std::string& path) {
  std::string suffix = std::filesystem::path(path).extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(),
                 [](char c) { return is_capital(c) ? static_cast<char>(c - 'A' + 'a') : c; });
  return suffix;
}

std::string with_suffix(const std::string& path, const std::string& suffix) {
  const std::string own = std::filesystem::path(path).extension().string();
  std::string other = suffix;
  if (std::any_of(own.begin(), own.end(), is_capital) &&
      std::none_of(own.begin(), own.end(), is_small)) {
    std::transform(other.begin(), other.end(), other.begin(),
                   [](char c) { return is_small(c) ? static_cast<char>(c - 'a' + 'A') : c; });
  }
  return std::filesystem::path(path).replace_extension(other).string();
}

}  // namespace tetfusion
