// The nodes and elements of a Gmsh file, version 2 or 4, text or binary, from any place on.
#pragma once

#include <cstdint>
#include <vector>

#include "base/vector.h"
#include "io/format_source.h"
#include "io/gmsh_head.h"
#include "io/number_map.h"
#include "io/reading_memory.h"
#include "mesh/geometry.h"

namespace tetfusion {

// Where the next node begins, and what was said before it.
struct GmshNodePlace {
  const char* at = nullptr;
  std::uint64_t blocks = 0;  // of version 4: that still come
  std::uint64_t left = 0;    // nodes of this block
  std::uint64_t more = 0;    // numbers behind the coordinates of each
};

// The same for elements.
struct GmshElementPlace {
  const char* at = nullptr;
  std::uint64_t blocks = 0;
  std::uint64_t left = 0;  // elements of this block; one, where each says for itself what it is
  GmshElementType type;
  std::uint64_t tags = 0;
  std::int64_t physical = 0;
  std::int64_t geometrical = 0;
};

// Nodes and elements in the order of the file, which is gone through once, here; without those of
// seams (gmsh_head.h), whose numbers elements() leads behind all others. What is kept: 64
// bytes for each 4096 of them, and bytes(): the numbers of nodes, and of elements where there are
// values for some, unless they ascend by one.
//
// Throws Error(kBadInput); read_cells() InvalidMesh for a node that is not there. Safe to use from
// several threads. Pages of the file that were read do not stay in memory.
class GmshMesh {
 public:
  GmshMesh(const FormatFile& file, const GmshHead& head);  // must outlive this object

  const CellTypeCounts& cell_types() const { return types_; }
  const NumberMap& nodes() const { return nodes_; }
  const NumberMap& elements() const { return elements_; }
  std::uint64_t bytes() const { return nodes_.bytes() + elements_.bytes(); }

  void read_points(std::uint64_t first, std::uint64_t count, Vec3<double>* out) const;
  ListedCells read_cells(std::uint64_t first, std::uint64_t count) const;
  // Physical groups or, else, entities.
  void read_tags(bool physical, std::uint64_t first, std::uint64_t count, std::int32_t* out) const;

 private:
  template <class F>
  void walk_elements(std::uint64_t first, std::uint64_t count, const NumberMap* nodes, F f) const;

  const FormatFile& file_;
  const GmshHead& head_;
  std::vector<GmshNodePlace> node_places_;
  std::vector<GmshElementPlace> element_places_;
  CellTypeCounts types_{};
  NumberMap nodes_, elements_;
};

}  // namespace tetfusion
