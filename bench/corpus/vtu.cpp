#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>

#include "mesh.h"

namespace corpus {

namespace {

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\t':
        out += "&#9;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string unescaped(std::string text) {
  static const std::vector<std::pair<std::string, std::string>> kNames{
      {"&lt;", "<"},  {"&gt;", ">"},   {"&quot;", "\""}, {"&apos;", "'"},
      {"&#9;", "\t"}, {"&#x9;", "\t"}, {"&amp;", "&"}};
  for (const auto& [name, value] : kNames) {
    for (std::size_t at = 0; (at = text.find(name, at)) != std::string::npos; at += value.size()) {
      text.replace(at, name.size(), value);
    }
  }
  return text;
}

class Writer {
 public:
  void add(const Array& array, const std::string& extra = "") {
    head_ << "<DataArray type=\"" << array.type << "\" Name=\"" << escaped(array.name)
          << "\" NumberOfComponents=\"" << array.components << "\"" << extra
          << " format=\"appended\" offset=\"" << data_.size() << "\"/>\n";
    const std::uint64_t size = array.bytes.size();
    data_.append(reinterpret_cast<const char*>(&size), sizeof size);
    data_ += array.bytes;
  }
  void section(const std::string& tag, const std::vector<Array>& arrays) {
    head_ << "<" << tag << ">\n";
    for (const Array& array : arrays) add(array);
    head_ << "</" << tag << ">\n";
  }
  std::ostringstream head_;
  std::string data_;
};

Array coordinates(const Mesh& mesh) {
  if (!mesh.floats) return make_array("Points", "Float64", 3, mesh.points);
  std::vector<float> values;
  for (const Point& p : mesh.points) {
    for (const double c : p) values.push_back(static_cast<float>(c));
  }
  return make_array("Points", "Float32", 3, values);
}

// What a file holds between two places.
class Reader {
 public:
  explicit Reader(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    file_.assign(std::istreambuf_iterator<char>(in), {});
    data_ = file_.find("<AppendedData");
    if (data_ == std::string::npos) throw std::runtime_error("no appended data");
    head_ = file_.substr(0, data_);
    data_ = file_.find('_', data_) + 1;
  }

  std::string attribute(const std::string& tag, const std::string& name) const {
    const std::string key = " " + name + "=\"";
    const std::size_t at = tag.find(key);
    if (at == std::string::npos) throw std::runtime_error("no attribute " + name);
    const std::size_t begin = at + key.size();
    return unescaped(tag.substr(begin, tag.find('"', begin) - begin));
  }

  std::string tag(const std::string& name) const {
    const std::size_t at = head_.find("<" + name);
    if (at == std::string::npos) throw std::runtime_error("no element " + name);
    return head_.substr(at, head_.find('>', at) - at);
  }

  std::vector<Array> section(const std::string& name) const {
    std::vector<Array> arrays;
    const std::size_t begin = head_.find("<" + name);
    if (begin == std::string::npos) return arrays;
    const std::size_t end = head_.find("</" + name + ">", begin);
    for (std::size_t at = begin; (at = head_.find("<DataArray", at)) < end; ++at) {
      arrays.push_back(array(head_.substr(at, head_.find('>', at) - at)));
    }
    return arrays;
  }

 private:
  Array array(const std::string& tag) const {
    Array result{attribute(tag, "Name"), attribute(tag, "type"), 1, ""};
    if (tag.find(" NumberOfComponents=") != std::string::npos) {
      result.components = std::stoull(attribute(tag, "NumberOfComponents"));
    }
    const std::size_t at = data_ + std::stoull(attribute(tag, "offset"));
    std::uint64_t size = 0;
    if (at + sizeof size > file_.size()) throw std::runtime_error("data is cut off");
    std::memcpy(&size, file_.data() + at, sizeof size);
    if (size > file_.size() - at - sizeof size) throw std::runtime_error("data is cut off");
    result.bytes = file_.substr(at + sizeof size, size);
    return result;
  }

