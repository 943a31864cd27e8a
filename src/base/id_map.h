// Finds the value of an id: open addressing in one array that keeps its memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include "base/vector.h"

namespace tetfusion {

class IdMap {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  // Forgets everything, and makes room for so many ids. More must not be put in.
  void reset(std::size_t ids) {
    std::size_t slots = 16;
    while (slots < 2 * ids) slots *= 2;
    slots_.assign(slots, Slot{kNone, kNone});
  }

  // The value of an id, any but kNone; kNone where it is new: the caller gives it one.
  std::uint32_t& operator[](std::uint32_t id) {
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t i = id * 0x9E3779B1u;; ++i) {
      Slot& slot = slots_[i & mask];
      if (slot.id == kNone) slot.id = id;
      if (slot.id == id) return slot.value;
    }
  }

  // kNone where it is not there.
  std::uint32_t find(std::uint32_t id) const {
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t i = id * 0x9E3779B1u;; ++i) {
      const Slot& slot = slots_[i & mask];
      if (slot.id == id || slot.id == kNone) return slot.value;
    }
  }

 private:
  struct Slot {
    std::uint32_t id;
    std::uint32_t value;
  };
  Vector<Slot> slots_;  // twice as many as ids, and a power of two
};

}  // namespace tetfusion
