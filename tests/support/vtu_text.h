// Writes small .vtu files in every encoding, without the project's own writer: the reader's tests
// must not believe what they test.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tetfusion::testing {

struct VtuArrayText {
  std::string name;
  std::string type;  // "Float32", "Int64", ...
  std::vector<double> values;
  unsigned components = 1;
  std::string attributes;  // added to the tag: " ComponentName0=\"X\""
  std::string tag = "DataArray";
  std::string keys = {};  // InformationKeys inside it
};

// As VTK writes it, with blanks round the text.
std::string information_key(const std::string& name, const std::string& text);

struct VtuPieceText {
  std::uint64_t points = 0;
  std::uint64_t cells = 0;
  VtuArrayText coordinates;
  VtuArrayText connectivity;
  VtuArrayText offsets;
  VtuArrayText types;
  std::vector<VtuArrayText> point_data;
  std::vector<VtuArrayText> cell_data;
  std::string point_attributes;  // " Scalars=\"d\""
  std::string cell_attributes;
};

struct VtuText {
  std::vector<VtuPieceText> pieces;
  std::vector<VtuArrayText> field_data;
};

enum class VtuData { kAppendedRaw, kAppendedBase64, kInline, kAscii };

struct VtuStyle {
  VtuData data = VtuData::kAppendedRaw;
  std::string compressor;              // "", "vtkZLibDataCompressor", ...
  std::string header_type = "UInt64";  // "": the attribute is left out, which means UInt32
  bool big_endian = false;
  std::size_t block_bytes = 32;  // of compressed arrays
  std::string version = "1.0";
};

std::string to_vtu(const VtuText& mesh, const VtuStyle& style);
std::string describe(const VtuStyle& style);  // for messages

// A piece of tetrahedra.
VtuPieceText tet_piece(const std::vector<double>& coordinates, const std::vector<double>& ids,
                       const std::string& point_type = "Float64",
                       const std::string& index_type = "Int64");

// A piece of any cells: types and the vertices of each.
VtuPieceText cell_piece(const std::vector<double>& coordinates, const std::vector<double>& types,
                        const std::vector<std::vector<double>>& cells);

void write_file(const std::string& path, const std::string& bytes);

}  // namespace tetfusion::testing
