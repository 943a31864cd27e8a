// How bad the shapes of new tetrahedra may be: no worse than a floor; and where the input's are
// below it, no worse than those are but for a twentieth, however often something fuses there.
//
// Layers of equal flat cells would be frozen without the twentieth: when a vertex comes to the
// layer above, the cells beside it keep their volumes, and their edges get longer by a hair.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace tetfusion {

// In steps of a 24th of an octave of mean ratios. Grade 0 is the floor's, each one after it a step
// below; the last one stands for all that is worse: no shape is too bad for it. Not changed by
// anything but assignment.
class ShapeGrades {
 public:
  static constexpr std::size_t kCount = 256;

  // A mean ratio in [0, 1).
  explicit ShapeGrades(double floor = 0);

  // No shape of that grade has a lower cubed mean ratio.
  double least(std::uint8_t grade) const { return least_[grade]; }
  double floor() const { return least_[0]; }
  // Of a tetrahedron with that cubed mean ratio: 0 if that is not below the floor, else the first
  // grade that allows a mean ratio of 0.978 of its own; none allows less than 0.95 of it, but the
  // last.
  std::uint8_t grade_of(double cubed_mean_ratio) const;

 private:
  std::array<double, kCount> least_{};  // descending
};

}  // namespace tetfusion
