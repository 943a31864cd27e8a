// A mesh of another program's format, read whole: what is the same for all such formats.
#pragma once

#include <cstdint>
#include <memory>

#include "base/vector.h"
#include "io/mesh_source.h"
#include "io/reading_memory.h"
#include "mesh/geometry.h"

namespace tetfusion {

// Cells of all kinds as a file lists them: VTK's types, and the points of one after another in
// VTK's order, counted from 0.
struct ListedCells {
  Vector<std::uint8_t> types;
  Vector<VertexId> ids;
};

// The parts of a file, each found when it is asked for, and again when it is asked for again.
class FormatReader {
 public:
  virtual ~FormatReader() = default;
  virtual const MeshDescription& description() const = 0;
  virtual CellTypeCounts cell_types() const = 0;
  // What reading takes beside what is read.
  virtual std::uint64_t memory_beside() const { return 0; }

  // Throw Error(kBadInput), naming the place; read_cells() InvalidMesh for a point that is not
  // there.
  virtual Points read_points() const = 0;
  virtual ListedCells read_cells() const = 0;
  virtual DataArray read_array(Association association, std::size_t index) const = 0;
};

std::unique_ptr<MeshSource> make_source(std::unique_ptr<FormatReader> reader,
                                        const OpenOptions& options);

}  // namespace tetfusion
