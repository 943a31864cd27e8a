#include "mesh/regions/region_numbers.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "base/mix.h"

namespace tetfusion {

Vector<std::uint64_t> region_keys(ValueType type, std::span<const std::byte> values) {
  Vector<std::uint64_t> keys(values.size() / size_of(type));
  visit_type(type, [&](auto zero) {
    using T = decltype(zero);
    for (std::size_t i = 0; i < keys.size(); ++i) {
      T value;
      std::memcpy(&value, values.data() + i * sizeof value, sizeof value);
      keys[i] = region_key(value);
    }
  });
  return keys;
}

std::uint32_t RegionNumbers::number(std::uint32_t before, std::uint64_t key) {
  // A quarter stays free, so that searches end soon.
  if (4 * (std::size_t{count_} + 1) > 3 * slots_.size()) grow();
  Slot& slot = find(before, key);
  if (slot.number == kNone) slot = {key, before, count_++};
  return slot.number;
}

auto RegionNumbers::find(std::uint32_t before, std::uint64_t key) -> Slot& {
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t i = mix(key + mix(before));; ++i) {
    Slot& slot = slots_[i & mask];
    if (slot.number == kNone || (slot.key == key && slot.before == before)) return slot;
  }
}

void RegionNumbers::grow() {
  const Vector<Slot> old = std::move(slots_);
  slots_ = {};
  slots_.assign(std::max<std::size_t>(16, 2 * old.size()), Slot{0, 0, kNone});
  for (const Slot& slot : old) {
    if (slot.number != kNone) find(slot.before, slot.key) = slot;
  }
}

}  // namespace tetfusion
