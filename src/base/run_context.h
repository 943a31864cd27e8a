// What a long run needs from its caller: somewhere to report progress, and word when to stop.
#pragma once

#include <atomic>
#include <functional>
#include <string_view>

#include "base/error.h"

namespace tetfusion {

struct RunContext {
  // Called from the thread that runs the job: the phase's name and how much of the whole run is
  // done, 0..1.
  std::function<void(std::string_view phase, double share)> progress;
  // Called with sentences that the user should read: what was locked, what was left out.
  std::function<void(std::string_view message)> notice;
  const std::atomic<bool>* cancelled = nullptr;

  void report(std::string_view phase, double share) const {
    if (progress) progress(phase, share);
  }
  void say(std::string_view message) const {
    if (notice) notice(message);
  }
  // Throws Error(kInterrupted) when the caller has asked to stop.
  void check() const {
    if (cancelled != nullptr && cancelled->load(std::memory_order_relaxed)) {
      throw Error(ErrorCode::kInterrupted, "interrupted; what was not whole yet was not written");
    }
  }
};

}  // namespace tetfusion
