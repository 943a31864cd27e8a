// The elements of a Gmsh file one after another.
//
// Versions 1 and 2 have an element that is in several physical groups once for each of them, one
// right after the other, with numbers of their own. Here it is one element, with the last of these
// numbers, which is the one that Gmsh's data have.
#pragma once

#include <array>
#include <cstdint>

#include "base/vector.h"
#include "io/formats/number_map.h"
#include "io/gmsh/gmsh_groups.h"
#include "io/gmsh/gmsh_walker.h"
#include "mesh/geometry.h"

namespace tetfusion {

// Where the next element begins, and what was said before it.
struct GmshElementPlace {
  const char* at = nullptr;
  std::uint64_t done = 0;    // elements before, repeated ones too
  std::uint64_t blocks = 0;  // of version 4: that still come
  std::uint64_t left = 0;    // elements of this block; one, where each says for itself what it is
  GmshElementType type;
  std::uint64_t tags = 0;
  std::int64_t physical = 0;
  std::int64_t geometrical = 0;
};

struct GmshElement {
  std::uint64_t number = 0;
  GmshElementType type;
  std::int32_t physical = 0;
  std::int32_t geometrical = 0;
  const char* corners_at = nullptr;
  std::array<std::uint64_t, 8> corners{};  // their nodes' numbers, where they are wanted

  int dimension() const;
};

class GmshElements : public GmshWalker<GmshElementPlace> {
 public:
  struct Wanted {
    bool together = false;  // what is repeated is found once, else each time
    bool corners = false;
  };
  // From the first one on. `passed` gets the numbers of those that are passed over: seams, and of
  // repeated elements all but the last.
  GmshElements(const FormatFile& file, const GmshHead& head, const Wanted& wanted,
               Vector<std::uint64_t>* passed);
  GmshElements(const FormatFile& file, const GmshHead& head, const Wanted& wanted,
               const GmshElementPlace& place);

  // Where the element begins that next() will find.
  GmshElementPlace place() const;

  // False at the end of the section, where nothing else may stand.
  bool next(GmshElement* out);
  // Of what is taken together: the groups of the last element.
  const PhysicalGroups::Tags& groups() const { return groups_; }
  // Of version 2: an element so far says which partitions have it.
  bool has_partitions() const { return has_partitions_; }

  // The places of its corners' nodes, in VTK's order. Throws InvalidMesh for one that is not there.
  void find_corners(const GmshElement& element, const NumberMap& nodes, VertexId* out) const;

 private:
  bool find_element();
  void read(GmshElement* out);
  void read_number(GmshElement* out);
  void read_tags(GmshElement* out);
  void check_node_count();
  void begin_block();
  void begin_headed_list();
  void pass_over_block(std::uint64_t nodes);
  GmshElementType element_type();
  std::int32_t small(std::int64_t tag) const;
  std::uint64_t announced() const { return head_.element_count + head_.seam_elements; }
  [[noreturn]] void fail_too_many() const;

  Wanted wanted_;
  Vector<std::uint64_t>* passed_ = nullptr;
  PhysicalGroups::Tags groups_;
  bool has_partitions_ = false;
  // It takes the element behind to know where repetitions end.
  bool has_ahead_ = false;
  GmshElement ahead_;
  GmshElementPlace ahead_place_;
};

}  // namespace tetfusion
