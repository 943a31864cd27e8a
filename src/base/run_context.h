// What a long run needs from its caller: somewhere to report progress, and word when to stop.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>

#include "base/error.h"

namespace tetfusion {

// Workers report, too: the functions are called from any thread of the job, also from several at
// once, and have to stand that. They should be quick, and must not throw.
struct RunContext {
  // The phase's name and how much of the whole run is done, 0..1; from several threads shares may
  // come a little out of order. A run that goes on where an earlier one stopped begins with the
  // share that was done then.
  std::function<void(std::string_view phase, double share)> progress;
  // Called when the number of tetrahedra of the input is known, at times twice: for a rate.
  std::function<void(std::uint64_t tets)> size;
  // Called with sentences that the user should read: what was locked, what was left out.
  std::function<void(std::string_view message)> notice;
  const std::atomic<bool>* cancelled = nullptr;
  // Set where other work of the same run has failed, so that nobody needs what this one makes.
  const std::atomic<bool>* abandoned = nullptr;

  void report(std::string_view phase, double share) const {
    if (progress) progress(phase, share);
  }
  // The same for part `done` of `all` equal parts of a phase that goes from share `from` to `to`.
  void report(std::string_view phase, double from, double to, std::size_t done,
              std::size_t all) const {
    report(phase, from + (to - from) * static_cast<double>(done) / static_cast<double>(all));
  }
  // For a part of the run that goes from share `from` to `to`: what it reports is 0..1 again.
  RunContext part(double from, double to) const {
    RunContext context = *this;
    context.progress = [whole = progress, from, to](std::string_view phase, double share) {
      if (whole) whole(phase, from + (to - from) * share);
    };
    return context;
  }
  void report_size(std::uint64_t tets) const {
    if (size) size(tets);
  }
  void say(std::string_view message) const {
    if (notice) notice(message);
  }
  bool is_cancelled() const {
    return cancelled != nullptr && cancelled->load(std::memory_order_relaxed);
  }
  // Throws Error(kInterrupted) when the caller has asked to stop, Abandoned when it is in vain.
  void check() const {
    if (abandoned != nullptr && abandoned->load(std::memory_order_relaxed)) throw Abandoned();
    if (is_cancelled()) {
      throw Error(ErrorCode::kInterrupted, "interrupted; what was not whole yet was not written");
    }
  }
};

}  // namespace tetfusion
