#include "base/memory_budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "base/numbers.h"
#include "base/reservation_seam.h"

namespace tetfusion {

MemoryBudget::Reservation::Reservation(Reservation&& other) noexcept
    : budget_(std::exchange(other.budget_, nullptr)),
      bytes_(std::exchange(other.bytes_, 0)),
      passing_(other.passing_) {}

MemoryBudget::Reservation& MemoryBudget::Reservation::operator=(Reservation&& other) noexcept {
  if (this == &other) return *this;
  release();
  budget_ = std::exchange(other.budget_, nullptr);
  bytes_ = std::exchange(other.bytes_, 0);
  passing_ = other.passing_;
  return *this;
}

void MemoryBudget::Reservation::release() noexcept {
  if (budget_ == nullptr) return;
  {
    const std::lock_guard lock(budget_->mutex_);
    (passing_ ? budget_->passing_ : budget_->staying_) -= bytes_;
    // Under the lock: once it is open the budget may be gone.
    budget_->changed_.notify_all();
  }
  budget_ = nullptr;
  bytes_ = 0;
}

MemoryBudget::Reservation MemoryBudget::reserve(std::uint64_t bytes, std::string_view what) {
  const std::lock_guard lock(mutex_);
  if (bytes > total_ - used_locked() || reservation_seam().refuses()) {
    refuse(bytes, used_locked(), what);
  }
  add_locked(bytes, false);
  changed_.notify_all();  // what stays may have become too much for somebody who waits
  return Reservation(this, bytes, false);
}

MemoryBudget::Reservation MemoryBudget::wait_for(std::uint64_t bytes, std::string_view what) {
  std::unique_lock lock(mutex_);
  if (reservation_seam().refuses()) refuse(bytes, staying_, what);
  const std::uint64_t ticket = next_ticket_++;
  queue_.push_back(ticket);
  const auto leave = [&] {
    std::erase(queue_, ticket);
    changed_.notify_all();
  };
  while (true) {
    if (bytes > total_ - staying_) {
      leave();
      refuse(bytes, staying_, what);
    }
    if (queue_.front() == ticket && bytes <= total_ - used_locked()) break;
    changed_.wait(lock);
  }
  leave();
  add_locked(bytes, true);
  return Reservation(this, bytes, true);
}

std::uint64_t MemoryBudget::used() const {
  const std::lock_guard lock(mutex_);
  return used_locked();
}

std::uint64_t MemoryBudget::free() const { return total_ - used(); }

std::uint64_t MemoryBudget::peak() const {
  const std::lock_guard lock(mutex_);
  return peak_;
}

void MemoryBudget::add_locked(std::uint64_t bytes, bool passing) {
  (passing ? passing_ : staying_) += bytes;
  peak_ = std::max(peak_, used_locked());
}

void MemoryBudget::refuse(std::uint64_t bytes, std::uint64_t beside, std::string_view what) const {
  // A sum beyond all memory is a request beyond all memory.
  const std::uint64_t needed = bytes > UINT64_MAX - beside ? UINT64_MAX : beside + bytes;
  throw Error(ErrorCode::kMemory,
              fmt::format("{} needs {}{}, more than the memory budget of {}; give --memory {} or "
                          "more",
                          what, format_bytes(bytes),
                          beside > 0 ? fmt::format(" beside {}: {} in all", format_bytes(beside),
                                                   format_bytes(needed))
                                     : "",
                          format_bytes(total_), format_memory(needed)));
}

}  // namespace tetfusion
