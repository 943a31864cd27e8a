// The rows of $NodeData or $ElementData: a number and values each, in any order, not for all nodes
// or elements.
#pragma once

#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "io/formats/number_map.h"
#include "io/gmsh/gmsh_head.h"

namespace tetfusion {

// Goes through the rows once, and keeps 32 bytes for each 4096 of them. Rows for what `places`
// leads to `count` or behind are passed over. Throws Error(kBadInput) for a number that is not
// there. All arguments must outlive this object. Safe to use from several threads. Pages of the
// file that were read do not stay in memory.
class GmshRows {
 public:
  GmshRows(const FormatFile& file, const GmshHead& head, const GmshData& data,
           const NumberMap& places, std::uint64_t count);

  // Are the rows in the order of what they are for? Else read() goes through them all.
  bool in_order() const { return in_order_; }

  // The values for `count` of these from `first` on; NaN where there are none, the last ones where
  // there are several.
  void read(std::uint64_t first, std::uint64_t count, double* out) const;

 private:
  struct Place {
    std::uint64_t of = 0;  // what the first row there is for that is not passed over
    std::uint64_t rows = 0;
    std::string_view text;  // from the first of these rows to the end of their section
  };
  template <class F>
  const char* walk(const Place& place, F f) const;

  const FormatFile& file_;
  const GmshHead& head_;
  const GmshData& data_;
  const NumberMap& numbers_;
  std::uint64_t count_;
  std::vector<Place> places_;
  bool in_order_ = true;
};

}  // namespace tetfusion
