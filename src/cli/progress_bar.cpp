#include "cli/progress_bar.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <system_error>

#include "base/resources.h"

namespace tetfusion {

namespace {

constexpr std::chrono::milliseconds kBetweenDraws{100};
constexpr std::size_t kMostBarWidth = 30;
constexpr double kLeastRate = 5000;  // tetrahedra a second: 0.01 M, when it is rounded
constexpr std::string_view kErase = "\r\x1b[K";

// A terminal that does not know its width says 0.
std::size_t terminal_columns() {
  winsize size{};
  const bool known = ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : 80;
}

std::string clock_text(double seconds) {
  const auto s = static_cast<std::uint64_t>(std::ceil(seconds));
  if (s < 3600) return fmt::format("{}:{:02}", s / 60, s % 60);
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

// Signals are for the thread that runs the job: a read of its that waits for a pipe must end.
class SignalsBlocked {
 public:
  SignalsBlocked() {
    sigset_t all;
    sigfillset(&all);
    ::pthread_sigmask(SIG_BLOCK, &all, &before_);
  }
  ~SignalsBlocked() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  SignalsBlocked(const SignalsBlocked&) = delete;
  SignalsBlocked& operator=(const SignalsBlocked&) = delete;

 private:
  sigset_t before_{};
};

}  // namespace

void put_on_stderr(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

void put_message(std::string_view message) {
  std::string text(message);
  std::ranges::replace_if(
      text, [](char c) { return (static_cast<unsigned char>(c) < 0x20 && c != '\n') || c == 0x7F; },
      '?');
  put_on_stderr(text + "\n");
}

ProgressBar::ProgressBar(Style style, const std::atomic<bool>& stopping)
    : style_(style), stopping_(stopping), estimate_(wall_seconds()) {
  if (style_ != Style::kBar) return;
  const SignalsBlocked blocked;  // a new thread inherits that
  try {
    drawer_ = std::thread(&ProgressBar::redraw_until_stopped, this);
  } catch (const std::system_error&) {
    // No thread to be had: then there is no bar.
  }
}

ProgressBar::~ProgressBar() {
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
    begun_or_over_.notify_all();
  }
  if (drawer_.joinable()) drawer_.join();
  erase_locked();
}

void ProgressBar::report(std::string_view phase, double share) {
  if (style_ == Style::kNone) return;
  const std::lock_guard lock(mutex_);
  // A job that is part of another one ends in the middle of that.
  const bool ends = phase == "done" && share < 1;
  if (!ends && phase_ != phase) phase_ = phase;
  estimate_.update(share, wall_seconds());
  if (style_ == Style::kLines) print_tenth_locked();
  if (!begun_) begun_or_over_.notify_all();
  begun_ = true;
}

void ProgressBar::set_tets(std::uint64_t tets) {
  const std::lock_guard lock(mutex_);
  tets_ = tets;
}

void ProgressBar::print_line(std::string_view text) {
  const std::lock_guard lock(mutex_);
  erase_locked();
  put_message(text);
}

void ProgressBar::redraw_until_stopped() {
  std::unique_lock lock(mutex_);
  begun_or_over_.wait(lock, [&] { return begun_ || over_; });
  // A run that is over before this thread has begun shows its bar once: a flash, but never a lie.
  if (begun_) draw_locked();
  while (!begun_or_over_.wait_for(lock, kBetweenDraws, [&] { return over_; })) draw_locked();
}

// Rate and time left, as far as they are known, each led by two spaces.
std::string ProgressBar::figures_locked() {
  const double now = wall_seconds();
  const auto left = estimate_.seconds_left(now);
  const auto rate = tets_ > 0 ? estimate_.rate(tets_, now) : std::nullopt;
  std::string text;
  if (rate && *rate >= kLeastRate) text += fmt::format("  {:.2f} M tets/s", *rate / 1e6);
  if (left) text += fmt::format("  {} left", clock_text(*left));
  return text;
}

void ProgressBar::draw_locked() {
  const double share = estimate_.share();
  const std::string_view phase = stopping_.load() ? std::string_view("stopping") : phase_;
  std::string text =
      fmt::format("{:3.0f} % {:<10}{}", std::floor(100 * share), phase, figures_locked());
  // Not a column more than the line has: it would wrap, and could not be erased.
  const std::size_t columns = terminal_columns() - 1;
  const std::size_t room = columns > text.size() + 3 ? columns - text.size() - 3 : 0;
  const std::size_t width = std::min(room, kMostBarWidth);
  if (width > 0) {
    const auto filled = static_cast<std::size_t>(share * static_cast<double>(width));
    text =
        fmt::format("[{}{}] {}", std::string(filled, '='), std::string(width - filled, ' '), text);
  }
  text.resize(std::min(text.size(), columns));
  put_on_stderr(std::string(kErase) + text);
  drawn_ = true;
}

void ProgressBar::erase_locked() {
  if (drawn_) put_on_stderr(kErase);
  drawn_ = false;
}

// A line for each tenth that is reached, and for each phase when it first comes.
void ProgressBar::print_tenth_locked() {
  const int tenth = static_cast<int>(10 * estimate_.share());
  const bool is_new = phases_printed_.find(phase_) == phases_printed_.end();
  if (tenth <= tenths_printed_ && !is_new) return;
  tenths_printed_ = std::max(tenth, tenths_printed_);
  phases_printed_.insert(phase_);
  put_on_stderr(fmt::format("{:3.0f} % {}{}\n", std::floor(100 * estimate_.share()), phase_,
                            figures_locked()));
}

}  // namespace tetfusion
