#include "io/medit/medit_head.h"

#include <algorithm>
#include <array>
#include <set>
#include <string>

#include "io/formats/byte_values.h"
#include "io/formats/text_tokens.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

using Role = MeditKeyword::Role;

// Cells that this program cannot read must not get lost without an error; what only adds to a mesh
// may, with a note.
constexpr std::array<MeditKeyword, 52> kKeywords = {{
    {"MeshVersionFormatted", 1},
    {"Dimension", 3},
    {"Vertices", 4, Role::kVertices},
    {"Edges", 5, Role::kCells, kVtkLine},
    {"Triangles", 6, Role::kCells, kVtkTriangle},
    {"Quadrilaterals", 7, Role::kCells, kVtkQuad},
    {"Tetrahedra", 8, Role::kCells, kVtkTetra},
    {"Prisms", 9, Role::kCells, kVtkWedge},
    {"Hexahedra", 10, Role::kCells, kVtkHexahedron},
    {"Hexaedra", 10, Role::kCells, kVtkHexahedron},
    {"Pyramids", 49, Role::kCells, kVtkPyramid},
    {"RequiredVertices", 15, Role::kPoints, kVtkVertex},
    {"EdgesP2", 25, Role::kCells, kVtkQuadraticEdge},
    {"TrianglesP2", 24, Role::kCells, kVtkQuadraticTriangle},
    {"TetrahedraP2", 30, Role::kCells, kVtkQuadraticTetra},
    {"Corners", 13},
    {"Ridges", 14},
    {"RequiredEdges", 16},
    {"RequiredTriangles", 17},
    {"RequiredQuadrilaterals", 18},
    {"TangentAtEdgeVertices", 19},
    {"NormalAtVertices", 20},
    {"NormalAtTriangleVertices", 21},
    {"AngleOfCornerBound", 23},
    {"BoundingBox", 50},
    {"End", 54},
    {"Tangents", 59},
    {"Normals", 60},
    {"TangentAtVertices", 61},
    {"SolAtVertices", 62},
    {"SolAtEdges", 63},
    {"SolAtTriangles", 64},
    {"SolAtQuadrilaterals", 65},
    {"SolAtTetrahedra", 66},
    {"Time", 78},
    {"Iterations", 77},
    {"HexahedraQ2", 33, Role::kUnreadable},
    {"Polyhedra", 46, Role::kUnreadable},
    {"PrismsP2", 86, Role::kUnreadable},
    {"PyramidsP2", 87, Role::kUnreadable},
    {"TetrahedraP3", 96, Role::kUnreadable},
    {"TetrahedraP4", 97, Role::kUnreadable},
    {"HexahedraQ3", 98, Role::kUnreadable},
    {"HexahedraQ4", 99, Role::kUnreadable},
    {"PyramidsP3", 100, Role::kUnreadable},
    {"PyramidsP4", 101, Role::kUnreadable},
    {"PrismsP3", 102, Role::kUnreadable},
    {"PrismsP4", 103, Role::kUnreadable},
    {"Identifier", 0},
    {"Geometry", 0},
    {"SubDomainFromMesh", 0},
    {"SubDomainFromGeom", 29},
}};

constexpr int kDimension = 3;
constexpr int kEnd = 54;

class MeditHeadParser {
 public:
  explicit MeditHeadParser(const FormatFile& file) : file_(file) {}

  MeditHead run() {
    head_.binary = file_.text().starts_with('\1') || file_.text()[0] == '\0';
    if (head_.binary) {
      parse_binary();
    } else {
      parse_text();
    }
    if (head_.vertices.keyword == nullptr) refuse_values();
    return std::move(head_);
  }

 private:
  // A .sol looks like a mesh but for what stands in it.
  [[noreturn]] void refuse_values() const {
    for (const std::string& name : head_.left_out) {
      if (name.starts_with("SolAt")) {
        file_.fail("there are no Vertices but values (" + name +
                   "): a .sol has no mesh, that is the .mesh beside it");
      }
    }
    file_.fail("there are no Vertices");
  }

  void check_version(int version) {
    if (version < 1 || version > 4) {
      file_.fail("MeshVersionFormatted is " + std::to_string(version) + ", expected 1 to 4");
    }
    head_.version = version;
  }

  void check_dimension(std::int64_t dimension) {
    if (dimension == 3) return;
    file_.fail("Dimension is " + std::to_string(dimension) +
               ", expected 3: there are no tetrahedra in the plane");
  }

