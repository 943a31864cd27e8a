// Runs a case of the corpus and has its result judged.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace corpus {

struct Outcome {
  std::size_t kind = 0;
  std::uint64_t before = 0, after = 0;  // tetrahedra
  std::string refused;                  // why there is no result; empty: there is one
  std::vector<std::string> faults;
  std::string options;
};

// In `folder`, where it leaves in.vtu and out.vtu. Throws what is no refusal.
Outcome run_case(std::uint64_t number, const std::string& folder);

}  // namespace corpus
