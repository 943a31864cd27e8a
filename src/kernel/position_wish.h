// Where a vertex would best be, by the errors at the points round it.
#pragma once

#include <array>
#include <cstddef>

#include "kernel/point3.h"

namespace tetfusion {

// A step of Gauss and Newton: errors as linear functions of the vertex's value and place. The field
// of a tetrahedron comes along when a corner moves, so only places where gradients differ pull.
class PositionWish {
 public:
  // Of one component of the fields: what the value and the place do to the errors.
  class Component {
   public:
    // A point that has this error (what it should have less what it has), in a tetrahedron in which
    // the vertex has that weight and the component that gradient.
    void add(double weight, double error, const Point3& gradient);

   private:
    friend class PositionWish;
    double value_ = 0;               // squared weights
    Point3 mixed_{};                 // these times the gradient
    std::array<double, 6> place_{};  // and times its square: xx, xy, xz, yy, yz, zz
    double value_error_ = 0;         // weights times errors
    Point3 place_error_{};           // these times the gradient
    double squares_ = 0;             // of errors
  };

  // Its squared errors count so many times.
  void add(const Component& component, double scale);
  // None where it would not take that share of the squares away.
  Point3 step(double worthwhile) const;
  // Of the errors, as scaled.
  double squares() const { return squares_; }

 private:
  std::array<double, 6> place_{};
  Point3 error_{};
  double stiffness_ = 0, squares_ = 0;
};

}  // namespace tetfusion
