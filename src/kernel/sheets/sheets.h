// Sheets: the boundary surface, and the surfaces between regions. What a vertex's ball says of
// them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "kernel/edge_links.h"
#include "kernel/live_balls.h"
#include "kernel/sheets/boundary_triangles.h"
#include "kernel/sheets/facing_grid.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// An edge from a vertex, on a sheet whose normal is on the right-hand side: from, to are the next
// two corners of a triangle.
struct SheetEdge {
  VertexId from, to;
  bool is_outer;  // on the boundary, or where this mesh ends
};

// The triangles of a sheet round a vertex: one closed fan. Triangle i has the vertex, ring[i] and
// ring[i + 1].
struct SheetFan {
  std::vector<VertexId> ring;
  std::vector<std::uint8_t> sharp;  // of the edge to ring[i]
  std::size_t sharp_edges = 0;

  std::size_t size() const { return ring.size(); }
  VertexId at(std::size_t i) const { return ring[i % ring.size()]; }
  // Turns the ring so that u comes first; false if it is not there.
  bool turn_to(VertexId u);
};

enum class SheetFeature : std::uint8_t {
  kNone,    // on no sheet
  kSmooth,  // inside a sheet
  kLine,    // on a line where a sheet is sharp
  kCorner,  // where a line ends, lines or sheets meet, or something is odd
};

// Keeps its memory from mesh to mesh. Not thread-safe.
template <class Real>
class Sheets {
 public:
  // Regions are made by these cell columns. Two triangles that meet at an edge make it a sharp one
  // if their normals are so many degrees apart, or more; where that is more than kFeatureAngle,
  // lines by this one that are straight stay lines, as vertices go along them. The mesh and its
  // balls outlive this; whoever changes them leaves the tetrahedra's numbers.
  void begin(const WorkMesh<Real>* mesh, LiveBalls* balls,
             std::span<const std::uint32_t> region_columns, double feature_angle);

  // Does the vertex lie between regions, as far as this mesh knows?
  bool is_between_regions(VertexId v) const { return mixed_[v] != 0; }

  // The rest is right for vertices with all their tetrahedra here.
  //
  // Edges of the sheets' triangles opposite to v, by their keys. A surface between two
  // regions looks out of the one that came first.
  const std::vector<SheetEdge>& edges_opposite(VertexId v);
  // Notes boundary triangles of the vertex, each once for all vertices. Those between vertices that
  // other chunks have, too, may lie between two chunks: they count if all three are marked as
  // lying on the boundary, or if those marks are yet to come ...
  void note_facing(VertexId v, bool marks_are_known, FacingGrid* grid);
  // ... or do not count.
  void note_facing(VertexId v, BoundaryTriangles* triangles);
  // False if the vertex's triangles are not one closed fan. Some are kept for the next time ...
  bool find_fan(VertexId v, SheetFan* fan);
  // ... until the tetrahedra round the vertex change.
  void forget_fan(VertexId v) {
    if (KeptFan& kept = kept_fan(v); kept.vertex == v) kept.vertex = kNoVertex;
  }
  SheetFeature feature(VertexId v);
  // Adds the squared distances from the planes of its triangles, by their areas, to a quadric
  // without fields.
  void add_planes(VertexId v, double unit, float* quadric);

  // May the ends of an edge become one as far as topology goes? The edge has two triangles of a
  // sheet, and `fan` is a's; `other` is b's, if it has one. In the volume, and on the sheet, the
  // links of the two share the link of the edge and nothing else.
  bool may_contract(VertexId a, const SheetFan& fan, VertexId b, const SheetFan* other = nullptr);

 private:
  struct Face {
    std::uint64_t key;  // its two other corners, the smaller one first
    SheetEdge edge;
    std::uint32_t region;
    bool open;  // it has not been seen from the other side, in the same region
  };
  static constexpr std::uint32_t kNoFace = 0xFFFFFFFFu;
  // Larger ones are not kept.
  static constexpr std::size_t kLargestKept = 13;
  struct KeptFan {
    VertexId vertex = kNoVertex;
    std::uint32_t size = 0;   // 0: it is none
    std::uint32_t sharp = 0;  // bits
    std::array<VertexId, kLargestKept> ring{};

    void take(VertexId v, const SheetFan& fan, bool is_one);
    bool give(SheetFan* fan) const;
  };
  static constexpr std::size_t kKeptFans = std::size_t{1} << 15;  // 2 MiB
  KeptFan& kept_fan(VertexId v) { return kept_fans_[v % kKeptFans]; }
  bool look_for_fan(VertexId v, SheetFan* fan);
  // Calls note(a, b, c) with the boundary triangles of which v is the first vertex.
  template <class Note>
  void for_each_outer(VertexId v, Note note);
  Point3 at(VertexId v) const {
    const Vec3<Real>& p = mesh_->positions[v];
    return {double{p.x}, double{p.y}, double{p.z}};
  }
  void mark_edges(VertexId v, SheetFan* fan);
  // As far as marks tell.
  bool may_be_on_sheet(VertexId v) const {
    return (mesh_->marks[v] & (kOnBoundary | kOnInterface)) != 0 || is_between_regions(v);
  }
  template <class AnyEdge>
  static bool may_contract_on_sheet(const SheetFan& fan, const AnyEdge& any_edge_of_other);
  std::uint32_t region_of(std::size_t t) const { return region_.empty() ? 0 : region_[t]; }

  const WorkMesh<Real>* mesh_ = nullptr;
  LiveBalls* balls_ = nullptr;
  double feature_cosine_ = 1, line_cosine_ = 1;
  Vector<std::uint32_t> region_;  // of a tetrahedron; none: there is one region
  Vector<std::uint8_t> mixed_;
  std::vector<Face> faces_;
  std::vector<std::uint32_t> table_;
  std::vector<SheetEdge> edges_;
  std::vector<KeptFan> kept_fans_;
  SheetFan fan_;
  std::vector<double> bends_;  // cosines, of a fan's edges
  EdgeLinks links_;
};

extern template class Sheets<float>;
extern template class Sheets<double>;

}  // namespace tetfusion
