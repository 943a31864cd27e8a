// Numbers in binary files, of either byte order, at any address.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>

namespace tetfusion {

template <class T>
T load(const std::byte* from, bool swapped) {
  std::byte bytes[sizeof(T)];
  std::memcpy(bytes, from, sizeof(T));
  if (swapped) std::reverse(bytes, bytes + sizeof(T));
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

}  // namespace tetfusion
