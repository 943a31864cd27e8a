// What has to be held, and how strictly, so that each step is within its bound: one
// simplification after the other (README.md, "The bound").
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "series/combined_fields.h"

namespace tetfusion {

class BoundSearch {
 public:
  BoundSearch(bool has_goal, std::size_t steps);

  // What the next simplification is to steer by, and how much of the steps' bound its sums may use.
  const CombinedFields::Settings& sums() const { return sums_; }
  double share() const { return share_; }

  enum class Next : std::uint8_t {
    kDone,       // the last one is good enough
    kAgain,      // with another share
    kOtherSums,  // with other sums, too
  };
  // How much of its bound a step has used at its worst: 1 is all of it, 0 that nothing is bounded;
  // and what that is, as a sentence.
  struct Worst {
    double used = 0;
    std::string what = {};
  };
  // After the simplification number `tries`, counted from 1 with those that had no bound; of each
  // step. Says why there is to be another one. Throws Error(kBroken) where there have been too
  // many.
  Next after(int tries, const std::vector<Worst>& steps, bool goal_was_reached,
             const RunContext& context);

 private:
  Next tighten(int tries, const std::vector<Worst>& steps, const Worst& worst,
               const RunContext& context);
  bool add_alone(const std::vector<Worst>& steps);

  const std::size_t steps_;
  CombinedFields::Settings sums_;
  double share_;
  bool was_too_much_ = false;
  int loosened_ = 0;  // so many times
};

}  // namespace tetfusion
