#include "support/vtu_text.h"

#include <lz4.h>
#include <lzma.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace tetfusion::testing {

namespace {

template <class T>
std::string value_bytes(double value, bool big_endian) {
  const T v = static_cast<T>(value);
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &v, sizeof(T));
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

std::string typed_bytes(const std::string& type, double value, bool big) {
  if (type == "Int8") return value_bytes<std::int8_t>(value, big);
  if (type == "UInt8" || type == "String") return value_bytes<std::uint8_t>(value, big);
  if (type == "Int16") return value_bytes<std::int16_t>(value, big);
  if (type == "UInt16") return value_bytes<std::uint16_t>(value, big);
  if (type == "Int32") return value_bytes<std::int32_t>(value, big);
  if (type == "UInt32") return value_bytes<std::uint32_t>(value, big);
  if (type == "Int64") return value_bytes<std::int64_t>(value, big);
  if (type == "UInt64") return value_bytes<std::uint64_t>(value, big);
  if (type == "Float32") return value_bytes<float>(value, big);
  if (type == "Float64") return value_bytes<double>(value, big);
  throw std::logic_error("unknown type " + type);
}

std::string base64(const std::string& bytes) {
  static constexpr char kAlphabet[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      out += i + k > bytes.size() ? '=' : kAlphabet[group >> (18 - 6 * k) & 63];
    }
  }
  return out;
}

std::string compress(const std::string& compressor, const std::string& block) {
  std::string out(2 * block.size() + 1024, '\0');
  std::size_t size = 0;
  if (compressor == "vtkZLibDataCompressor") {
    uLongf length = out.size();
    compress2(reinterpret_cast<Bytef*>(out.data()), &length,
              reinterpret_cast<const Bytef*>(block.data()), block.size(), 6);
    size = length;
  } else if (compressor == "vtkLZ4DataCompressor") {
    size = static_cast<std::size_t>(LZ4_compress_default(
        block.data(), out.data(), static_cast<int>(block.size()), static_cast<int>(out.size())));
  } else if (compressor == "vtkLZMADataCompressor") {
    lzma_easy_buffer_encode(0, LZMA_CHECK_CRC32, nullptr,
                            reinterpret_cast<const std::uint8_t*>(block.data()), block.size(),
                            reinterpret_cast<std::uint8_t*>(out.data()), &size, out.size());
  } else {
    return block;
  }
  out.resize(size);
  return out;
}

class Maker {
 public:
  Maker(const VtuText& mesh, const VtuStyle& style) : mesh_(mesh), style_(style) {}

  std::string run() {
    out_ << "<?xml version=\"1.0\"?>\n<!-- made by a test, with a > and a < in it -->\n"
         << "<VTKFile type=\"UnstructuredGrid\" version=\"" << style_.version << "\" byte_order=\""
         << (style_.big_endian ? "BigEndian" : "LittleEndian") << "\"";
    if (!style_.header_type.empty()) out_ << " header_type=\"" << style_.header_type << "\"";
    if (!style_.compressor.empty()) out_ << " compressor=\"" << style_.compressor << "\"";
    out_ << ">\n<UnstructuredGrid>\n<FieldData>\n";
    for (const VtuArrayText& a : mesh_.field_data) array(a);
    out_ << "</FieldData>\n";
    for (const VtuPieceText& p : mesh_.pieces) piece(p);
    out_ << "</UnstructuredGrid>\n";
    if (style_.data == VtuData::kAppendedRaw || style_.data == VtuData::kAppendedBase64) {
      out_ << "<AppendedData encoding=\""
           << (style_.data == VtuData::kAppendedRaw ? "raw" : "base64") << "\">\n   _" << appended_
           << "\n</AppendedData>\n";
    }
    out_ << "</VTKFile>\n";
    return out_.str();
  }

 private:
  void piece(const VtuPieceText& p) {
    out_ << "<Piece NumberOfPoints=\"" << p.points << "\" NumberOfCells=\"" << p.cells << "\">\n";
    out_ << "<PointData" << p.point_attributes << ">\n";
    for (const VtuArrayText& a : p.point_data) array(a);
    out_ << "</PointData>\n<CellData" << p.cell_attributes << ">\n";
    for (const VtuArrayText& a : p.cell_data) array(a);
    out_ << "</CellData>\n<Points>\n";
    if (!p.coordinates.type.empty()) array(p.coordinates);
    out_ << "</Points>\n<Cells>\n";
    for (const VtuArrayText* a : {&p.connectivity, &p.offsets, &p.types}) {
      if (!a->type.empty()) array(*a);
    }
    out_ << "</Cells>\n</Piece>\n";
  }

