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
    unsigned bits = 4;
    while ((std::size_t{1} << bits) < 2 * ids) ++bits;
    slots_.assign(std::size_t{1} << bits, Slot{kNone, kNone});
    shift_ = 64 - bits;
  }

  // The value of an id, any but kNone; kNone where it is new: the caller gives it one.
  std::uint32_t& operator[](std::uint32_t id) {
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t i = first_slot(id);; ++i) {
      Slot& slot = slots_[i & mask];
      if (slot.id == kNone) slot.id = id;
      if (slot.id == id) return slot.value;
    }
  }

  // kNone where it is not there.
  std::uint32_t find(std::uint32_t id) const {
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t i = first_slot(id);; ++i) {
      const Slot& slot = slots_[i & mask];
      if (slot.id == id || slot.id == kNone) return slot.value;
    }
  }

 private:
  struct Slot {
    std::uint32_t id;
    std::uint32_t value;
  };
  // The highest bits of the product: the lowest are the same for ids that differ by a large power
  // of two, as those of a lattice's layers may.
  std::size_t first_slot(std::uint32_t id) const {
    return static_cast<std::size_t>(id * 0x9E3779B97F4A7C15u >> shift_);
  }

  unsigned shift_ = 60;
  Vector<Slot> slots_;  // twice as many as ids, and a power of two
};

}  // namespace tetfusion
