// The nodes and elements of a Gmsh file of any version, text or binary, from any place on.
#pragma once

#include <bitset>
#include <cstdint>
#include <map>
#include <vector>

#include "io/formats/format_source.h"
#include "io/formats/number_map.h"
#include "io/gmsh/gmsh_elements.h"
#include "io/gmsh/gmsh_groups.h"
#include "io/gmsh/gmsh_head.h"
#include "io/source/reading_memory.h"
#include "mesh/geometry.h"

namespace tetfusion {

// Where the next node begins, and what was said before it.
struct GmshNodePlace {
  const char* at = nullptr;
  std::uint64_t blocks = 0;  // of version 4: that still come
  std::uint64_t left = 0;    // nodes of this block
  std::uint64_t more = 0;    // numbers behind the coordinates of each
};

// Nodes and elements in the order of the file, which is gone through once, here, or twice where
// elements are repeated (gmsh_elements.h); without repetitions and those of seams (gmsh_head.h),
// whose numbers elements() leads behind all others. What is kept: 72 bytes for each 4096 of them,
// and bytes(): the numbers of nodes, and of elements where there are values for some, unless they
// ascend by one.
//
// Throws Error(kBadInput); read_cells() InvalidMesh for a node that is not there. Safe to use from
// several threads. Pages of the file that were read do not stay in memory.
class GmshMesh {
 public:
  GmshMesh(const FormatFile& file, const GmshHead& head);  // must outlive this object

  std::uint64_t element_count() const { return element_count_; }
  const CellTypeCounts& cell_types() const { return types_; }
  // Of versions 1 and 2, which have these with each element:
  const PhysicalGroups& groups() const { return groups_; }
  bool has_partitions() const { return has_partitions_; }
  const NumberMap& nodes() const { return nodes_; }
  const NumberMap& elements() const { return elements_; }
  std::uint64_t bytes() const { return nodes_.bytes() + elements_.bytes(); }

  void read_points(std::uint64_t first, std::uint64_t count, Vec3<double>* out) const;
  ListedCells read_cells(std::uint64_t first, std::uint64_t count) const;
  // Physical groups or, else, entities.
  void read_tags(bool physical, std::uint64_t first, std::uint64_t count, std::int32_t* out) const;

 private:
  template <class F>
  void walk_elements(std::uint64_t first, std::uint64_t count, bool nodes, F f) const;
  void index_elements();
  void count_groups();

  const FormatFile& file_;
  const GmshHead& head_;
  std::vector<GmshNodePlace> node_places_;
  std::vector<GmshElementPlace> element_places_;
  std::uint64_t element_count_ = 0;
  bool repeats_ = false;
  bool has_partitions_ = false;
  CellTypeCounts types_{};
  PhysicalGroups groups_;
  NumberMap nodes_, elements_;
};

// The dimensions 0 to 3 of the elements that are in physical groups of these
// tags. Goes through the whole file.
using GmshDimensions = std::map<std::int64_t, std::bitset<4>>;
void find_dimensions(const FormatFile& file, const GmshHead& head, GmshDimensions* of_tags);

}  // namespace tetfusion
