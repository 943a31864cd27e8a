// Sums whose error does not grow with the number of terms.
#pragma once

#include <cmath>

namespace tetfusion {

// Neumaier's variant of Kahan's summation (1974). The result depends on the order of the terms.
class CompensatedSum {
 public:
  void add(double x) {
    const double t = sum_ + x;
    compensation_ += std::abs(sum_) >= std::abs(x) ? (sum_ - t) + x : (x - t) + sum_;
    sum_ = t;
  }
  void add(const CompensatedSum& other) {
    add(other.sum_);
    compensation_ += other.compensation_;
  }
  double value() const { return sum_ + compensation_; }

 private:
  double sum_ = 0;
  double compensation_ = 0;
};

}  // namespace tetfusion
