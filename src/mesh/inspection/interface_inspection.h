// What inspect() would say of the whole mesh, from what its chunks have reported.
#pragma once

#include <cstdint>
#include <span>

#include "base/sums.h"
#include "base/vector.h"
#include "mesh/inspection/chunk_inspection.h"
#include "mesh/inspection/mesh_counts.h"

namespace tetfusion {

// The counts are over all chunks.
struct InterfaceVerdict : MeshCounts {
  double volume = 0;  // but for rounding

  // The points on the interface, ascending by id, and their flags (VertexFlag bits).
  Vector<VertexId> ids;
  Vector<std::uint8_t> flags;
  // Boundary triangles of three such points, by ids. ChunkFindings::boundary has the others.
  Vector<std::array<VertexId, 3>> boundary;
  // Free points that are broken though their chunk did not say so; ascending ids. Usually none.
  Vector<VertexId> overrides;
};

// The verdict is that of inspect() on the whole mesh, for any cut into chunks, but that another
// side of a fold-over may count as inverted where
// - a face has more than two cells, of which two in one chunk fit together: these count as
//   neighbours, which inspect() does not let cells of such a face be;
// - the cells cannot be wound consistently (a Moebius strip of them), and chunks give no cell ids.
//
// Faces, edges and cells are settled as soon as one of their points is kSharedLast: with that only
// what lies between the chunks that were added and those that were not is held. Without, all
// interfaces are held to the end. Points and their flags are held in any case: 12 bytes each, and 8
// to 16 in a hash table.
class InterfaceInspection {
 public:
  // Settles when so many faces wait, or twice as many as could not be settled the last time.
  explicit InterfaceInspection(std::size_t least_to_settle = 1 << 16)
      : least_to_settle_(least_to_settle), settle_at_(least_to_settle) {}

  // The same order of chunks gives the same verdict. Takes findings->interface, leaves it empty.
  // One thread at a time.
  void add(ChunkFindings* findings);

  // After the last chunk; call once. Starts no threads.
  InterfaceVerdict finish();

  // Faces, edges and cells that are not settled yet, for tests.
  std::size_t pending() const { return sides_.size() + edges_.size() + cells_.size(); }

 private:
  using Side = InterfaceFindings::Side;
  using Triangle = std::array<VertexId, 3>;

  std::uint32_t find(VertexId id) const;  // kNoVertex: not on the interface
  std::uint32_t find_or_add(VertexId id);
  void grow_slots();
  Vector<std::uint32_t> add_points(const InterfaceFindings& from);
  void add_cells(const InterfaceFindings& from, const Vector<std::uint32_t>& number);
  void mark(VertexId id, std::uint8_t flag);

  void settle(bool everything);
  void settle_cells(std::size_t count);
  void settle_faces(std::size_t count);
  void judge_face(std::span<const Side> sides);
  void find_inverted();
  void judge_surface();
  void judge_balls();
  void write_points();

  // Points are numbered as they come; sides, cells and edges name them by number.
  Vector<InterfaceFindings::Point> points_;
  Vector<std::uint32_t> slots_;  // hash table of numbers, kNoVertex where free; a power of two
  // Not settled yet.
  Vector<Side> sides_;                          // faces begin with their smallest point
  Vector<std::array<std::uint32_t, 4>> cells_;  // ascending corners
  Vector<std::uint64_t> edges_;  // smaller << 32 | larger end; those of settled faces too
  std::size_t least_to_settle_;
  std::size_t settle_at_;  // so many sides

  Vector<Cluster> clusters_;
  DisjointSets joined_;  // clusters that go on in each other
  Vector<Fold> folds_;
  Vector<InterfaceFindings::Member> members_;
  Vector<Triangle> triangles_;  // as reported: by id
  Vector<Triangle> faces_;      // boundary triangles of three points on the interface, by number
  Vector<std::uint32_t> triangles_at_;  // boundary triangles of each point
  Vector<VertexId> unsound_balls_;
  std::uint64_t cell_count_ = 0;
  CompensatedSum volume_;
  InterfaceVerdict verdict_;
};

}  // namespace tetfusion
