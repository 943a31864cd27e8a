#include "io/gmsh/gmsh_rows.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <string>

#include "base/blocks.h"

namespace tetfusion {

// Calls f(what the row is for, &cursor) for the rows of a place, which takes the values or passes
// over them. Returns where they end.
template <class F>
const char* GmshRows::walk(const Place& place, F f) const {
  GmshCursor in(file_, place.text, head_.binary, head_.swapped);
  for (std::uint64_t row = 0; row < place.rows; ++row) {
    in.skip_blanks_of_text();
    const char* const at = in.at();
    const std::int64_t number = in.integer();
    const std::uint64_t of =
        number < 0 ? NumberMap::kNone : numbers_.find(static_cast<std::uint64_t>(number));
    if (of == NumberMap::kNone) {
      in.fail_at(at, "\"" + data_.name + "\" has a value for " + std::to_string(number) +
                         ", which is not there");
    }
    if (of < count_) {
      f(of, &in);
    } else {
      in.skip_numbers(data_.components, 8);
    }
  }
  file_.release(place.text.data(), in.at());
  return in.at();
}

GmshRows::GmshRows(const FormatFile& file, const GmshHead& head, const GmshData& data,
                   const NumberMap& places, std::uint64_t count)
    : file_(file), head_(head), data_(data), numbers_(places), count_(count) {
  std::uint64_t next = 0;  // the least that the next row may be for
  for (const GmshDataSection& section : data.sections) {
    std::string_view text = section.text;
    for (std::uint64_t done = 0; done < section.rows; done += kRowsPerPlace) {
      bool is_first = true;
      Place place{next, std::min(kRowsPerPlace, section.rows - done), text};
      const char* const end = walk(place, [&](std::uint64_t of, GmshCursor* in) {
        if (is_first) place.of = of;
        is_first = false;
        in_order_ = in_order_ && of >= next;
        next = of + 1;
        in->skip_numbers(data_.components, 8);
      });
      places_.push_back(place);
      text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    }
    GmshCursor(file, text, head.binary, head.swapped).rest_is_blank();
  }
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
    for (const Place& place : places_) walk(place, take);
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
  for_each_block(end - begin, 1,
                 [&](std::size_t b, std::size_t, std::size_t) { walk(places_[begin + b], take); });
}

}  // namespace tetfusion
