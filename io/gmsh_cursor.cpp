#include <algorithm>
#include <cstring>

#include "io/byte_values.h"
#include "io/gmsh_head.h"
#include "io/text_tokens.h"
#include "mesh/split_cells.h"

namespace tetfusion {

void GmshCursor::fail_at(const char* at, const std::string& what) const {
  if (binary_) file_->fail_at_byte(at, what);
  file_->fail_in_line(at, what);
}

void GmshCursor::invalid_at(const char* at, const std::string& what) const {
  if (binary_) file_->invalid_at_byte(at, what);
  file_->invalid_in_line(at, what);
}

void GmshCursor::skip_blanks() {
  while (at_ < end_ && is_blank(*at_)) ++at_;
}

std::string_view GmshCursor::word() {
  skip_blanks();
  const char* const begin = at_;
  while (at_ < end_ && !is_blank(*at_)) ++at_;
  if (at_ == begin) fail("the section ends too early: expected a number");
  return {begin, static_cast<std::size_t>(at_ - begin)};
}

template <class T>
T GmshCursor::binary_value() {
  if (static_cast<std::size_t>(end_ - at_) < sizeof(T)) fail("the section ends too early");
  const T value = load<T>(reinterpret_cast<const std::byte*>(at_), swapped_);
  at_ += sizeof(T);
  return value;
}

std::int64_t GmshCursor::integer() {
  return binary_ ? binary_value<std::int32_t>() : file_->number<std::int64_t>(word());
}

std::uint64_t GmshCursor::size() {
  return binary_ ? binary_value<std::uint64_t>() : file_->number<std::uint64_t>(word());
}

double GmshCursor::real() {
  return binary_ ? binary_value<double>() : file_->number<double>(word());
}

std::uint64_t GmshCursor::count() { return file_->number<std::uint64_t>(word()); }

std::string GmshCursor::text() {
  skip_blanks();
  const std::string_view line(at_, static_cast<std::size_t>(std::find(at_, end_, '\n') - at_));
  const std::size_t close = line.rfind('"');
  if (close == line.npos || close == 0 || line[0] != '"') fail("expected a text in quotes");
  at_ += close + 1;
  return std::string(line.substr(1, close - 1));
}

void GmshCursor::end_line() {
  at_ = std::find(at_, end_, '\n');
  if (at_ < end_) ++at_;
}

std::uint64_t GmshCursor::rows(std::uint64_t claimed, std::uint64_t binary_bytes,
                               std::uint64_t numbers) const {
  const auto left = static_cast<std::uint64_t>(end_ - at_);
  // A number in a text takes a digit and a blank.
  const std::uint64_t most = binary_ ? left / binary_bytes : left / (2 * numbers) + 1;
  if (claimed > most) {
    fail(std::to_string(claimed) + " rows do not fit into the " + std::to_string(left) +
         " bytes of the section that are left");
  }
  return claimed;
}

void GmshCursor::skip(std::uint64_t bytes) {
  if (static_cast<std::uint64_t>(end_ - at_) < bytes) fail("the section ends too early");
  at_ += bytes;
}

void GmshCursor::skip_numbers(std::uint64_t count, std::uint64_t binary_bytes) {
  if (binary_) return skip(count * binary_bytes);
  for (std::uint64_t i = 0; i < count; ++i) word();
}

void GmshCursor::rest_is_blank() const {
  const char* const found = std::find_if_not(at_, end_, is_blank);
  if (found != end_) {
    fail_at(found, "expected the section's end, found " +
                       quoted({found, static_cast<std::size_t>(end_ - found)}));
  }
}

GmshElementType gmsh_element_type(std::int64_t type) {
  switch (type) {
    case 1:
      return {kVtkLine, 2, "line"};
    case 2:
      return {kVtkTriangle, 3, "triangle"};
    case 3:
      return {kVtkQuad, 4, "quadrilateral"};
    case 4:
      return {kVtkTetra, 4, "tetrahedron"};
    case 5:
      return {kVtkHexahedron, 8, "hexahedron"};
    case 6:
      return {kVtkWedge, 6, "prism"};
    case 7:
      return {kVtkPyramid, 5, "pyramid"};
    case 8:
      return {kVtkQuadraticEdge, 3, "line of second order"};
    case 9:
      return {kVtkQuadraticTriangle, 6, "triangle of second order"};
    case 11:
      return {kVtkQuadraticTetra, 10, "tetrahedron of second order"};
    case 15:
      return {kVtkVertex, 1, "point"};
    default:
      return {};
  }
}

}  // namespace tetfusion
