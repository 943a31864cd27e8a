// Values as bytes and back, for what this program writes for itself on the same machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>

#include "base/error.h"
#include "base/vector.h"

namespace tetfusion {

class ByteWriter {
 public:
  ByteWriter() = default;
  // Room for so many bytes at once, so that they are not copied as they grow.
  explicit ByteWriter(std::size_t bytes) { bytes_.reserve(bytes); }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void put(const T& value) { append(&value, sizeof value); }
  // The number of elements, then these.
  template <class Container>
  requires std::is_trivially_copyable_v<typename Container::value_type>
  void put_all(const Container& values) {
    put(static_cast<std::uint64_t>(values.size()));
    append(values.data(), values.size() * sizeof(values[0]));
  }
  Vector<std::byte> take() { return std::move(bytes_); }

 private:
  void append(const void* data, std::size_t bytes) {
    const auto* begin = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), begin, begin + bytes);
  }
  Vector<std::byte> bytes_;
};

// Throws Error(kIo) where there are fewer bytes than asked for.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <class T>
  requires std::is_trivially_copyable_v<T>
  void get(T* value) { std::memcpy(value, take(sizeof *value), sizeof *value); }
  template <class Container>
  requires std::is_trivially_copyable_v<typename Container::value_type>
  void get_all(Container* values) {
    std::uint64_t size = 0;
    get(&size);
    constexpr std::size_t kEach = sizeof(typename Container::value_type);
    if (size > bytes_.size() / kEach) fail();
    values->resize(size);
    if (size > 0) std::memcpy(values->data(), take(size * kEach), size * kEach);
  }

 private:
  const std::byte* take(std::size_t bytes) {
    if (bytes > bytes_.size()) fail();
    const std::byte* begin = bytes_.data();
    bytes_ = bytes_.subspan(bytes);
    return begin;
  }
  [[noreturn]] static void fail() {
    throw Error(
        ErrorCode::kIo,
        "the state of the interrupted run is shorter than it should be: start anew, without "
        "--resume");
  }
  std::span<const std::byte> bytes_;
};

}  // namespace tetfusion