  std::string file_, head_;
  std::size_t data_ = 0;
};

void take_cells(const Reader& reader, std::size_t cells, Mesh* mesh) {
  const std::vector<Array> parts = reader.section("Cells");
  const Array *ids = find(parts, "connectivity"), *ends = find(parts, "offsets"),
              *types = find(parts, "types");
  if (ids == nullptr || ends == nullptr || types == nullptr) throw std::runtime_error("no cells");
  if (ends->rows() != cells || types->rows() != cells) throw std::runtime_error("cells are lost");
  std::size_t begin = 0;
  for (std::size_t c = 0; c < cells; ++c) {
    const auto end = static_cast<std::size_t>(ends->value(c));
    if (end < begin || end > ids->rows()) throw std::runtime_error("bad offsets");
    LowerCell cell{static_cast<int>(types->value(c)), {}};
    for (std::size_t i = begin; i < end; ++i) {
      const double id = ids->value(i);
      if (!(id >= 0 && id < static_cast<double>(mesh->points.size()))) {
        throw std::runtime_error("an id is out of range");
      }
      cell.corners.push_back(static_cast<std::int64_t>(id));
    }
    begin = end;
    if (cell.type != 10) {
      mesh->lower.push_back(cell);
      continue;
    }
    if (cell.corners.size() != 4 || !mesh->lower.empty()) throw std::runtime_error("bad cells");
    mesh->tets.push_back({cell.corners[0], cell.corners[1], cell.corners[2], cell.corners[3]});
  }
  if (begin != ids->rows()) throw std::runtime_error("ids are left over");
}

void require_rows(const std::vector<Array>& arrays, std::size_t rows) {
  for (const Array& a : arrays) {
    if (a.bytes.size() != rows * a.row_bytes()) {
      throw std::runtime_error("array " + a.name + " has " + std::to_string(a.rows()) +
                               " rows, not " + std::to_string(rows));
    }
  }
}

}  // namespace

std::size_t bytes_of_type(const std::string& type) {
  if (type.ends_with("64")) return 8;
  if (type.ends_with("32")) return 4;
  return type.ends_with("16") ? 2 : 1;
}

std::size_t Array::row_bytes() const { return components * bytes_of_type(type); }

double Array::value(std::size_t i) const {
  const auto get = [&](auto zero) {
    std::memcpy(&zero, bytes.data() + i * sizeof zero, sizeof zero);
    return static_cast<double>(zero);
  };
  if (type == "Float32") return get(float{});
  if (type == "Float64") return get(double{});
  const bool sign = type[0] == 'I';
  switch (bytes_of_type(type)) {
    case 8:
      return sign ? get(std::int64_t{}) : get(std::uint64_t{});
    case 4:
      return sign ? get(std::int32_t{}) : get(std::uint32_t{});
    case 2:
      return sign ? get(std::int16_t{}) : get(std::uint16_t{});
    default:
      return sign ? get(std::int8_t{}) : get(std::uint8_t{});
  }
}

const Array* find(const std::vector<Array>& arrays, const std::string& name) {
  for (const Array& a : arrays) {
    if (a.name == name) return &a;
  }
  return nullptr;
}

void write_vtu(const Mesh& mesh, const std::string& path) {
  std::vector<std::int64_t> ids, ends;
  std::vector<std::uint8_t> types;
  const auto add = [&](std::uint8_t type, const auto& corners) {
    ids.insert(ids.end(), corners.begin(), corners.end());
    ends.push_back(static_cast<std::int64_t>(ids.size()));
    types.push_back(type);
  };
  for (const Tet& t : mesh.tets) add(10, t);
  for (const LowerCell& c : mesh.lower) add(static_cast<std::uint8_t>(c.type), c.corners);
  Writer w;
  w.head_ << "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
             "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n";
  if (!mesh.field_arrays.empty()) {
    w.head_ << "<FieldData>\n";
    for (const Array& a : mesh.field_arrays) {
      w.add(a, " NumberOfTuples=\"" + std::to_string(a.rows()) + "\"");
    }
    w.head_ << "</FieldData>\n";
  }
  w.head_ << "<Piece NumberOfPoints=\"" << mesh.points.size() << "\" NumberOfCells=\""
          << mesh.cells() << "\">\n";
  w.section("PointData", mesh.point_arrays);
  w.section("CellData", mesh.cell_arrays);
  w.section("Points", {coordinates(mesh)});
  w.section("Cells",
            {make_array("connectivity", "Int64", 1, ids), make_array("offsets", "Int64", 1, ends),
             make_array("types", "UInt8", 1, types)});
  w.head_ << "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
  std::ofstream out(path, std::ios::binary);
  out << w.head_.str() << w.data_ << "\n</AppendedData></VTKFile>\n";
  if (!out) throw std::runtime_error("cannot write " + path);
}

Mesh read_vtu(const std::string& path) {
  const Reader reader(path);
  const std::string piece = reader.tag("Piece");
  const std::size_t points = std::stoull(reader.attribute(piece, "NumberOfPoints"));
  const std::size_t cells = std::stoull(reader.attribute(piece, "NumberOfCells"));
  Mesh mesh;
  const Array places = reader.section("Points").at(0);
  require_rows({places}, points);
  mesh.floats = places.type == "Float32";
  for (std::size_t i = 0; i < points; ++i) {
    mesh.points.push_back({places.value(3 * i), places.value(3 * i + 1), places.value(3 * i + 2)});
  }
  take_cells(reader, cells, &mesh);
  mesh.point_arrays = reader.section("PointData");
  mesh.cell_arrays = reader.section("CellData");
  mesh.field_arrays = reader.section("FieldData");
  require_rows(mesh.point_arrays, points);
  require_rows(mesh.cell_arrays, cells);
  return mesh;
}

}  // namespace corpus
