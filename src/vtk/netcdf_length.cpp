#include "vtk/netcdf_length.h"

#include <algorithm>
#include <array>
#include <vector>

namespace tetfusion {

namespace {

// Numbers are big-endian, names and values padded to four bytes (NetCDF User's Guide, "File Format
// Specifications").
class Header {
 public:
  explicit Header(std::span<const std::byte> bytes) : bytes_(bytes) {}

  bool is_damaged() const { return is_damaged_; }

  std::uint64_t number(std::size_t size) {
    if (is_damaged_ || bytes_.size() - at_ < size) {
      is_damaged_ = true;
      return 0;
    }
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < size; ++i) {
      value = value << 8 | std::to_integer<std::uint64_t>(bytes_[at_++]);
    }
    return value;
  }

  void skip(std::uint64_t size) {
    if (is_damaged_ || bytes_.size() - at_ < size) {
      is_damaged_ = true;
    } else {
      at_ += size;
    }
  }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  bool is_damaged_ = false;
};

constexpr std::uint64_t padded(std::uint64_t size) { return (size + 3) / 4 * 4; }

// By NetCDF's numbers of types, from byte = 1 to ubyte, ..., uint64 = 11.
std::uint64_t type_size(std::uint64_t type) {
  constexpr std::array<std::uint8_t, 12> kSizes{0, 1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8};
  return type < kSizes.size() ? kSizes[type] : 0;
}

struct Variable {
  bool has_records = false;
  std::uint64_t size = 0;  // of a record, where it has such
  std::uint64_t begin = 0;
};

class Reader {
 public:
  Reader(std::span<const std::byte> bytes, std::uint64_t version)
      : in_(bytes), count_size_(version == 5 ? 8 : 4), offset_size_(version == 1 ? 4 : 8) {}

  std::uint64_t length(std::uint64_t most_records) {
    in_.skip(4);
    // Where that is not known it is a number with all bits set.
    const std::uint64_t records = std::min(count(), most_records);
    std::vector<std::uint64_t> dimensions;
    for_each_of_list([&] {
      skip_name();
      dimensions.push_back(count());
    });
    skip_attributes();
    std::vector<Variable> variables;
    for_each_of_list([&] { variables.push_back(variable(dimensions)); });
    return in_.is_damaged() ? 0 : end_of(variables, records);
  }

 private:
  std::uint64_t count() { return in_.number(count_size_); }

  // A tag, and how many there are.
  template <class F>
  void for_each_of_list(F f) {
    in_.skip(4);
    const std::uint64_t items = count();
    for (std::uint64_t i = 0; i < items && !in_.is_damaged(); ++i) f();
  }

  void skip_name() { in_.skip(padded(count())); }

  void skip_attributes() {
    for_each_of_list([&] {
      skip_name();
      const std::uint64_t type = in_.number(4);
      in_.skip(padded(count() * type_size(type)));
    });
  }

  // The record dimension is the first of a variable that has it, and has length 0.
  Variable variable(const std::vector<std::uint64_t>& dimensions) {
    Variable out;
    skip_name();
    const std::uint64_t rank = count();
    std::uint64_t values = 1;
    for (std::uint64_t i = 0; i < rank && !in_.is_damaged(); ++i) {
      const std::uint64_t id = count();
      const std::uint64_t length = id < dimensions.size() ? dimensions[id] : 0;
      if (i == 0 && length == 0) {
        out.has_records = true;
      } else {
        values *= length;
      }
    }
    skip_attributes();
    out.size = values * type_size(in_.number(4));
    count();  // its size once more, which may be too large for its bits
    out.begin = in_.number(offset_size_);
    return out;
  }

  static std::uint64_t end_of(const std::vector<Variable>& variables, std::uint64_t records) {
    std::uint64_t stride = 0, with_records = 0;
    for (const Variable& v : variables) {
      if (!v.has_records) continue;
      stride += padded(v.size);
      ++with_records;
    }
    std::uint64_t end = 0;
    for (const Variable& v : variables) {
      if (v.size == 0 || (v.has_records && records == 0)) continue;
      // A record of one variable alone is not padded.
      const std::uint64_t step = with_records == 1 ? v.size : stride;
      end = std::max(end, v.begin + v.size + (v.has_records ? (records - 1) * step : 0));
    }
    return end;
  }

  Header in_;
  std::size_t count_size_, offset_size_;
};

}  // namespace

std::uint64_t netcdf_length(std::span<const std::byte> bytes, std::uint64_t records) {
  constexpr std::array<char, 3> kMagic{'C', 'D', 'F'};
  const auto same = [](std::byte a, char b) { return std::to_integer<char>(a) == b; };
  if (bytes.size() < 4 || !std::ranges::equal(bytes.first(3), kMagic, same)) return 0;
  const auto version = std::to_integer<std::uint64_t>(bytes[3]);
  if (version != 1 && version != 2 && version != 5) return 0;
  return Reader(bytes, version).length(records);
}

}  // namespace tetfusion
