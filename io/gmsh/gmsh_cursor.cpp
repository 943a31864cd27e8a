#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>

#include "io/formats/byte_values.h"
#include "io/formats/text_tokens.h"
#include "io/gmsh/gmsh_head.h"
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
  const char* const before = at_;
  skip_blanks();
  const char* const begin = at_;
  const std::string_view words = line();
  const std::size_t close = words.rfind('"');
  // Behind an empty line is not what that line was to be.
  if (close == words.npos && !words.empty() && std::count(before, begin, '\n') < 2) {
    return std::string(words);
  }
  at_ = begin;
  if (close == words.npos || close == 0 || words[0] != '"') fail("expected a text in quotes");
  at_ += close + 1;
  return std::string(words.substr(1, close - 1));
}

std::string_view GmshCursor::line() {
  skip_blanks();
  const char* const begin = at_;
  at_ = std::find(at_, end_, '\n');
  std::string_view line(begin, static_cast<std::size_t>(at_ - begin));
  while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
  return line;
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

namespace {

struct NumberedType {
  std::size_t number;
  GmshElementType type;
};

// Of third order and more they are what VTK calls Lagrange cells.
constexpr auto kElementTypes = std::to_array<NumberedType>({
    {15, {kVtkVertex, 1}},
    // Lines.
    {1, {kVtkLine, 2}},
    {8, {kVtkQuadraticEdge, 3}},
    {26, {kVtkLagrangeCurve, 4}},
    {27, {kVtkLagrangeCurve, 5}},
    {28, {kVtkLagrangeCurve, 6}},
    {62, {kVtkLagrangeCurve, 7}},
    {63, {kVtkLagrangeCurve, 8}},
    {64, {kVtkLagrangeCurve, 9}},
    {65, {kVtkLagrangeCurve, 10}},
    {66, {kVtkLagrangeCurve, 11}},
    // Triangles.
    {2, {kVtkTriangle, 3}},
    {9, {kVtkQuadraticTriangle, 6}},
    {20, {kVtkLagrangeTriangle, 9}},
    {21, {kVtkLagrangeTriangle, 10}},
    {22, {kVtkLagrangeTriangle, 12}},
    {23, {kVtkLagrangeTriangle, 15}},
    {24, {kVtkLagrangeTriangle, 15}},
    {25, {kVtkLagrangeTriangle, 21}},
    {42, {kVtkLagrangeTriangle, 28}},
    {43, {kVtkLagrangeTriangle, 36}},
    {44, {kVtkLagrangeTriangle, 45}},
    {45, {kVtkLagrangeTriangle, 55}},
    {46, {kVtkLagrangeTriangle, 66}},
    // Quadrilaterals.
    {3, {kVtkQuad, 4}},
    {16, {kVtkQuadraticQuad, 8}},
    {10, {kVtkBiquadraticQuad, 9}},
    {36, {kVtkLagrangeQuad, 16}},
    {37, {kVtkLagrangeQuad, 25}},
    {38, {kVtkLagrangeQuad, 36}},
    {47, {kVtkLagrangeQuad, 49}},
    {48, {kVtkLagrangeQuad, 64}},
    {49, {kVtkLagrangeQuad, 81}},
    {50, {kVtkLagrangeQuad, 100}},
    {51, {kVtkLagrangeQuad, 121}},
    // Tetrahedra.
    {4, {kVtkTetra, 4}},
    {11, {kVtkQuadraticTetra, 10}},
    {29, {kVtkLagrangeTetra, 20}},
    {30, {kVtkLagrangeTetra, 35}},
    {31, {kVtkLagrangeTetra, 56}},
    {71, {kVtkLagrangeTetra, 84}},
    {72, {kVtkLagrangeTetra, 120}},
    {73, {kVtkLagrangeTetra, 165}},
    {74, {kVtkLagrangeTetra, 220}},
    {75, {kVtkLagrangeTetra, 286}},
    // Hexahedra.
    {5, {kVtkHexahedron, 8}},
    {17, {kVtkQuadraticHexahedron, 20}},
    {12, {kVtkTriquadraticHexahedron, 27}},
    {92, {kVtkLagrangeHexahedron, 64}},
    {93, {kVtkLagrangeHexahedron, 125}},
    {94, {kVtkLagrangeHexahedron, 216}},
    {95, {kVtkLagrangeHexahedron, 343}},
    {96, {kVtkLagrangeHexahedron, 512}},
    {97, {kVtkLagrangeHexahedron, 729}},
    {98, {kVtkLagrangeHexahedron, 1000}},
    // Prisms.
    {6, {kVtkWedge, 6}},
    {18, {kVtkQuadraticWedge, 15}},
    {13, {kVtkBiquadraticQuadraticWedge, 18}},
    {90, {kVtkLagrangeWedge, 40}},
    {91, {kVtkLagrangeWedge, 75}},
    {106, {kVtkLagrangeWedge, 126}},
    {107, {kVtkLagrangeWedge, 196}},
    {108, {kVtkLagrangeWedge, 288}},
    {109, {kVtkLagrangeWedge, 405}},
    {110, {kVtkLagrangeWedge, 550}},
    // Pyramids.
    {7, {kVtkPyramid, 5}},
    {19, {kVtkQuadraticPyramid, 13}},
    {14, {kVtkLagrangePyramid, 14}},
});

constexpr auto kByNumber = [] {
  std::array<GmshElementType, 111> types{};
  for (const NumberedType& known : kElementTypes) types[known.number] = known.type;
  return types;
}();

}  // namespace

GmshElementType gmsh_element_type(std::int64_t type) {
  return type >= 0 && type < std::ssize(kByNumber) ? kByNumber[static_cast<std::size_t>(type)]
                                                   : GmshElementType{};
}

}  // namespace tetfusion
