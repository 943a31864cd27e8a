// Through a section of a Gmsh file from place to place: its head first, then rows; in version 4 in
// blocks.
#pragma once

#include <cstddef>
#include <string_view>

#include "io/gmsh/gmsh_head.h"

namespace tetfusion {

// Place: `at`, where the next row begins, `blocks`, of version 4 those that still come, and what
// else was said before it.
template <class Place>
class GmshWalker {
 public:
  Place place() const {
    Place here = place_;
    here.at = in_.at();
    return here;
  }
  const GmshCursor& cursor() const { return in_; }

 protected:
  GmshWalker(const FormatFile& file, const GmshHead& head, std::string_view section)
      : head_(head), in_(file, section, head.binary, head.swapped) {
    place_.blocks = head_.read_counts(&in_).blocks;
  }
  GmshWalker(const FormatFile& file, const GmshHead& head, std::string_view section,
             const Place& place)
      : head_(head),
        in_(file, section.substr(static_cast<std::size_t>(place.at - section.data())), head.binary,
            head.swapped),
        place_(place) {}

  const GmshHead& head_;
  GmshCursor in_;
  Place place_;
};

}  // namespace tetfusion
