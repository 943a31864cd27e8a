#include "io/tetgen/tetgen_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <variant>

#include "io/files/output_file.h"
#include "io/formats/suffix.h"
#include "io/formats/text_rows.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

constexpr std::size_t kNone = MeshPasses::kNone;

class TetgenWriter {
 public:
  explicit TetgenWriter(MeshPasses* mesh) : mesh_(*mesh) {
    const MeshDescription& d = mesh_.description();
    point_array_ = find_point_labels(d.point_data, kTetgenReference);
    cell_array_ = mesh_.cell_labels();
    for (std::size_t i = 0; i < d.point_data.arrays.size(); ++i) {
      if (has_tetgen_attributes(d.point_data.arrays[i])) attributes_.push_back(i);
    }
  }

  void put_nodes(OutputFile* file) {
    std::uint64_t columns = 0;
    std::string names;
    std::vector<std::size_t> arrays = attributes_;
    for (const std::size_t i : attributes_) {
      const ArrayInfo& info = point_info(i);
      columns += info.components;
      names += fmt::format("{} {}", names.empty() ? "" : ",", info.name);
      if (info.components > 1) names += fmt::format(" ({} values)", info.components);
    }
    if (!names.empty()) put_text(fmt::format("# attributes:{}\n", on_one_line(names)), file);
    put_text(fmt::format("{} 3 {} {}\n", mesh_.points(), columns, point_array_ != kNone ? 1 : 0),
             file);
    if (point_array_ != kNone) arrays.push_back(point_array_);
    mesh_.for_each_points(arrays, [&](std::uint64_t first, const Points& points,
                                      const std::vector<Vector<std::byte>>& rows) {
      put_node_window(first, points, rows, file);
    });
  }

  void put_tets(OutputFile* file) {
    const bool has_attribute = cell_array_ != kNone;
    put_text(fmt::format("{} 4 {}\n", mesh_.tets(), has_attribute ? 1 : 0), file);
    mesh_.for_each_tets({cell_array_}, [&](std::uint64_t first, const Vector<Tet>& tets,
                                           const std::vector<Vector<std::byte>>& rows) {
      Vector<double> numbers;
      Vector<std::int64_t> regions;
      if (has_attribute && is_whole()) regions = whole_numbers(rows[0]);
      if (has_attribute && !is_whole()) numbers = to_doubles(info().type, rows[0]);
      put_text_rows(tets.size(), file, [&](std::size_t i, TextRow* row) {
        row->add(first + i + 1);
        for (const VertexId v : tets[i]) row->add(std::uint64_t{v} + 1);
        if (!has_attribute) return;
        is_whole() ? row->add(regions[i]) : row->add(numbers[i]);
      });
    });
  }

  void put_sides(std::uint8_t type, OutputFile* file) {
    const Vector<std::uint64_t> cells = mesh_.lower_of_type(type);
    const LowerCells& lower = mesh_.lower();
    const bool has_markers = cell_array_ != kNone;
    const Vector<std::int64_t> markers =
        has_markers ? whole_numbers(mesh_.lower_rows(cell_array_)) : Vector<std::int64_t>();
    put_text(fmt::format("{} {}\n", cells.size(), has_markers ? 1 : 0), file);
    put_text_rows(cells.size(), file, [&](std::size_t i, TextRow* row) {
      row->add(std::uint64_t{i} + 1);
      for (std::uint64_t k = lower.offsets[cells[i]]; k < lower.offsets[cells[i] + 1]; ++k) {
        row->add(std::uint64_t{lower.connectivity[k]} + 1);
      }
      if (has_markers) row->add(markers[cells[i]]);
    });
  }

  std::uint64_t rows() const { return mesh_.points() + mesh_.tets(); }

 private:
  const ArrayInfo& point_info(std::size_t i) const {
    return mesh_.description().point_data.arrays[i];
  }
  const ArrayInfo& info() const { return mesh_.description().cell_data.arrays[cell_array_]; }
  bool is_whole() const { return !is_float(info().type) || info().name != kTetgenReference; }
  // Markers of sides are whole in files of tetrahedra whose attributes are not.
  Vector<std::int64_t> whole_numbers(std::span<const std::byte> rows) const {
    if (is_whole()) return to_integers(info(), rows);
    Vector<std::int64_t> whole;
    for (const double x : to_doubles(info().type, rows)) whole.push_back(std::llround(x));
    return whole;
  }
  static std::string on_one_line(std::string text) {
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text;
  }

  void put_node_window(std::uint64_t first, const Points& points,
                       const std::vector<Vector<std::byte>>& rows, OutputFile* file) {
    std::vector<Vector<double>> values;
    for (std::size_t a = 0; a < attributes_.size(); ++a) {
      values.push_back(to_doubles(point_info(attributes_[a]).type, rows[a]));
    }
    Vector<std::int64_t> markers;
    if (point_array_ != kNone) markers = to_integers(point_info(point_array_), rows.back());
    std::visit(
        [&](const auto& xyz) {
          put_text_rows(xyz.size(), file, [&](std::size_t i, TextRow* row) {
            row->add(first + i + 1);
            row->add(double{xyz[i].x}).add(double{xyz[i].y}).add(double{xyz[i].z});
            for (std::size_t a = 0; a < attributes_.size(); ++a) {
              const std::size_t width = point_info(attributes_[a]).components;
              for (std::size_t k = 0; k < width; ++k) row->add(values[a][i * width + k]);
            }
            if (point_array_ != kNone) row->add(markers[i]);
          });
        },
        points);
  }

  MeshPasses& mesh_;
  std::size_t point_array_ = kNone;
  std::size_t cell_array_ = kNone;
  std::vector<std::size_t> attributes_;
};

}  // namespace

bool has_tetgen_attributes(const ArrayInfo& info) { return is_float(info.type); }

std::vector<std::string> tetgen_files(const std::string& path) {
  std::vector<std::string> names;
  for (const char* extension : {".node", ".face", ".edge", ".ele"}) {
    names.push_back(with_suffix(path, extension));
  }
  return names;
}

void write_tetgen(MeshPasses* mesh, const std::string& path,
                  const std::function<void(double)>& progress) {
  const std::vector<std::string> names = tetgen_files(path);
  OutputFile nodes(names[0]), faces(names[1]), edges(names[2]), tets(names[3]);
  TetgenWriter writer(mesh);
  mesh->expect(writer.rows(), progress);
  writer.put_nodes(&nodes);
  writer.put_tets(&tets);
  writer.put_sides(kVtkTriangle, &faces);
  writer.put_sides(kVtkLine, &edges);
  const std::array<OutputFile*, 4> files{&nodes, &faces, &edges, &tets};
  for (OutputFile* file : files) file->finish();
  for (OutputFile* file : files) file->commit();
}

}  // namespace tetfusion
