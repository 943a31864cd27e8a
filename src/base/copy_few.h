// A few values, of which only the running program knows how many: where there are millions of such
// copies, calling memcpy() for each takes longer than the copies do.
#pragma once

#include <cstddef>
#include <cstring>
#include <type_traits>

namespace tetfusion {

template <class T>
inline void copy_few(const T* from, std::size_t count, T* to) {
  static_assert(std::is_trivially_copyable_v<T>);
  const std::size_t bytes = count * sizeof(T);
  switch (bytes) {
    case 0:
      return;
    case 4:
      std::memcpy(to, from, 4);
      return;
    case 8:
      std::memcpy(to, from, 8);
      return;
    case 12:
      std::memcpy(to, from, 12);
      return;
    case 24:
      std::memcpy(to, from, 24);
      return;
    default:
      std::memcpy(to, from, bytes);
  }
}

}  // namespace tetfusion
