#include "kernel/position_wish.h"

namespace tetfusion {

namespace {

// Directions in which little is known hold the vertex back by this share of what all together say.
constexpr double kHoldBack = 0.002;

std::array<double, 6> products(const Point3& a) {
  const auto& [x, y, z] = a;
  return {x * x, x * y, x * z, y * y, y * z, z * z};
}

// The solution of a symmetric system: xx, xy, xz, yy, yz, zz.
Point3 solve(const std::array<double, 6>& m, const Point3& b) {
  const auto& [xx, xy, xz, yy, yz, zz] = m;
  const double cxx = yy * zz - yz * yz, cxy = xz * yz - xy * zz, cxz = xy * yz - xz * yy;
  const double cyy = xx * zz - xz * xz, cyz = xy * xz - xx * yz, czz = xx * yy - xy * xy;
  const double det = xx * cxx + xy * cxy + xz * cxz;
  return {(cxx * b[0] + cxy * b[1] + cxz * b[2]) / det,
          (cxy * b[0] + cyy * b[1] + cyz * b[2]) / det,
          (cxz * b[0] + cyz * b[1] + czz * b[2]) / det};
}

}  // namespace

// The error changes by -weight for each unit of the value, and by weight times the gradient for a
// step.
void PositionWish::Component::add(double weight, double error, const Point3& gradient) {
  const double square = weight * weight;
  value_ += square;
  value_error_ += weight * error;
  squares_ += error * error;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    mixed_[axis] -= square * gradient[axis];
    place_error_[axis] -= weight * error * gradient[axis];
  }
  const std::array<double, 6> p = products(gradient);
  for (std::size_t j = 0; j < 6; ++j) place_[j] += square * p[j];
}

// The value's own best follows from the step: what is left is the system without it.
void PositionWish::add(const Component& c, double scale) {
  if (!(c.value_ > 0)) return;
  const std::array<double, 6> p = products(c.mixed_);
  for (std::size_t j = 0; j < 6; ++j) place_[j] += scale * (c.place_[j] - p[j] / c.value_);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    error_[axis] += scale * (c.place_error_[axis] - c.mixed_[axis] * (c.value_error_ / c.value_));
  }
  stiffness_ += scale * (c.place_[0] + c.place_[3] + c.place_[5]);
  squares_ += scale * c.squares_;
}

Point3 PositionWish::step(double worthwhile) const {
  std::array<double, 6> system = place_;
  for (const std::size_t diagonal : {0, 3, 5}) system[diagonal] += kHoldBack * stiffness_;
  const Point3 step = solve(system, error_);
  return dot(step, error_) >= worthwhile * squares_ ? step : Point3{};
}

}  // namespace tetfusion
