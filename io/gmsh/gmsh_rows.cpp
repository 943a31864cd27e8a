#include "io/gmsh/gmsh_rows.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <string>

#include "base/blocks.h"

namespace tetfusion {

// Calls f(what the row is for, &cursor) for rows, which takes the values or passes over them.
// Returns where they end.
template <class F>
const char* GmshRows::walk(const char* begin, std::uint64_t rows, F f) const {
  const auto skipped = static_cast<std::size_t>(begin - data_.text.data());
  GmshCursor in(file_, data_.text.substr(skipped), head_.binary, head_.swapped);
  for (std::uint64_t row = 0; row < rows; ++row) {
    in.skip_blanks_of_text();
    const char* const at = in.at();
    const std::int64_t number = in.integer();
    const std::uint64_t place =
        number < 0 ? NumberMap::kNone : numbers_.find(static_cast<std::uint64_t>(number));
    if (place == NumberMap::kNone) {
      in.fail_at(at, "\"" + data_.name + "\" has a value for " + std::to_string(number) +
                         ", which is not there");
    }
    if (place < count_) {
      f(place, &in);
    } else {
      in.skip_numbers(data_.components, 8);
    }
  }
  file_.release(begin, in.at());
  return in.at();
}

GmshRows::GmshRows(const FormatFile& file, const GmshHead& head, const GmshData& data,
                   const NumberMap& places, std::uint64_t count)
    : file_(file), head_(head), data_(data), numbers_(places), count_(count) {
  const char* at = data.text.data();
  std::uint64_t next = 0;  // the least that the next row may be for
  for (std::uint64_t done = 0; done < data.rows; done += kRowsPerPlace) {
    bool is_first = true;
    const std::uint64_t rows = std::min(kRowsPerPlace, data.rows - done);
    places_.push_back({next, at});
    at = walk(at, rows, [&](std::uint64_t of, GmshCursor* in) {
      if (is_first) places_.back().of = of;
      is_first = false;
      in_order_ = in_order_ && of >= next;
      next = of + 1;
      in->skip_numbers(data_.components, 8);
    });
  }
  const auto skipped = static_cast<std::size_t>(at - data.text.data());
  GmshCursor(file, data.text.substr(skipped), head.binary, head.swapped).rest_is_blank();
}

std::uint64_t GmshRows::rows_of(std::size_t place) const {
  return std::min(kRowsPerPlace, data_.rows - place * kRowsPerPlace);
}

void GmshRows::read(std::uint64_t first, std::uint64_t count, double* out) const {
  const std::uint64_t width = data_.components;
  std::fill(out, out + count * width, std::numeric_limits<double>::quiet_NaN());
  const auto take = [&](std::uint64_t of, GmshCursor* in) {
    if (of < first || of - first >= count) return in->skip_numbers(width, 8);
    double* const to = out + (of - first) * width;
    for (std::uint64_t k = 0; k < width; ++k) to[k] = in->real();
  };
  if (!in_order_) {
    for (std::size_t p = 0; p < places_.size(); ++p) walk(places_[p].at, rows_of(p), take);
    return;
  }
  const auto behind = [&](std::uint64_t of) {
    return static_cast<std::size_t>(
        std::lower_bound(places_.begin(), places_.end(), of,
                         [](const Place& place, std::uint64_t value) { return place.of < value; }) -
        places_.begin());
  };
  const std::size_t begin = behind(first + 1) - (behind(first + 1) > 0 ? 1 : 0);
  const std::size_t end = behind(first + count);
  if (begin >= end) return;
  for_each_block(end - begin, 1, [&](std::size_t b, std::size_t, std::size_t) {
    walk(places_[begin + b].at, rows_of(begin + b), take);
  });
}

}  // namespace tetfusion
