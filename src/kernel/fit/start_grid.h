// Where to begin looking for the tetrahedron that has a point.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "base/vector.h"
#include "mesh/predicates.h"
#include "mesh/work_mesh.h"

namespace tetfusion {

// A tetrahedron near each place: one for each cell of a grid over the mesh, in which a cell has
// kTetsPerCell on average. Keeps its memory.
template <class Real>
class StartGrid {
 public:
  // A function of the mesh, which has tetrahedra.
  void begin(const WorkMesh<Real>& mesh) {
    const double cells = static_cast<double>(mesh.tets.size()) / kTetsPerCell;
    size_ = static_cast<std::size_t>(std::clamp(std::cbrt(cells), 1.0, kMostAlongAxis));
    place(mesh);
    start_of_.assign(size_ * size_ * size_, kNoTet);
    for (TetId t = 0; t < mesh.tets.size(); ++t) {
      TetId& start = start_of_[cell_of(mesh.positions[mesh.tets[t][0]])];
      if (start == kNoTet && determinant(mesh.positions, mesh.tets[t]).sign() > 0) start = t;
    }
    for (std::size_t stride = 1; stride < start_of_.size(); stride *= size_) fill_along(stride);
  }

  // One with volume, in the point's cell or, where that has none, in one beside it or further away;
  // kNoTet: there is none.
  TetId near(const Vec3<double>& point) const { return start_of_[cell_of(point)]; }
  // Calls use(tet) with the same of the cells round the point's, as long as that gives false; gives
  // whether it did not.
  template <class Use>
  bool any_around(const Vec3<double>& point, Use use) const {
    const std::size_t cell = cell_of(point);
    const std::array<std::size_t, 3> at{cell % size_, cell / size_ % size_, cell / size_ / size_};
    const auto first = [&](std::size_t a) { return at[a] - (at[a] > 0 ? 1 : 0); };
    const auto end = [&](std::size_t a) { return std::min(at[a] + 2, size_); };
    for (std::size_t z = first(2); z < end(2); ++z) {
      for (std::size_t y = first(1); y < end(1); ++y) {
        for (std::size_t x = first(0); x < end(0); ++x) {
          if (use(start_of_[(z * size_ + y) * size_ + x])) return true;
        }
      }
    }
    return false;
  }

  static constexpr std::uint64_t memory(std::uint64_t tets) {
    return tets / kTetsPerCell * sizeof(TetId) + sizeof(TetId);
  }

 private:
  static constexpr std::uint64_t kTetsPerCell = 2;
  static constexpr double kMostAlongAxis = 64;

  void place(const WorkMesh<Real>& mesh) {
    std::array<double, 3> hi = axes(mesh.positions[0]);
    lo_ = hi;
    for (const Vec3<Real>& p : mesh.positions) {
      const std::array<double, 3> x = axes(p);
      for (std::size_t a = 0; a < 3; ++a) {
        lo_[a] = std::min(lo_[a], x[a]);
        hi[a] = std::max(hi[a], x[a]);
      }
    }
    for (std::size_t a = 0; a < 3; ++a) {
      scale_[a] = hi[a] > lo_[a] ? static_cast<double>(size_) / (hi[a] - lo_[a]) : 0;
    }
  }

  template <class T>
  static std::array<double, 3> axes(const Vec3<T>& p) {
    return {p.x, p.y, p.z};
  }

  template <class T>
  std::size_t cell_of(const Vec3<T>& p) const {
    const std::array<double, 3> at = axes(p);
    const double last = static_cast<double>(size_ - 1);
    std::size_t cell = 0;
    for (std::size_t a = 3; a-- > 0;) {
      const double x = (at[a] - lo_[a]) * scale_[a];
      cell = cell * size_ + (x > 0 ? static_cast<std::size_t>(std::min(x, last)) : 0);
    }
    return cell;
  }

  // Along one axis, cells without a start take that of the one before, or behind.
  void fill_along(std::size_t stride) {
    const std::size_t n = start_of_.size();
    const auto has_before = [&](std::size_t c) { return c / stride % size_ != 0; };
    for (std::size_t c = 0; c < n; ++c) {
      if (start_of_[c] == kNoTet && has_before(c)) start_of_[c] = start_of_[c - stride];
    }
    for (std::size_t c = n; c-- > 0;) {
      if (has_before(c) && start_of_[c - stride] == kNoTet) start_of_[c - stride] = start_of_[c];
    }
  }

  std::size_t size_ = 1;  // cells along an axis
  std::array<double, 3> lo_{}, scale_{};
  Vector<TetId> start_of_;
};

}  // namespace tetfusion
