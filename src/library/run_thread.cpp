#include "library/run_thread.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/resources.h"
#include "library/requests.h"

namespace tetfusion {

namespace {

constexpr std::chrono::milliseconds kPoll{30};

struct Batch {
  std::vector<std::string> sentences;
  double share = 0;
  std::string phase;
  bool has_moved = false;
  bool has_ended = false;
};

// What the job has to say, on its way to the caller's thread.
class News {
 public:
  void report(std::string_view phase, double share) {
    const std::lock_guard lock(mutex_);
    if (share <= highest_) return;
    highest_ = next_.share = share;
    next_.phase = phase;
    next_.has_moved = true;
    changed_.notify_one();
  }
  void say(std::string_view sentence) {
    const std::lock_guard lock(mutex_);
    next_.sentences.emplace_back(sentence);
    changed_.notify_one();
  }
  void end() {
    const std::lock_guard lock(mutex_);
    next_.has_ended = true;
    changed_.notify_one();
  }

  // Waits for something new, but no longer than a moment.
  Batch take() {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, kPoll, [&] {
      return next_.has_moved || next_.has_ended || !next_.sentences.empty();
    });
    return std::exchange(next_, {});
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  Batch next_;
  double highest_ = -1;
};

// Calls the observer, and keeps what it throws, so that the job can be ended first.
class Watch {
 public:
  explicit Watch(const Observer& observer) : observer_(observer) {}

  void pass_on(const Batch& batch) {
    guarded([&] {
      for (const std::string& s : batch.sentences) {
        if (observer_.notice) observer_.notice(in_words_of_library(s));
      }
      if (batch.has_moved && observer_.progress) observer_.progress(batch.share, batch.phase);
    });
  }
  bool wants_end() {
    guarded([&] { ends_ = ends_ || (observer_.cancelled && observer_.cancelled()); });
    return ends_;
  }
  void check() const {
    if (failed_) throw Error(ErrorCode::kInterrupted, "the observer threw: " + what_);
  }

 private:
  template <class F>
  void guarded(F f) {
    if (failed_) return;
    try {
      f();
    } catch (const std::exception& e) {
      fail(e.what());
    } catch (...) {
      fail("something that is no std::exception");
    }
  }
  void fail(const char* what) noexcept {
    failed_ = ends_ = true;
    try {
      what_ = what;
    } catch (...) {  // no memory: then without it
    }
  }

  const Observer& observer_;
  bool ends_ = false;
  bool failed_ = false;
  std::string what_;
};

std::atomic<int> runs_going_on{0};
thread_local bool is_in_run = false;

// While this thread waits for a job and calls its observer.
struct InRun {
  InRun() {
    is_in_run = true;
    ++runs_going_on;
  }
  ~InRun() {
    is_in_run = false;
    --runs_going_on;
  }
  InRun(const InRun&) = delete;
  InRun& operator=(const InRun&) = delete;
};

}  // namespace

int runs_of_process() { return runs_going_on; }

void run_observed(const Observer& observer, const std::function<void(const RunContext&)>& job) {
  if (is_in_run) {
    throw Error(ErrorCode::kUsage, "a run cannot be begun by the observer of another one");
  }
  Watch watch(observer);
  const InRun here;
  News news;
  std::atomic<bool> cancelled{false};
  RunContext context;
  context.progress = [&](std::string_view phase, double share) { news.report(phase, share); };
  context.notice = [&](std::string_view sentence) { news.say(sentence); };
  context.cancelled = &cancelled;
  std::exception_ptr failure;
  std::thread thread([&] {
    const OwnThreadCount own;
    try {
      job(context);
    } catch (...) {
      failure = std::current_exception();
    }
    news.end();
  });
  for (bool goes_on = true; goes_on;) {
    const Batch batch = news.take();
    watch.pass_on(batch);
    if (watch.wants_end()) cancelled = true;
    goes_on = !batch.has_ended;
  }
  thread.join();
  watch.check();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace tetfusion
