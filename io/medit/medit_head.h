// What a Medit mesh consists of (.mesh, .meshb; libMeshb calls it GMF), and where in the file.
//
//   MeshVersionFormatted 2      1: coordinates are floats; 2 to 4: doubles
//   Dimension 3
//   Vertices                    keyword, how many, a row for each: x y z reference
//   8
//   0 0 0 1 ...
//   Tetrahedra                  corners, counted from 1, and a reference
//   ...
//   End
//
// Binary: 1 (it shows the byte order), the version, and for each keyword its number, where in the
// file the next one stands, how many rows there are, and these. Integers have 32 bits, with version
// 4 64; those places have 32 bits with versions 1 and 2, else 64.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/formats/format_file.h"

namespace tetfusion {

inline constexpr char kMeditComment = '#';
inline constexpr const char* kMeditReference = "medit:ref";

struct MeditKeyword {
  enum class Role { kNothing, kVertices, kCells, kPoints, kUnreadable };
  std::string_view name;
  int number = 0;  // in binary files
  Role role = Role::kNothing;
  std::uint8_t type = 0;  // VTK's, of kCells and kPoints
};

// Null: this program does not know of it.
const MeditKeyword* find_medit_keyword(int number);
const MeditKeyword* find_medit_keyword(std::string_view name);

struct MeditSection {
  const MeditKeyword* keyword = nullptr;
  std::uint64_t rows = 0;
  std::string_view text;  // of the file, that holds the rows; binary: these, to the byte
};

struct MeditHead {
  bool binary = false;
  bool swapped = false;
  int version = 2;
  MeditSection vertices;
  std::vector<MeditSection> cells;    // in the order of the file
  std::vector<std::string> left_out;  // keywords that are passed over, each once

  bool float_coordinates() const { return version == 1; }
  bool long_integers() const { return version == 4; }
  std::size_t integer_bytes() const { return long_integers() ? 8 : 4; }
  std::size_t real_bytes() const { return float_coordinates() ? 4 : 8; }
  // Numbers of a row: corners, and but for points a reference.
  static int cell_columns(const MeditKeyword& keyword);
  std::size_t row_bytes(const MeditKeyword& keyword) const;
};

bool looks_like_medit(std::string_view text);

// Throws Error(kBadInput). No count is larger than the file can hold.
MeditHead parse_medit_head(const FormatFile& file);

}  // namespace tetfusion
