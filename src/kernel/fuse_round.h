// Fuse: neighbouring vertices become one where that costs least, pass after pass (DESIGN in
// README.md). Each fusion is tested as TetFuse is: every affected tetrahedron keeps positive volume.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "kernel/criteria.h"
#include "kernel/fusions.h"
#include "kernel/quadric.h"
#include "mesh/vertex_tets.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// A chunk's vertices by what their cheapest fusion costs: two bins an octave. Costs are squared
// errors, as shares of a field's range.
inline constexpr std::size_t kCostBins = 160;
using CostHistogram = std::array<std::uint64_t, kCostBins>;
std::size_t cost_bin(double cost);      // the first and last take all that is below or above
double cost_bin_end(std::size_t bin);   // costs in the bin are below it

enum class Method : std::uint8_t {
  kTetFuse,  // the paper's: the four vertices of a tetrahedron become one
  kFuse,     // neighbours become one, cheapest first
};

struct FuseLimits {
  double threshold = std::numeric_limits<double>::infinity();  // no fusion costs more
  // A tetrahedron's mean ratio may not be below it, unless there was a worse one in the cavity.
  double min_quality = 0;
  double aspect_ratio = std::numeric_limits<double>::infinity();  // infinity is off
  double unit = 1;  // lengths are multiplied by it: a power of two, about 1 / the mesh's diagonal
  // At most so many tetrahedra may go; with `cheapest_first` the cheapest fusions, else first come,
  // first served.
  std::uint64_t quota = std::numeric_limits<std::uint64_t>::max();
  bool cheapest_first = false;
};

struct FuseStatistics {
  PassStatistics pass;  // of all passes; `rejected` counts vertices, by why they did not fuse
  CostHistogram costs{};  // of the vertices that are left and might fuse
};

// Numbers in the row of WorkMesh::quadrics: the quadric, and what the vertex's cheapest fusion
// costs, or 0 where nobody knows.
constexpr std::uint32_t quadric_row(std::uint32_t steering_width) {
  return static_cast<std::uint32_t>(quadric_size(steering_width) + 1);
}

// Gives each vertex the quadric of its tetrahedra in the mesh.
template <class Real>
void begin_quadrics(std::span<const SteeringField> fields, double unit, WorkMesh<Real>* mesh);

// Works on a chunk. Keeps its scratch memory. Not thread-safe; different objects are independent.
template <class Real>
class FuseRound {
 public:
  // Passes over the vertices, in order, until one fuses next to nothing, then compacts the mesh:
  // ids are stale afterwards, their order is kept. Carried columns follow. A pure function of the
  // mesh and the limits. Preconditions as for GreedyPass::run(); the mesh has quadrics.
  FuseStatistics run(const FuseLimits& limits, std::span<const SteeringField> fields,
                     WorkMesh<Real>* mesh);

  // The costs alone, for the rows of the mesh.
  FuseStatistics look(const FuseLimits& limits, std::span<const SteeringField> fields,
                      WorkMesh<Real>* mesh);

 private:
  static constexpr std::size_t kCandidates = 4;
  struct Candidate {
    float cost = std::numeric_limits<float>::infinity();
    VertexId partner = kNoVertex;
  };
  using Candidates = std::array<Candidate, kCandidates>;
  struct Ball {
    std::uint32_t begin = 0, count = 0, room = 0;
  };

  void begin(const FuseLimits& limits, std::span<const SteeringField> fields,
             WorkMesh<Real>* mesh);
  void finish(FuseStatistics* statistics);
  std::uint64_t pass();
  bool visit(VertexId v);
  bool knows_candidates(VertexId v) const;
  std::span<const std::uint32_t> ball(VertexId v);
  void judge(VertexId v);
  float cost_of(VertexId v, VertexId partner);
  Offset offset(VertexId from, VertexId to) const;
  bool can_move(VertexId v) const { return kind_[v] == kFree; }
  const float* quadric(VertexId v) const { return mesh_->quadrics.data() + v * row_; }
  bool fuse(VertexId v, VertexId partner);
  bool plan(VertexId v, VertexId partner);
  void place(VertexId v, VertexId partner);
  bool collect_cavity(VertexId v, VertexId partner);
  bool collect_ball(VertexId moved, VertexId other, bool note_deleted);
  bool shape_allows(std::uint32_t entry);
  double worst_of_cavity();
  void note_fusion(VertexId kept);
  void apply(VertexId v, VertexId partner, VertexId kept);
  void give_ball(VertexId kept, bool fixed);
  void write_steering_columns();
  void compact();

  enum Kind : std::uint8_t {
    kFree,    // may be fused
    kTarget,  // others may come to it
    kOut,     // neither
  };

  const FuseLimits* limits_ = nullptr;
  WorkMesh<Real>* mesh_ = nullptr;
  std::size_t width_ = 0, row_ = 0;
  std::span<const SteeringField> fields_;
  bool interpolates_ = false;       // there are point columns that do not steer
  std::vector<float> field_scale_;  // of each steering value: one over its field's range

  VertexTets start_;
  Vector<std::uint32_t> entries_;  // tet << 2 | corner; balls lie in it
  Vector<Ball> balls_;
  Vector<Kind> kind_;
  Vector<std::uint8_t> reason_;
  Vector<Candidates> candidates_;
  // In the order of what happens, from 1 on.
  std::uint32_t now_ = 0;
  Vector<std::uint32_t> changed_;  // when the vertex got its quadric
  Vector<std::uint32_t> judged_;   // when its candidates were chosen
  Vector<std::uint32_t> tried_;    // when they were last found wanting
  Vector<std::uint32_t> moved_;    // when its ball last changed
  Vector<std::uint32_t> fused_in_;  // the last pass that made it
  std::uint32_t pass_ = 0;
  std::uint64_t removed_ = 0, fused_ = 0;
  Vector<std::uint32_t> stamp_;
  std::uint32_t stamped_ = 0;
  Vector<VertexId> ring_;
  Vector<std::pair<float, VertexId>> order_;

  // The plan in hand.
  std::vector<float> sum_, shifted_, differences_;
  std::vector<double> values_;
  Vec3<Real> position_{};
  bool fixed_ = false;
  Reject reject_{};
  Vector<std::uint32_t> affected_;
  Vector<TetId> deleted_;
  double worst_ = 0;  // cubed mean ratio in the cavity; negative: not yet known

  Vector<Interpolation> interpolations_;
};

extern template class FuseRound<float>;
extern template class FuseRound<double>;

}  // namespace tetfusion
