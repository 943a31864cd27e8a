// One greedy pass of TetFuse over a mesh (Chopra & Meyer 2002, section 3).
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "kernel/criteria.h"
#include "kernel/fusion_notes.h"
#include "kernel/fusions.h"
#include "mesh/vertex_tets.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

enum class BoundaryRule : std::uint8_t {
  kTets,      // the paper's text: neither the prey nor an affected tetrahedron has a vertex on the
              // boundary
  kVertices,  // no vertex of the prey lies on the boundary; affected tetrahedra may touch it
};

struct PassLimits {
  BoundaryRule boundary_rule = BoundaryRule::kVertices;
  PaperLimits paper;
  // At most so many tetrahedra may go. With `spread` they go evenly along the order of the mesh,
  // else first come, first served.
  std::uint64_t quota = std::numeric_limits<std::uint64_t>::max();
  bool spread = true;
  // The pass's number, ascending from 1: by it the mesh remembers which flips need no second look.
  std::uint16_t number = 1;
};

// Runs passes and keeps their scratch memory. Not thread-safe; different objects are independent.
template <class Real>
class GreedyPass {
 public:
  // Takes the tetrahedra in order and fuses those that the limits allow, then compacts the mesh:
  // ids are stale afterwards, their order is kept. Carried columns follow. A pure function of the
  // mesh and the limits; what the mesh remembers of earlier passes (`changed`, `remembered`) saves
  // time and does not change the mesh that comes out. `log` may be null; each fusion is appended to
  // it.
  //
  // Preconditions: every vertex whose ball is not a topological ball of positively wound
  // tetrahedra, all of them in this mesh, is marked kOnBoundary, kLocked or kOnInterface (the
  // argument for the validity test needs it, see README.md); every steering value of an unmarked
  // vertex is finite.
  PassStatistics run(const PassLimits& limits, std::span<const SteeringField> fields,
                     WorkMesh<Real>* mesh, FusionLog* log = nullptr);

  // What the last pass did, by the ids from before it.
  std::span<const Fusion> fusions() const { return fusions_; }

 private:
  void begin();
  void prepare();
  bool checks_stretch() const;
  // What speaks against the tetrahedron before its surroundings are looked at.
  enum class FirstLook : std::uint8_t { kLabelled, kRejected, kCandidate };
  FirstLook look_at(TetId t, Reject* reason) const;
  bool known_to_flip(TetId t) const;
  // Plans the fusion of t into position_, affected_ and deleted_, or gives the reason against it.
  bool plan(TetId t, Reject* reason);
  bool collect_cavity(const Tet& prey);
  bool first_flips(const Tet& prey, VertexId v) const;
  bool walk_ball(const Tet& prey, std::size_t corner);
  std::span<const std::uint32_t> affected() const { return {affected_.data(), affected_count_}; }
  bool swallows_locked(const Tet& prey) const;
  bool shape_allows(Reject* reason) const;
  bool stretches_too_far(std::uint32_t entry, const std::array<Vec3<Real>, 4>& now,
                         const std::array<Vec3<Real>, 4>& after) const;
  void apply(const Tet& prey);
  void note_fusion(const Tet& prey, VertexId kept);
  void note(const Fusion& fusion);
  void compact();

  const PassLimits* limits_ = nullptr;
  std::span<const SteeringField> fields_;
  WorkMesh<Real>* mesh_ = nullptr;

  Vector<Fusion> fusions_;
  FusionNotes<Real> notes_;
  bool prepared_ = false;
  VertexTets balls_;  // of the start of the pass; stays right all through it, as fused vertices are
                      // not touched again

  Vector<std::uint8_t> state_;  // per vertex: what it is in this pass

  Vector<Vec3<Real>> start_positions_;  // of the last macroLoD, of use only with a stretch factor
  Vector<Tet> start_tets_;

  // The plan in hand.
  Vec3<Real> position_{};
  std::vector<double> mean_;    // steering tuple at the barycenter
  std::vector<TetId> deleted_;  // each once
  Vector<std::uint32_t>
      affected_;  // tet << 2 | corner of the prey vertex; the first affected_count_ count
  std::size_t affected_count_ = 0;
  Vector<std::uint32_t> shared_;  // the same of deleted tetrahedra, at each of their prey vertices
  std::size_t shared_count_ = 0;
};

extern template class GreedyPass<float>;
extern template class GreedyPass<double>;

}  // namespace tetfusion