  void leave_out(const std::string& name) {
    if (names_left_out_.insert(name).second) head_.left_out.push_back(name);
  }

  void take(const MeditSection& section) {
    const MeditKeyword& keyword = *section.keyword;
    if (keyword.role == Role::kVertices) {
      if (head_.vertices.keyword != nullptr) file_.fail("there are two sections Vertices");
      head_.vertices = section;
    } else if (section.rows > 0) {
      head_.cells.push_back(section);
    }
  }

  void refuse_unreadable(const MeditKeyword& keyword, std::uint64_t rows) {
    if (keyword.role != Role::kUnreadable || rows == 0) return;
    file_.fail(std::string(keyword.name) +
               " cannot be read: only Tetrahedra, and with options Hexahedra, Prisms, Pyramids and "
               "TetrahedraP2");
  }

  // ---- text ----

  void parse_text() {
    const std::string_view text = file_.text();
    refuse_others();
    const std::vector<std::string_view> words = find_words(file_.file, text, kMeditComment);
    for (std::size_t w = 0; w < words.size(); ++w) {
      if (words[w] == "End") return;
      const char* const begin = words[w].data() + words[w].size();
      const char* const end =
          w + 1 < words.size() ? words[w + 1].data() : text.data() + text.size();
      parse_section(words[w], {begin, static_cast<std::size_t>(end - begin)});
    }
    do_without_end(words.empty() ? "" : words.back());
  }

  // Some programs do not write it. A section that is not whole is found by its count, but not a
  // number that is, nor whole sections.
  void do_without_end(std::string_view last) {
    if (!is_blank(file_.text().back())) {
      file_.fail(
          "End is missing, and the last line's end: is that all of the file? If so, add a "
          "line End");
    }
    leave_out("whatever stood behind " + std::string(last) +
              ", if the file was cut off there (End is missing)");
  }

  // A file may be called .mesh and be of another program.
  void refuse_others() const {
    constexpr std::string_view kFirstWord = "MeshVersionFormatted";
    const std::string_view first = TokenCursor(file_.text(), kMeditComment).next();
    if (first == kFirstWord) return;
    file_.fail_in_line(first.empty() ? file_.text().data() : first.data(),
                       first == "MFEM" ? "this is a mesh of MFEM, not of Medit: let MFEM write "
                                         "it for VTK (Mesh::PrintVTK)"
                                       : "expected MeshVersionFormatted, with which Medit's "
                                         "files begin, found " +
                                             quoted(first));
  }

  void parse_section(std::string_view word, std::string_view text) {
    TokenCursor cursor(text, kMeditComment);
    const auto whole_number = [&](const char* what) {
      const std::string_view token = cursor.next();
      if (token.empty()) file_.fail_in_line(word.data(), std::string(word) + ": expected " + what);
      return token;
    };
    if (word == "MeshVersionFormatted") {
      return check_version(file_.number<std::int32_t>(whole_number("a version, 1 to 4")));
    }
    if (word == "Dimension") {
      return check_dimension(file_.number<std::int32_t>(whole_number("3")));
    }
    const MeditKeyword* const keyword = find_medit_keyword(word);
    if (keyword == nullptr || keyword->role == Role::kNothing) return leave_out(std::string(word));
    const auto rows = file_.number<std::uint64_t>(whole_number("how many there are"));
    refuse_unreadable(*keyword, rows);
    if (keyword->role == Role::kUnreadable) return;
    const auto left = static_cast<std::size_t>(text.data() + text.size() - cursor.at());
    const auto columns = static_cast<std::uint64_t>(MeditHead::cell_columns(*keyword));
    // A number takes two bytes at least, its blank included.
    if (rows > left / (2 * columns) + 1) {
      file_.fail_in_line(word.data(), std::string(word) + ": " + std::to_string(rows) +
                                          " rows of " + std::to_string(columns) +
                                          " numbers do not fit into the " + std::to_string(left) +
                                          " bytes that follow");
    }
    take({keyword, rows, {cursor.at(), left}});
  }

  // ---- binary ----

  const std::byte* at(std::uint64_t offset, std::size_t bytes, const char* what) const {
    const auto all = file_.file.bytes();
    if (offset > all.size() || bytes > all.size() - offset) {
      file_.fail("the file ends with byte " + std::to_string(all.size()) + ", within " + what);
    }
    return all.data() + offset;
  }
  std::int32_t word(std::uint64_t offset, const char* what) const {
    return load<std::int32_t>(at(offset, 4, what), head_.swapped);
  }
  std::int64_t integer(std::uint64_t offset, std::size_t bytes, const char* what) const {
    const std::byte* from = at(offset, bytes, what);
    return bytes == 8 ? load<std::int64_t>(from, head_.swapped)
                      : load<std::int32_t>(from, head_.swapped);
  }

