// The unit box, cut into cubes and those into tetrahedra, each computed from its number alone.
//
//   five   each cube in five: a regular one in the middle, four at the corners; neighbours are
//          mirrored
//   kuhn   each cube in six round its main diagonal
//   bcc    a point in the middle of each cube; the two middles on either side of a face and each of
//          its edges make a tetrahedron. On the surface, the pyramid over the face is split in two.
//          Twelve a cube.
//
// Why no tetrahedron is inverted, whatever the jitter and the grading. Let w be a tetrahedron's
// width, the least distance of two parallel planes that hold it between them. On the way to being
// inverted its corners lie in one plane, so they have been moved by at least w / 2, one of them.
// Widths in a cube of side 1: five and kuhn 1 / sqrt(3) (a corner tetrahedron; two skew edges of a
// Kuhn one), bcc 1 / 2. So a jitter below 0.288 of the side (five, kuhn) or 0.25 (bcc) is safe. In
// the halves of a surface pyramid only the apex moves, by less than a quarter, and it is half a
// side away from the surface.
//
// Grading makes boxes of the cubes, and jitter is measured, axis by axis, in the smallest of the
// boxes round the point. A box of five or kuhn is an affine image of the cube; taken back to the
// cube the displacements only shrink. A bcc tetrahedron spans two boxes, of depths h and rho h (rho
// >= 1), and is an affine image with a shear: taken back, the displacement along the axis is at
// most (1 - s) |z| + s |y|, with s = (rho - 1) / (rho + 1), which lengthens no displacement by more
// than sqrt(1 + s) (the larger eigenvalue of y^2 + ((1 - s) z + s y)^2 is at most 1 + s). The bcc
// bound is divided by that.
#pragma once

#include <array>
#include <cstdint>

#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

enum class LatticeKind { kFive, kKuhn, kBcc };

std::uint64_t tets_per_cube(LatticeKind kind);

using Index3 = std::array<std::uint64_t, 3>;  // along x, y, z

// Cubes along each axis of a nearly cubic lattice with about that many tetrahedra. `tets` is at
// most 2^48.
Index3 choose_cubes(LatticeKind kind, std::uint64_t tets);

inline constexpr double kMaxGrading = 1e4;

struct LatticeOptions {
  LatticeKind kind = LatticeKind::kFive;
  Index3 cubes{1, 1, 1};
  double jitter = 0;  // [0, 1): of the largest displacement that cannot invert; surface points stay
  double grading = 1;  // 1 to kMaxGrading: largest over smallest cube along each axis, in the limit
                       // of many cubes
  std::uint64_t seed = 0;
};

// Immutable, so thread-safe. Memory: a few numbers for each cube along an axis.
class Lattice {
 public:
  // Corners and winding are VTK's. Ids count the cubes' corners, x fastest, and after them the
  // middles.
  using Corners = std::array<std::uint64_t, 4>;

  // Throws Error(kUsage) for options out of range.
  explicit Lattice(const LatticeOptions& options);

  std::uint64_t points() const { return corners_ + middles_; }
  std::uint64_t tets() const { return cubes_ * per_cube_; }
  Vec3<double> position(std::uint64_t point) const;

  // Tetrahedron t lies in (bcc: at) cube t / per_cube().
  std::uint64_t per_cube() const { return per_cube_; }
  Index3 cube(std::uint64_t index) const { return unravel(index, options_.cubes); }
  Corners tet(const Index3& cube, std::uint64_t local) const;
  const LatticeOptions& options() const { return options_; }

  // Whether no tetrahedron can be inverted when each coordinate is moved by up to `error`, as
  // rounding does.
  bool survives_rounding(double error) const;

 private:
  // One axis, cubes of graded sizes.
  struct Axis {
    Vector<double> nodes;         // where the cubes' corners lie, 0 to 1
    Vector<double> corner_reach;  // smallest cube at each corner; 0 on the surface
    Vector<double> middle_reach;  // smallest of each cube and its neighbours
    double smallest = 1;          // cube
    double shear = 0;             // largest (rho - 1) / (rho + 1) of neighbours
  };

  static Axis make_axis(std::uint64_t cubes, double feature, double grading);
  static Index3 unravel(std::uint64_t index, const Index3& size);
  std::uint64_t corner(const Index3& at) const;
  std::uint64_t middle(const Index3& at) const;
  Corners bcc_tet(const Index3& cube, std::uint64_t local) const;
  Vec3<double> displacement(std::uint64_t point) const;

  LatticeOptions options_;
  Index3 corner_size_;  // corners along each axis
  std::uint64_t cubes_, corners_, middles_, per_cube_;
  std::array<Axis, 3> axes_;
  double reach_;  // largest safe displacement, in cubes
};

}  // namespace tetfusion
