// Columns of rows of one length, packed: the first bytes of all rows, then the second ones, ..., as
// what is alike lies side by side then, and all of it deflated (FORMAT.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "base/vector.h"

namespace tetfusion {

// Throws Error(kMemory).
Vector<std::byte> deflated(std::span<const std::byte> bytes);
// As many bytes as are expected; none where these are not what is there.
Vector<std::byte> inflated(std::span<const std::byte> bytes, std::uint64_t expected);

// Takes columns one after another.
class ColumnPacker {
 public:
  // A column of rows of `stride` bytes, more than 0.
  void put(std::span<const std::byte> rows, std::size_t stride);
  template <class T>
  void put_all(const T& values) {
    put(std::as_bytes(std::span(values)), sizeof values[0]);
  }

  std::uint64_t raw_bytes() const { return raw_.size(); }
  // All columns, deflated. Throws Error(kMemory).
  Vector<std::byte> pack() const { return deflated(raw_); }

 private:
  Vector<std::byte> raw_;
};

// Takes them out again, in the same order. Of bytes that are no such columns `fail`, which throws,
// is called with what is wrong.
class ColumnReader {
 public:
  using Fail = std::function<void(const std::string& what)>;

  // `raw_bytes` are expected when `packed` is inflated.
  ColumnReader(std::span<const std::byte> packed, std::uint64_t raw_bytes, Fail fail);

  // Replaces *rows.
  void take(std::size_t stride, Vector<std::byte>* rows);
  template <class T>
  void take_all(Vector<T>* values);
  // To be called when all have been taken.
  void end() const;

 private:
  std::span<const std::byte> next(std::size_t stride);
  static void join_planes(std::span<const std::byte> planes, std::size_t stride, std::byte* rows);

  Vector<std::byte> raw_;
  std::span<const std::byte> left_;
  Fail fail_;
};

template <class T>
void ColumnReader::take_all(Vector<T>* values) {
  const std::span<const std::byte> planes = next(sizeof(T));
  values->resize(planes.size() / sizeof(T));
  join_planes(planes, sizeof(T), reinterpret_cast<std::byte*>(values->data()));
}

}  // namespace tetfusion
