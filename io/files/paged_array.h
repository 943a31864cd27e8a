// Large arrays that are zeros at first: in memory, or in a file without a name that is mapped, so
// that their pages can be let go of and come back when they are touched.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>

#include "io/files/file_system.h"

namespace tetfusion {

// Not thread-safe, but for what is const, and for different elements. Throws std::bad_alloc where
// there is no memory; of a file Error(kIo) where the disk has no room. Nothing is left of the file
// when the process ends, however it ends.
class PagedBytes {
 public:
  PagedBytes() = default;
  // The file lies on the disk of `folder`, which must be there; empty: memory.
  PagedBytes(std::string folder, std::uint64_t bytes);
  ~PagedBytes();
  PagedBytes(PagedBytes&& other) noexcept { *this = std::move(other); }
  PagedBytes& operator=(PagedBytes&& other) noexcept;
  PagedBytes(const PagedBytes&) = delete;
  PagedBytes& operator=(const PagedBytes&) = delete;

  std::byte* data() const { return data_; }
  std::uint64_t bytes() const { return bytes_; }
  // To this many bytes or more. What is there stays; it may be at another address.
  void grow(std::uint64_t bytes);
  // Takes the pages of a file out of this process; memory stays.
  void let_go() const;

 private:
  void set_size(std::uint64_t bytes);
  void* map(std::uint64_t bytes) const;
  void fill_with_zeros(std::uint64_t begin, std::uint64_t end) const;
  [[noreturn]] void fail(const char* what, int error) const;

  std::string folder_;
  Descriptor file_;
  std::byte* data_ = nullptr;
  std::uint64_t bytes_ = 0;  // whole pages
};

template <class T>
class PagedArray {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  PagedArray() = default;
  PagedArray(const std::string& folder, std::uint64_t size) : bytes_(folder, size * sizeof(T)) {
    data_ = reinterpret_cast<T*>(bytes_.data());
    size_ = size;
  }
  PagedArray(PagedArray&& other) noexcept { *this = std::move(other); }
  PagedArray& operator=(PagedArray&& other) noexcept {
    bytes_ = std::move(other.bytes_);
    data_ = std::exchange(other.data_, nullptr);
    size_ = std::exchange(other.size_, 0);
    return *this;
  }

  T* data() const { return data_; }
  std::uint64_t size() const { return size_; }
  T& operator[](std::uint64_t i) { return data_[i]; }
  const T& operator[](std::uint64_t i) const { return data_[i]; }
  // The new ones are zeros.
  void resize(std::uint64_t size) {
    if (size * sizeof(T) > bytes_.bytes()) {
      bytes_.grow((size + size / 2) * sizeof(T));
      data_ = reinterpret_cast<T*>(bytes_.data());
    }
    size_ = size;
  }
  void push_back(const T& value) {
    resize(size_ + 1);
    data_[size_ - 1] = value;
  }
  void let_go() const { bytes_.let_go(); }

 private:
  PagedBytes bytes_;
  T* data_ = nullptr;
  std::uint64_t size_ = 0;
};

}  // namespace tetfusion
