#include "mesh/regions/region_names.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <string_view>
#include <vector>

namespace tetfusion {

namespace {

// What Medit and TetGen call references, where their files become arrays.
constexpr std::array<std::string_view, 2> kReferences{"medit:ref", "tetgen:ref"};

// What VTK calls the element blocks of an Exodus file, which are its materials.
constexpr std::string_view kExodusBlocks = "ObjectId";

// "CellEntityIds", "cell_entity_ids", "gmsh:geometrical" in lower case.
std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> words(1);
  bool was_lower = false;
  for (const char c : name) {
    const auto letter = static_cast<unsigned char>(c);
    if (std::isalpha(letter) == 0 || (was_lower && std::isupper(letter) != 0)) {
      words.emplace_back();
    }
    if (std::isalpha(letter) != 0) words.back() += static_cast<char>(std::tolower(letter));
    was_lower = std::islower(letter) != 0;
  }
  return words;
}

template <std::size_t N>
bool has_word(const std::vector<std::string>& words, const std::array<std::string_view, N>& known) {
  return std::any_of(words.begin(), words.end(), [&](std::string_view word) {
    const std::string_view one = word.ends_with('s') ? word.substr(0, word.size() - 1) : word;
    return std::find(known.begin(), known.end(), word) != known.end() ||
           std::find(known.begin(), known.end(), one) != known.end();
  });
}

// A rank says who computed a cell, not what it is made of.
bool has_rank(const std::vector<std::string>& words) {
  constexpr std::array<std::string_view, 7> kRanks{"rank", "proc",     "process", "processor",
                                                   "mpi",  "parallel", "ghost"};
  return has_word(words, kRanks);
}

// It says which one a cell is.
bool is_number_of_cell(const std::vector<std::string>& words) {
  constexpr std::array<std::string_view, 10> kNumbers{"partition", "global", "original", "orig",
                                                      "pedigree",  "index",  "indice",   "number",
                                                      "num",       "count"};
  constexpr std::array<std::string_view, 9> kCells{"cell", "element", "elem", "tet", "tetra",
                                                   "id",   "nr",      "no",   ""};
  const auto is_of_cell = [&](const std::string& word) {
    return has_word(std::vector{word}, kCells);
  };
  return has_word(words, kNumbers) || std::all_of(words.begin(), words.end(), is_of_cell);
}

bool is_named_like_material(std::string_view name) {
  constexpr std::array<std::string_view, 7> kParts{"material", "region", "physical", "tissue",
                                                   "block",    "zone",   "label"};
  constexpr std::array<std::string_view, 3> kWords{"part", "partid", "partno"};
  const std::vector<std::string> words = words_of(name);
  std::string lower(name);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const bool named = std::any_of(kParts.begin(), kParts.end(), [&](std::string_view part) {
    return lower.find(part) != std::string::npos;
  });
  return (named || has_word(words, kWords)) && !has_rank(words) &&
         lower.find("partition") == std::string::npos;
}

}  // namespace

bool is_reference(const ArrayInfo& array) {
  return std::find(kReferences.begin(), kReferences.end(), array.name) != kReferences.end();
}

bool can_be_region(const ArrayInfo& array) {
  return array.components == 1 && array.type != ValueType::kString;
}

bool is_integer_label(const ArrayInfo& array) {
  return can_be_region(array) && !is_float(array.type);
}

bool looks_like_region(const ArrayInfo& array) {
  return is_integer_label(array) &&
         (is_reference(array) || array.name == kExodusBlocks || is_named_like_material(array.name));
}

bool is_region_of_floats(const ArrayInfo& array) {
  return can_be_region(array) && is_float(array.type) &&
         (is_reference(array) || is_named_like_material(array.name));
}

bool may_be_partition(const ArrayInfo& array) {
  constexpr std::array<std::string_view, 4> kShares{"part", "partid", "partno", "partition"};
  const std::vector<std::string> words = words_of(array.name);
  return has_word(words, kShares) || has_rank(words);
}

bool may_be_region(const ArrayInfo& array) {
  const std::vector<std::string> words = words_of(array.name);
  return is_integer_label(array) && !looks_like_region(array) && !has_rank(words) &&
         !is_number_of_cell(words);
}

}  // namespace tetfusion
