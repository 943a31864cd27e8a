// What a mesh that is read has in its rows, a window at a time and in order: for those who need it
// once, and have no room for all of it. (For several threads: for_each_block().)
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "base/run_context.h"
#include "base/vector.h"
#include "io/source/mesh_stream.h"

namespace tetfusion {

constexpr std::uint64_t kStreamWindow = std::uint64_t{1} << 18;
constexpr std::uint64_t kLeastStreamWindow = std::uint64_t{1} << 16;

// Rows in a window of an array: fewer where they are wide. A power of two.
constexpr std::uint64_t stream_window(std::uint64_t row_bytes) {
  constexpr std::uint64_t kMost = std::uint64_t{16} << 20;
  std::uint64_t rows = kStreamWindow;
  while (rows > kLeastStreamWindow && rows * row_bytes > kMost) rows /= 2;
  return rows;
}

// Calls f(first, count) for each window of so many rows; if f returns a bool, until that is false.
// Throws what RunContext::check() throws, before each.
template <class F>
void for_each_window(std::uint64_t rows, const RunContext& context, F f,
                     std::uint64_t window = kStreamWindow) {
  for (std::uint64_t first = 0; first < rows; first += window) {
    context.check();
    const std::uint64_t count = std::min(window, rows - first);
    if constexpr (std::is_same_v<decltype(f(first, count)), bool>) {
      if (!f(first, count)) return;
    } else {
      f(first, count);
    }
  }
}

// The same with f(first, bytes): the window's tuples of one array, as MeshStream::read_rows() has
// them, until the next call.
template <class F>
void for_each_window_of(const MeshStream& stream, Association association, std::size_t index,
                        const ArrayInfo& info, const RunContext& context, F f) {
  Vector<std::byte> rows;
  const std::uint64_t all = association == Association::kCell ? stream.cells() : stream.points();
  const auto read = [&](std::uint64_t first, std::uint64_t count) {
    rows.resize(count * info.row_bytes());
    stream.read_rows(association, index, first, count, rows);
    return f(first, std::span<const std::byte>(rows));
  };
  for_each_window(all, context, read, stream_window(info.row_bytes()));
}

}  // namespace tetfusion
