// Elements that are in several physical groups of a Gmsh file: of which one they are taken.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace tetfusion {

struct GmshName {
  static constexpr int kNoDimension = -1;

  int dimension = kNoDimension;  // version 2.0 does not say it, and then 4.0 says -1
  std::int32_t tag = 0;
  std::string name;
};

// All elements are to be added first.
class PhysicalGroups {
 public:
  using Tags = std::vector<std::int64_t>;  // different ones

  // So many elements of a dimension that are in all of these.
  void add(int dimension, const Tags& groups, std::uint64_t elements);

  // The one that has the fewest elements, which says most of where this one lies: a group "all"
  // stands back behind its parts. Of equal ones the first; 0 of none.
  std::int64_t choose(int dimension, const Tags& groups) const;

  // What is left out: "elements of the physical groups all, 7 that are in another one, too", by
  // the names that they have; empty if nothing is.
  std::string left_out(const std::vector<GmshName>& names) const;

 private:
  using Group = std::pair<int, std::int64_t>;  // dimension and tag

  std::map<Group, std::uint64_t> elements_;
  std::map<std::pair<int, Tags>, std::uint64_t> several_;  // the same, of those that are in several
};

}  // namespace tetfusion
