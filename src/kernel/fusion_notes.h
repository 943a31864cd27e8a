// Notes what a fusion is about to do to a mesh, for a log from which it can be undone.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mesh/fusion_log.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// Keeps its memory. Not thread-safe.
template <class Real>
class FusionNotes {
 public:
  // A tetrahedron that the kept vertex will have.
  struct StarTet {
    TetId tet;
    std::uint8_t corner;  // where the kept vertex will be
    std::uint8_t whose;   // 0: its already; i: that of gone[i - 1]
  };

  // Null: nothing is noted. The mesh and the log outlive this; the last cell column holds the
  // tetrahedra's numbers in the input.
  void begin(const WorkMesh<Real>* mesh, FusionLog* log);
  bool are_wanted() const { return log_ != nullptr; }

  // To be called before the mesh changes, and after the fusion of `gone` into `kept`, when rows of
  // points are what they will be, with what is known of the error (FusionRecord). `star` is sorted
  // here; at most kMaxGone are gone.
  void before(VertexId kept, std::span<const VertexId> gone, std::span<const TetId> deleted);
  std::vector<StarTet>& star() { return star_; }
  void after(float error);

 private:
  void find_swallowed();
  CornerCode code_of(VertexId v);

  const WorkMesh<Real>* mesh_ = nullptr;
  FusionLog* log_ = nullptr;
  std::size_t row_bytes_ = 0, tet_row_bytes_ = 0;
  VertexId kept_ = 0;
  std::uint32_t gone_ = 0;
  std::vector<StarTet> star_;
  std::vector<VertexId> back_;  // that go with this fusion; those that are fused first
  std::vector<TetId> deleted_;
  Vector<std::uint32_t> stamp_, code_;  // of a vertex that has a code now
  std::uint32_t stamped_ = 0;
  std::uint32_t codes_ = 0;

  // The record.
  std::vector<VertexId> points_, elsewhere_;
  std::vector<TetId> tets_;
  std::vector<std::uint8_t> whose_;
  std::vector<std::array<CornerCode, 4>> corners_;
  std::vector<std::byte> rows_, tet_rows_, kept_row_;
};

extern template class FusionNotes<float>;
extern template class FusionNotes<double>;

}  // namespace tetfusion
