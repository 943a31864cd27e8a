#include "mesh/region_names.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <string_view>

namespace tetfusion {

namespace {

// What Medit and TetGen call references, where their files become arrays.
constexpr std::array<std::string_view, 2> kReferences{"medit:ref", "tetgen:ref"};

bool is_named_like_material(std::string_view name) {
  constexpr std::array<std::string_view, 8> kWords{"material", "region", "physical", "tissue",
                                                   "block",    "zone",   "part",     "label"};
  // A partition's rank says who computed a cell, not what it is made of.
  constexpr std::array<std::string_view, 3> kPartitions{"partition", "particle", "parallel"};
  std::string lower(name);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto contains = [&](std::string_view word) {
    return lower.find(word) != std::string::npos;
  };
  return std::any_of(kWords.begin(), kWords.end(), contains) &&
         std::none_of(kPartitions.begin(), kPartitions.end(), contains);
}

}  // namespace

bool can_be_region(const ArrayInfo& array) {
  return array.components == 1 && !is_float(array.type) && array.type != ValueType::kString;
}

bool looks_like_region(const ArrayInfo& array) {
  const bool reference =
      std::find(kReferences.begin(), kReferences.end(), array.name) != kReferences.end();
  return can_be_region(array) && (reference || is_named_like_material(array.name));
}

}  // namespace tetfusion
