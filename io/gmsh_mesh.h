// The nodes and elements of a Gmsh file, version 2 or 4, text or binary.
#pragma once

#include <cstdint>

#include "base/vector.h"
#include "io/format_source.h"
#include "io/gmsh_head.h"
#include "io/number_map.h"
#include "mesh/geometry.h"

namespace tetfusion {

struct GmshNodes {
  Vector<Vec3<double>> points;
  NumberMap places;  // by the nodes' numbers
};

struct GmshElements {
  ListedCells cells;
  Vector<std::int32_t> physical, geometrical;
  Vector<std::uint64_t> numbers;
};

// Throw Error(kBadInput); read_gmsh_elements() InvalidMesh for a node that is not there.
GmshNodes read_gmsh_nodes(const FormatFile& file, const GmshHead& head);
GmshElements read_gmsh_elements(const FormatFile& file, const GmshHead& head,
                                const NumberMap& nodes);

}  // namespace tetfusion
