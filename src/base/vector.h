// std::vector without the zero fill: growing a large array does not touch it, so that the thread
// that writes a page first also owns it, and large arrays ask for huge pages (a walk over a mesh
// misses the TLB at every second step otherwise).
#pragma once

#include <cstddef>
#include <new>
#include <numeric>
#include <utility>
#include <vector>

namespace tetfusion {

namespace detail {
void* allocate_bytes(std::size_t bytes);  // throws std::bad_alloc
void free_bytes(void* p, std::size_t bytes) noexcept;
}  // namespace detail

template <class T>
struct DefaultInitAllocator {
  using value_type = T;
  DefaultInitAllocator() = default;
  template <class U>
  DefaultInitAllocator(const DefaultInitAllocator<U>&) {}  // NOLINT(google-explicit-constructor)

  T* allocate(std::size_t n) {
    if (n > static_cast<std::size_t>(-1) / sizeof(T)) throw std::bad_alloc();
    return static_cast<T*>(detail::allocate_bytes(n * sizeof(T)));
  }
  void deallocate(T* p, std::size_t n) noexcept { detail::free_bytes(p, n * sizeof(T)); }
  template <class U>
  void construct(U* p) {
    ::new (static_cast<void*>(p)) U;
  }
  template <class U, class... Args>
  void construct(U* p, Args&&... args) {
    ::new (static_cast<void*>(p)) U(std::forward<Args>(args)...);
  }
  friend bool operator==(const DefaultInitAllocator&, const DefaultInitAllocator&) { return true; }
};

// resize(n) leaves new elements uninitialised; resize(n, value) and assign() fill.
template <class T>
using Vector = std::vector<T, DefaultInitAllocator<T>>;

// 0, 1, 2, ..., size - 1.
template <class T>
Vector<T> count_up(std::size_t size) {
  Vector<T> numbers(size);
  std::iota(numbers.begin(), numbers.end(), T{0});
  return numbers;
}

}  // namespace tetfusion
