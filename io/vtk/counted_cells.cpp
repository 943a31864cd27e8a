#include "io/vtk/counted_cells.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

namespace tetfusion {

namespace {

constexpr std::uint64_t kCellsPerChunk = 16384;

struct CountedList {
  ArrayReader values;
  std::uint64_t cells = 0;
  Vector<std::uint64_t> chunk_begins;  // in the list; one entry more

  std::size_t chunks() const { return chunk_begins.size() - 1; }
  // As the number of points that it has comes before each of them.
  std::uint64_t first_cell(std::size_t chunk) const {
    return std::min(chunk * kCellsPerChunk, cells);
  }
  std::uint64_t first_id(std::size_t chunk) const {
    return chunk_begins[chunk] - first_cell(chunk);
  }
};

// Values of the list from `first` on, as 64 bits with sign.
Vector<std::int64_t> read_values(const ArrayReader& list, std::uint64_t first,
                                 std::uint64_t count) {
  Vector<std::int64_t> values(count);
  if (list.type() == ValueType::kInt64) {
    list.read(first, count, reinterpret_cast<std::byte*>(values.data()));
    return values;
  }
  Vector<std::int32_t> narrow(count);
  list.read(first, count, reinterpret_cast<std::byte*>(narrow.data()));
  std::copy(narrow.begin(), narrow.end(), values.begin());
  return values;
}

// Where each chunk of cells begins.
Vector<std::uint64_t> find_chunks(const ArrayReader& list, std::uint64_t cells) {
  constexpr std::uint64_t kWindow = std::uint64_t{1} << 19;
  Vector<std::uint64_t> begins;
  std::uint64_t at = 0;
  Vector<std::int64_t> window;
  std::uint64_t window_begin = 0;
  for (std::uint64_t cell = 0; cell < cells; ++cell) {
    if (cell % kCellsPerChunk == 0) begins.push_back(at);
    if (at >= list.values()) {
      list.fail("the list ends with cell " + std::to_string(cell) + " of " + std::to_string(cells));
    }
    if (at >= window_begin + window.size()) {
      window_begin = at;
      window = read_values(list, at, std::min(kWindow, list.values() - at));
    }
    const std::int64_t count = window[at - window_begin];
    if (count < 0 || static_cast<std::uint64_t>(count) > list.values() - at - 1) {
      list.fail("cell " + std::to_string(cell) + " has " + std::to_string(count) + " points, but " +
                std::to_string(list.values() - at - 1) + " numbers follow in the list");
    }
    at += 1 + static_cast<std::uint64_t>(count);
  }
  if (at != list.values()) {
    list.fail("the list has " + std::to_string(list.values()) + " numbers, but its " +
              std::to_string(cells) + " cells end after " + std::to_string(at));
  }
  begins.push_back(at);
  return begins;
}

class Offsets final : public ComputedArray {
 public:
  explicit Offsets(std::shared_ptr<const CountedList> list) : list_(std::move(list)) {}

  Vector<std::uint64_t> chunk_begins() const override {
    Vector<std::uint64_t> begins(list_->chunks() + 1);
    for (std::size_t c = 0; c < begins.size(); ++c) begins[c] = list_->first_cell(c);
    return begins;
  }

  void compute(std::size_t chunk, std::byte* out) const override {
    const std::uint64_t begin = list_->chunk_begins[chunk];
    const Vector<std::int64_t> values =
        read_values(list_->values, begin, list_->chunk_begins[chunk + 1] - begin);
    std::int64_t end = static_cast<std::int64_t>(list_->first_id(chunk));
    for (std::size_t at = 0; at < values.size();) {
      end += values[at];
      std::memcpy(out, &end, sizeof end);
      out += sizeof end;
      at += 1 + static_cast<std::size_t>(values[at]);
    }
  }

 private:
  std::shared_ptr<const CountedList> list_;
};

class Connectivity final : public ComputedArray {
 public:
  explicit Connectivity(std::shared_ptr<const CountedList> list) : list_(std::move(list)) {}

  Vector<std::uint64_t> chunk_begins() const override {
    Vector<std::uint64_t> begins(list_->chunks() + 1);
    for (std::size_t c = 0; c < begins.size(); ++c) begins[c] = list_->first_id(c);
    return begins;
  }

  void compute(std::size_t chunk, std::byte* out) const override {
    const std::uint64_t begin = list_->chunk_begins[chunk];
    const Vector<std::int64_t> values =
        read_values(list_->values, begin, list_->chunk_begins[chunk + 1] - begin);
    visit_type(list_->values.type(), [&](auto zero) {
      using T = decltype(zero);
      for (std::size_t at = 0; at < values.size();) {
        for (std::int64_t left = values[at++]; left > 0; --left, out += sizeof(T)) {
          const T id = static_cast<T>(values[at++]);
          std::memcpy(out, &id, sizeof id);
        }
      }
    });
  }

 private:
  std::shared_ptr<const CountedList> list_;
};

}  // namespace

CountedCells count_cells(ArrayReader list, std::uint64_t cells) {
  Vector<std::uint64_t> begins = find_chunks(list, cells);
  const auto shared =
      std::make_shared<const CountedList>(CountedList{std::move(list), cells, std::move(begins)});
  return {std::make_shared<Offsets>(shared), std::make_shared<Connectivity>(shared)};
}

}  // namespace tetfusion
