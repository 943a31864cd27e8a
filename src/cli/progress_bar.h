// One line on standard error over a whole run: a bar on a terminal, a line for each tenth
// elsewhere.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <thread>

#include "base/progress.h"

namespace tetfusion {

// Writes to standard error; what cannot be written is lost, and no reason to end a job.
void put_on_stderr(std::string_view text);
// A message and the end of its last line. Control characters, which are words of a file or of a
// name, become question marks: a terminal would obey them.
void put_message(std::string_view message);

// All functions may be called from any thread, several at once.
class ProgressBar {
 public:
  enum class Style : std::uint8_t { kNone, kLines, kBar };

  // `stopping`, when it is set, is shown instead of the phase. It must outlive the bar.
  ProgressBar(Style style, const std::atomic<bool>& stopping);
  ~ProgressBar();  // leaves nothing behind on the line
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void report(std::string_view phase, double share);
  void set_tets(std::uint64_t tets);
  // Writes a line where the bar is; the bar comes back below.
  void print_line(std::string_view text);

 private:
  void redraw_until_stopped();
  void draw_locked();
  void erase_locked();
  void print_tenth_locked();
  std::string figures_locked();

  const Style style_;
  const std::atomic<bool>& stopping_;
  std::mutex mutex_;
  std::condition_variable begun_or_over_;
  std::string phase_;
  std::uint64_t tets_ = 0;
  ProgressEstimate estimate_;
  bool begun_ = false;
  bool over_ = false;
  bool drawn_ = false;
  int tenths_printed_ = -1;
  std::set<std::string, std::less<>> phases_printed_;
  // A thread of its own draws, so that a report costs the workers nothing and the time goes on in
  // long steps too.
  std::thread drawer_;
};

}  // namespace tetfusion
