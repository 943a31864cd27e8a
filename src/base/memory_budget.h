// Bytes reserved before they are used, so that a process stays within the memory it was given.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string_view>

namespace tetfusion {

// Counts, and does not allocate. All functions may be called from any thread.
//
// Two kinds of reservation share the budget: those of reserve() stay as far as anybody else knows,
// those of wait_for() come back by themselves, and others wait for that. So a thread that holds one
// of wait_for() must not wait for another: two such threads would wait for each other.
class MemoryBudget {
 public:
  // Gives its bytes back when it goes. Must not outlive the budget. A moved-from or
  // default-constructed one holds nothing. One object is not for several threads at once.
  class Reservation {
   public:
    Reservation() = default;
    ~Reservation() { release(); }
    Reservation(Reservation&& other) noexcept;
    Reservation& operator=(Reservation&& other) noexcept;

    std::uint64_t bytes() const { return bytes_; }
    void release() noexcept;

   private:
    friend class MemoryBudget;
    Reservation(MemoryBudget* budget, std::uint64_t bytes, bool passing)
        : budget_(budget), bytes_(bytes), passing_(passing) {}

    MemoryBudget* budget_ = nullptr;
    std::uint64_t bytes_ = 0;
    bool passing_ = false;  // of wait_for()
  };

  explicit MemoryBudget(std::uint64_t total) : total_(total) {}
  MemoryBudget(const MemoryBudget&) = delete;
  MemoryBudget& operator=(const MemoryBudget&) = delete;

  // Never waits. Throws Error(kMemory) when the bytes are not free; the message says for `what`, as
  // in "the table of chunks", how much is needed in all, and what to do.
  Reservation reserve(std::uint64_t bytes, std::string_view what);

  // Waits until the bytes are free. Who comes first is served first: a large request is not passed
  // by small ones. Throws Error(kMemory) when the bytes would not be free even if all reservations
  // of this kind were back.
  Reservation wait_for(std::uint64_t bytes, std::string_view what);

  std::uint64_t total() const { return total_; }
  std::uint64_t used() const;
  std::uint64_t free() const;
  std::uint64_t peak() const;  // the most that was reserved at once

 private:
  std::uint64_t used_locked() const { return staying_ + passing_; }
  void add_locked(std::uint64_t bytes, bool passing);
  [[noreturn]] void refuse(std::uint64_t bytes, std::uint64_t beside, std::string_view what) const;

  const std::uint64_t total_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t staying_ = 0;
  std::uint64_t passing_ = 0;
  std::uint64_t peak_ = 0;
  std::uint64_t next_ticket_ = 0;
  std::deque<std::uint64_t> queue_;  // tickets of those who wait, in order of arrival
};

}  // namespace tetfusion
