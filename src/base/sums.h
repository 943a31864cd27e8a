// Sums whose error does not grow with the number of terms.
#pragma once

namespace tetfusion {

// Neumaier's variant of Kahan's summation (1974), with Knuth's way to find what rounding takes from
// an addition, which needs not know the larger term. The result depends on the order of the terms.
class CompensatedSum {
 public:
  CompensatedSum() = default;
  // Of somebody who has done the same elsewhere.
  CompensatedSum(double sum, double compensation) : sum_(sum), compensation_(compensation) {}

  void add(double x) {
    const double t = sum_ + x;
    const double added = t - sum_;
    compensation_ += (sum_ - (t - added)) + (x - added);
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
