// How far a run is, and how long it will go on: what a progress bar shows.
#pragma once

#include <cstdint>
#include <optional>

namespace tetfusion {

// Fed with the shares that RunContext::progress gets and a clock in seconds, of any start. Not
// thread safe.
class ProgressEstimate {
 public:
  explicit ProgressEstimate(double start) : start_(start), smoothed_at_(start) {}

  // Never falls: a share below an earlier one changes nothing.
  void update(double share, double now);
  double share() const { return share_; }  // 0..1

  // As if all that is left went at the mean pace so far, smoothed over a few seconds. Nothing
  // before the run has gone on long enough, and far enough, to say; nor when it is done. Call it
  // with times that do not fall.
  std::optional<double> seconds_left(double now);

  // Tetrahedra a second over the whole run so far, of so many in all. Nothing when seconds_left()
  // would say nothing.
  std::optional<double> rate(std::uint64_t tets, double now) const;

 private:
  bool can_say(double now) const;
  double done_here() const { return share_ - before_; }

  double start_;
  bool begun_ = false;
  double before_ = 0;  // done by an earlier run, which this one resumes
  double share_ = 0;
  double smoothed_at_;
  std::optional<double> smoothed_end_;
};

}  // namespace tetfusion
