// A mesh of another program's format: what is the same for all such formats, whole and in windows.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "base/vector.h"
#include "io/source/mesh_source.h"
#include "io/source/reading_memory.h"
#include "mesh/geometry.h"

namespace tetfusion {

// Cells of all kinds as a file lists them: VTK's types, and the corners of one after another in
// VTK's order, points counted from 0. Curved cells have no other points here.
struct ListedCells {
  Vector<std::uint8_t> types;
  Vector<VertexId> ids;
};

// The parts of a file, in ranges, each found when it is asked for, and again when it is asked for
// again. Safe to use from several threads. What was read does not stay in memory, pages of the file
// included.
class FormatReader {
 public:
  virtual ~FormatReader() = default;
  virtual const MeshDescription& description() const = 0;
  virtual CellTypeCounts cell_types() const = 0;
  // What it keeps, where that grows with the mesh.
  virtual std::uint64_t bytes() const { return 0; }
  // False: read_rows() goes through all rows, whatever the range.
  virtual bool has_rows_in_order() const { return true; }

  // Throw Error(kBadInput), naming the place; read_cells() InvalidMesh for a point that is not
  // there. Points are of the description's type, rows those of point and cell arrays.
  virtual void read_points(std::uint64_t first, std::uint64_t count, std::byte* out) const = 0;
  virtual ListedCells read_cells(std::uint64_t first, std::uint64_t count) const = 0;
  virtual void read_rows(Association association, std::size_t index, std::uint64_t first,
                         std::uint64_t count, std::byte* out) const = 0;
  virtual DataArray read_field(std::size_t index) const;
};

std::unique_ptr<MeshSource> make_source(std::unique_ptr<FormatReader> reader,
                                        const OpenOptions& options);

}  // namespace tetfusion