  void parse_binary() {
    if (word(0, "the head") != 1) {
      head_.swapped = true;
      if (word(0, "the head") != 1) file_.fail("byte 0: expected 1, as in every .meshb file");
    }
    check_version(word(4, "the version"));
    const std::size_t place_bytes = head_.version >= 3 ? 8 : 4;
    for (std::uint64_t offset = 8;;) {
      const std::int32_t number = word(offset, "a keyword; End is missing");
      if (number == kEnd) return;
      const std::int64_t next = integer(offset + 4, place_bytes, "a keyword");
      const std::uint64_t size = file_.file.size();
      const std::uint64_t begin = offset + 4 + place_bytes;
      const std::uint64_t end = next == 0 ? size : static_cast<std::uint64_t>(next);
      if (end < begin || end > size) {
        file_.fail_at_byte(at(offset + 4, 4, "a keyword"),
                           "the next keyword is said to be at byte " + std::to_string(next) +
                               ", expected " + std::to_string(begin) + " to " +
                               std::to_string(size));
      }
      parse_binary_section(number, begin, end);
      if (next == 0) return;
      offset = end;
    }
  }

  void parse_binary_section(int number, std::uint64_t begin, std::uint64_t end) {
    if (number == kDimension) return check_dimension(word(begin, "Dimension"));
    const MeditKeyword* const keyword = find_medit_keyword(number);
    if (keyword == nullptr || keyword->role == Role::kNothing) {
      return leave_out(keyword != nullptr ? std::string(keyword->name)
                                          : "keyword " + std::to_string(number));
    }
    const std::int64_t rows = integer(begin, head_.integer_bytes(), "a number of rows");
    begin += head_.integer_bytes();
    refuse_unreadable(*keyword, static_cast<std::uint64_t>(rows));
    if (keyword->role == Role::kUnreadable) return;
    const std::size_t row = head_.row_bytes(*keyword);
    if (rows < 0 || begin > end || static_cast<std::uint64_t>(rows) > (end - begin) / row) {
      file_.fail_at_byte(at(begin - head_.integer_bytes(), 4, "a number of rows"),
                         std::string(keyword->name) + ": " + std::to_string(rows) + " rows of " +
                             std::to_string(row) + " bytes do not fit before byte " +
                             std::to_string(end));
    }
    const auto count = static_cast<std::uint64_t>(rows);
    take({keyword, count, file_.text().substr(begin, count * row)});
  }

  const FormatFile& file_;
  MeditHead head_;
  std::set<std::string> names_left_out_;
};

}  // namespace

const MeditKeyword* find_medit_keyword(int number) {
  const auto found = std::find_if(kKeywords.begin(), kKeywords.end(), [&](const MeditKeyword& k) {
    return k.number == number && number != 0;
  });
  return found == kKeywords.end() ? nullptr : &*found;
}

const MeditKeyword* find_medit_keyword(std::string_view name) {
  const auto found = std::find_if(kKeywords.begin(), kKeywords.end(),
                                  [&](const MeditKeyword& k) { return k.name == name; });
  return found == kKeywords.end() ? nullptr : &*found;
}

int MeditHead::cell_columns(const MeditKeyword& keyword) {
  if (keyword.role == Role::kVertices) return 4;
  return vtk_cell_size(keyword.type) + (keyword.role == Role::kCells ? 1 : 0);
}

std::size_t MeditHead::row_bytes(const MeditKeyword& keyword) const {
  if (keyword.role == Role::kVertices) return 3 * real_bytes() + integer_bytes();
  return static_cast<std::size_t>(cell_columns(keyword)) * integer_bytes();
}

bool looks_like_medit(std::string_view text) {
  for (const bool swapped : {false, true}) {
    if (text.size() < 12) break;
    const auto word = [&](std::size_t i) {
      return load<std::int32_t>(reinterpret_cast<const std::byte*>(text.data()) + 4 * i, swapped);
    };
    if (word(0) == 1 && word(1) >= 1 && word(1) <= 4 && word(2) == kDimension) return true;
  }
  return TokenCursor(text.substr(0, 4096), kMeditComment).next() == "MeshVersionFormatted";
}

MeditHead parse_medit_head(const FormatFile& file) { return MeditHeadParser(file).run(); }

}  // namespace tetfusion
