// Connected components, found by several threads at once.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "base/vector.h"

namespace tetfusion {

// Disjoint sets of [0, size). unite() may be called from several threads; each set's root ends up
// as its smallest element, whatever the order.
class UnionFind {
 public:
  explicit UnionFind(std::size_t size) : parent_(size) {
    for (std::size_t i = 0; i < size; ++i) parent_[i] = static_cast<std::uint32_t>(i);
  }

  std::uint32_t find(std::uint32_t x) {
    for (;;) {
      std::uint32_t up = load(x);
      if (up == x) return x;
      const std::uint32_t above = load(up);
      // Halve the path; if another thread was here first, its step is as good.
      if (above != up) ref(x).compare_exchange_weak(up, above, std::memory_order_relaxed);
      x = above;
    }
  }

  void unite(std::uint32_t a, std::uint32_t b) {
    for (;;) {
      a = find(a);
      b = find(b);
      if (a == b) return;
      if (a < b) std::swap(a, b);
      std::uint32_t expected = a;
      if (ref(a).compare_exchange_strong(expected, b, std::memory_order_relaxed)) return;
    }
  }

  // One thread.
  void grow(std::size_t size) {
    for (std::size_t i = parent_.size(); i < size; ++i) {
      parent_.push_back(static_cast<std::uint32_t>(i));
    }
  }

  bool is_root(std::uint32_t x) { return load(x) == x; }

 private:
  std::atomic_ref<std::uint32_t> ref(std::uint32_t x) {
    return std::atomic_ref<std::uint32_t>(parent_[x]);
  }
  std::uint32_t load(std::uint32_t x) { return ref(x).load(std::memory_order_relaxed); }

  Vector<std::uint32_t> parent_;
};

// The same with two colours: each element has the same colour as its root, or the other one. One
// thread.
class ColourUnionFind {
 public:
  struct Root {
    std::uint32_t id;
    bool other;  // whether the element's colour is not the root's
  };

  explicit ColourUnionFind(std::size_t size) : parent_(size) {
    for (std::size_t i = 0; i < size; ++i) parent_[i] = {static_cast<std::uint32_t>(i), false};
  }

  Root find(std::uint32_t x) {
    bool other = false;
    while (parent_[x].id != x) {
      Root& up = parent_[x];
      const Root above = parent_[up.id];
      if (above.id != up.id) up = {above.id, up.other != above.other};
      other = other != up.other;
      x = up.id;
    }
    return {x, other};
  }

  // Makes the colours of a and b differ or not. Where that contradicts what is known, the first
  // word counts.
  void unite(std::uint32_t a, std::uint32_t b, bool differ) {
    Root root_a = find(a), root_b = find(b);
    if (root_a.id == root_b.id) return;
    if (root_a.id < root_b.id) std::swap(root_a, root_b);
    parent_[root_a.id] = {root_b.id, (root_a.other != root_b.other) != differ};
  }

 private:
  Vector<Root> parent_;
};

}  // namespace tetfusion