  void array(const VtuArrayText& a) {
    out_ << "<" << a.tag << " type=\"" << a.type << "\" Name=\"" << a.name << "\"";
    if (a.components != 1) out_ << " NumberOfComponents=\"" << a.components << "\"";
    out_ << a.attributes;
    switch (style_.data) {
      case VtuData::kAppendedRaw:
      case VtuData::kAppendedBase64:
        out_ << " format=\"appended\" offset=\"" << appended_.size() << "\"";
        out_ << (a.keys.empty() ? "/>\n" : ">" + a.keys + "</" + a.tag + ">\n");
        appended_ += binary(a);
        return;
      case VtuData::kInline:
        out_ << " format=\"binary\">\n  " << binary(a) << "\n";
        break;
      case VtuData::kAscii:
        out_ << " format=\"ascii\">\n";
        out_.precision(17);
        for (const double v : a.values) out_ << " " << v;
        out_ << "\n";
        break;
    }
    // As VTK writes it, after the data.
    out_ << "<InformationKey name=\"L2_NORM_RANGE\" location=\"vtkDataArray\"><Value index=\"0\">"
         << "1.5</Value></InformationKey>\n"
         << a.keys << "</" << a.tag << ">\n";
  }

  std::string number(std::size_t value) const {
    return typed_bytes(style_.header_type == "UInt64" ? "UInt64" : "UInt32",
                       static_cast<double>(value), style_.big_endian);
  }

  std::string binary(const VtuArrayText& a) const {
    std::string data;
    for (const double v : a.values) data += typed_bytes(a.type, v, style_.big_endian);
    const bool text = style_.data != VtuData::kAppendedRaw;
    if (style_.compressor.empty()) {
      const std::string all = number(data.size()) + data;
      return text ? base64(all) : all;
    }
    std::string sizes;
    std::string blocks;
    std::size_t count = 0;
    for (std::size_t at = 0; at < data.size(); at += style_.block_bytes, ++count) {
      const std::string block = compress(style_.compressor, data.substr(at, style_.block_bytes));
      sizes += number(block.size());
      blocks += block;
    }
    const std::string header = number(count) + number(style_.block_bytes) +
                               number(data.size() % style_.block_bytes) + sizes;
    return text ? base64(header) + base64(blocks) : header + blocks;
  }

  const VtuText& mesh_;
  const VtuStyle& style_;
  std::ostringstream out_;
  std::string appended_;
};

}  // namespace

std::string information_key(const std::string& name, const std::string& text) {
  return "<InformationKey name=\"" + name + "\" location=\"vtkDataArray\">\n  " + text +
         "\n</InformationKey>\n";
}

std::string to_vtu(const VtuText& mesh, const VtuStyle& style) { return Maker(mesh, style).run(); }

std::string describe(const VtuStyle& style) {
  constexpr const char* kNames[] = {"appended raw", "appended base64", "inline", "ascii"};
  return std::string(kNames[static_cast<std::size_t>(style.data)]) + ", compressor '" +
         style.compressor + "', header '" + style.header_type + "'" +
         (style.big_endian ? ", big-endian" : "");
}

VtuPieceText tet_piece(const std::vector<double>& coordinates, const std::vector<double>& ids,
                       const std::string& point_type, const std::string& index_type) {
  VtuPieceText p;
  p.points = coordinates.size() / 3;
  p.cells = ids.size() / 4;
  p.coordinates = {"Points", point_type, coordinates, 3, "", "DataArray"};
  p.connectivity = {"connectivity", index_type, ids, 1, "", "DataArray"};
  p.offsets = {"offsets", index_type, {}, 1, "", "DataArray"};
  for (std::uint64_t c = 0; c < p.cells; ++c) {
    p.offsets.values.push_back(4.0 * static_cast<double>(c + 1));
  }
  p.types = {"types", "UInt8", std::vector<double>(p.cells, 10), 1, "", "DataArray"};
  return p;
}

VtuPieceText cell_piece(const std::vector<double>& coordinates, const std::vector<double>& types,
                        const std::vector<std::vector<double>>& cells) {
  VtuPieceText p = tet_piece(coordinates, {});
  p.cells = cells.size();
  for (const std::vector<double>& cell : cells) {
    p.connectivity.values.insert(p.connectivity.values.end(), cell.begin(), cell.end());
    p.offsets.values.push_back(static_cast<double>(p.connectivity.values.size()));
  }
  p.types.values = types;
  return p;
}

void write_file(const std::string& path, const std::string& bytes) {
  // A new file each time: some file systems wait for the disk when an old one is overwritten.
  std::filesystem::remove(path);
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!out.flush()) throw std::runtime_error("cannot write " + path);
}

}  // namespace tetfusion::testing
