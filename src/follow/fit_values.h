// Values at the new points of a simplified mesh that come nearer to the original's than what the
// original has at their places.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "base/vector.h"
#include "follow/point_weights.h"

namespace tetfusion {

using TakeRows = std::function<void(std::uint64_t first, std::span<const double> rows)>;
// Calls take() for the rows of all of the original's points, window by window, each but the last of
// a multiple of PointWeights::kWindow points; as often as it is called itself.
using ReadRows = std::function<void(const TakeRows& take)>;

// `values` are `width` a point of the result, as interpolated; those of new points change, so that
// the squares of the errors at the original's points become smaller, and then, if `bound` is
// finite, so that no error (Euclidean) is larger than that share of the range, the diagonal of the
// box of the original's values. That cannot always be: whoever wants to know measures. No component
// leaves its range in the original (but where it has begun so). A linear field stays what it is, to
// rounding, and so does what is not finite.
//
// In memory are three times the values, and windows. The same for any number of threads; safe to
// call from several threads at once, for several steps.
void fit_values(const PointWeights& weights, std::size_t width, double bound,
                Vector<double>* values, const ReadRows& read);

}  // namespace tetfusion
