// Where a macroLoD is cut into chunks: pieces of a Hilbert curve that hold about the same number of
// tetrahedra. Each round shifts the curve, so that what lay on an interface lies inside a chunk the
// next time.
#pragma once

#include <cstdint>
#include <span>

#include "base/vector.h"
#include "mesh/geometry.h"

namespace tetfusion {

// The bounding box of finite points. Adding nothing leaves it empty.
struct Box {
  Box();
  void add(const Vec3<double>& p);  // ignores points that are not finite
  void add(const Box& other);
  Vec3<double> lo;
  Vec3<double> hi;
};

// Where cuts are made: beyond 64 times the width of nearly all samples the box has nothing, as a
// point far away would leave the curve one cell for all others.
template <class Real>
Box without_outliers(const Box& box, std::span<const Vec3<Real>> samples);

// The curve through a cube of twice the box's extent, in which the box's place depends on the
// round. Points outside the box are taken as on its surface.
class ShiftedCurve {
 public:
  ShiftedCurve(const Box& box, std::uint32_t round);

  template <class Real>
  std::uint64_t key(const Vec3<Real>& p) const;

 private:
  std::uint32_t cell(double value, double low, double shift) const;

  Vec3<double> lo_{};
  double scale_ = 1;
  Vec3<double> shift_{};
};

// Chunks are numbered along the curve. A tetrahedron belongs to the lowest of its vertices' chunks:
// of the vertices near a cut only those on one side then lie on the interface.
class CurveCut {
 public:
  CurveCut() = default;  // one chunk

  // Cuts so that each of `chunks` > 0 chunks holds as many samples as the others. The samples are
  // keys on the curve, in any order. Chunks may turn out empty where points coincide.
  CurveCut(const ShiftedCurve& curve, std::uint32_t chunks, Vector<std::uint64_t> samples);

  // The same as a cut that has these; they ascend.
  CurveCut(const ShiftedCurve& curve, Vector<std::uint64_t> first_keys);
  const ShiftedCurve& curve() const { return curve_; }
  const Vector<std::uint64_t>& first_keys() const { return first_keys_; }

  std::uint32_t chunks() const { return static_cast<std::uint32_t>(first_keys_.size()) + 1; }

  template <class Real>
  std::uint32_t chunk_of(const Vec3<Real>& p) const {
    return first_keys_.empty() ? 0 : chunk_of_key(curve_.key(p));
  }
  // Of a place on the curve.
  std::uint32_t chunk_of_key(std::uint64_t key) const;

 private:
  static constexpr int kTableBits = 12;

  ShiftedCurve curve_{Box(), 0};
  Vector<std::uint64_t> first_keys_;  // of every chunk but the first, ascending
  // The chunk in which each 2^-kTableBits of the curve begins; one entry more.
  Vector<std::uint32_t> table_;
};

// So many samples a chunk make the sizes of chunks vary by a few percent.
inline constexpr std::uint64_t kSamplesPerChunk = 512;

}  // namespace tetfusion
