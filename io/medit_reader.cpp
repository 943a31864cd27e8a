#include "io/medit_reader.h"

#include <array>
#include <string>
#include <utility>

#include "io/byte_values.h"
#include "io/format_file.h"
#include "io/format_source.h"
#include "io/guarded_reading.h"
#include "io/medit_head.h"
#include "io/text_tokens.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

constexpr std::size_t kRowsPerBlock = 65536;

class MeditReader final : public FormatReader {
 public:
  explicit MeditReader(MappedFile file) : file_{std::move(file)} {
    read_guarded(file_.file, [&] { head_ = parse_medit_head(file_); });
    describe();
  }

  const MeshDescription& description() const override { return description_; }

  CellTypeCounts cell_types() const override {
    CellTypeCounts counts{};
    for (const MeditSection& section : head_.cells) counts[section.keyword->type] += section.rows;
    return counts;
  }

  Points read_points() const override {
    Points points;
    read_guarded(file_.file, [&] {
      if (head_.float_coordinates()) {
        points = read_vertices<float>();
      } else {
        points = read_vertices<double>();
      }
    });
    return points;
  }

  ListedCells read_cells() const override {
    ListedCells cells;
    read_guarded(file_.file, [&] {
      std::uint64_t ids = 0;
      for (const MeditSection& section : head_.cells) ids += section.rows * corners(section);
      cells.ids.resize(ids);
      cells.types.reserve(description_.cells);
      VertexId* out = cells.ids.data();
      for (const MeditSection& section : head_.cells) {
        cells.types.insert(cells.types.end(), section.rows, section.keyword->type);
        read_corners(section, out);
        out += section.rows * corners(section);
      }
    });
    return cells;
  }

  DataArray read_array(Association association, std::size_t index) const override {
    DataArray array;
    array.info =
        (association == Association::kPoint ? description_.point_data : description_.cell_data)
            .arrays.at(index);
    array.bytes.resize(array.info.values() * size_of(array.info.type));
    read_guarded(file_.file, [&] {
      if (head_.long_integers()) {
        read_references(association, array.as<std::int64_t>().data());
      } else {
        read_references(association, array.as<std::int32_t>().data());
      }
    });
    return array;
  }

 private:
  static std::size_t corners(const MeditSection& section) {
    return static_cast<std::size_t>(vtk_cell_size(section.keyword->type));
  }
  static bool has_references(const MeditSection& section) {
    return section.keyword->role != MeditKeyword::Role::kPoints;
  }

  void describe() {
    MeshDescription& d = description_;
    d.path = file_.file.path();
    d.format = std::string("Medit mesh, ") + (head_.binary ? "binary" : "text") + ", version " +
               std::to_string(head_.version);
    for (std::size_t i = 0; i < head_.left_out.size(); ++i) {
      d.format += (i == 0 ? "; left out: " : ", ") + head_.left_out[i];
    }
    d.points = head_.vertices.rows;
    for (const MeditSection& section : head_.cells) d.cells += section.rows;
    d.point_type = head_.float_coordinates() ? ValueType::kFloat32 : ValueType::kFloat64;
    d.file_bytes = file_.file.size();
    d.spooled_checksum = file_.file.spooled_checksum();
    const ValueType type = head_.long_integers() ? ValueType::kInt64 : ValueType::kInt32;
    d.point_data.arrays.push_back({kMeditReference, type, 1, {}, d.points});
    d.cell_data.arrays.push_back({kMeditReference, type, 1, {}, d.cells});
    if (d.cells == 0) file_.fail("the mesh has no cells");
    if (d.points > kMaxPoints) {
      file_.fail(ErrorCode::kMemory,
                 std::to_string(d.points) + " points are more than can be held in memory at once");
    }
  }

  // Calls f(row, column, token) for the numbers of a section in a text, which must be all there.
  template <class F>
  void for_each_token(const MeditSection& section, F f) const {
    const auto columns = static_cast<std::uint64_t>(MeditHead::cell_columns(*section.keyword));
    const TextTokens tokens(section.text, kMeditComment);
    const std::uint64_t expected = section.rows * columns;
    if (tokens.size() != expected) {
      const std::string_view surplus = tokens[expected];
      file_.fail_in_line(
          surplus.empty() ? section.text.data() + section.text.size() : surplus.data(),
          std::string(section.keyword->name) + ": expected " + std::to_string(section.rows) +
              " rows of " + std::to_string(columns) + " numbers, found " +
              std::to_string(tokens.size()) + " numbers");
    }
    tokens.for_each(columns, f);
  }

  // Calls f(row, bytes) for the rows of a binary section.
  template <class F>
  void for_each_row(const MeditSection& section, F f) const {
    const std::size_t bytes = head_.row_bytes(*section.keyword);
    const auto* const from = reinterpret_cast<const std::byte*>(section.text.data());
    for_each_block(section.rows, kRowsPerBlock,
                   [&](std::size_t, std::size_t begin, std::size_t end) {
                     for (std::size_t row = begin; row < end; ++row) f(row, from + row * bytes);
                   });
  }

  std::int64_t load_integer(const std::byte* from) const {
    return head_.long_integers() ? load<std::int64_t>(from, head_.swapped)
                                 : load<std::int32_t>(from, head_.swapped);
  }

  template <class Real>
  Points read_vertices() const {
    Vector<Vec3<Real>> points(head_.vertices.rows);
    if (head_.binary) {
      for_each_row(head_.vertices, [&](std::size_t row, const std::byte* from) {
        points[row] = {load<Real>(from, head_.swapped),
                       load<Real>(from + sizeof(Real), head_.swapped),
                       load<Real>(from + 2 * sizeof(Real), head_.swapped)};
      });
    } else {
      for_each_token(head_.vertices,
                     [&](std::uint64_t row, std::uint64_t column, std::string_view token) {
                       if (column == 3) return;
                       Vec3<Real>& p = points[row];
                       (column == 0 ? p.x : column == 1 ? p.y : p.z) = file_.number<Real>(token);
                     });
    }
    return points;
  }

  std::string wrong_point(const MeditSection& section, std::uint64_t row, std::int64_t id) const {
    return std::string(section.keyword->name) + ", row " + std::to_string(row + 1) +
           ": uses point " + std::to_string(id) + ", but there are points 1 to " +
           std::to_string(description_.points);
  }
  bool is_point(std::int64_t id) const {
    return id >= 1 && static_cast<std::uint64_t>(id) <= description_.points;
  }

  void read_corners(const MeditSection& section, VertexId* out) const {
    const std::size_t width = corners(section);
    if (head_.binary) {
      for_each_row(section, [&](std::size_t row, const std::byte* from) {
        for (std::size_t k = 0; k < width; ++k) {
          const std::byte* const place = from + k * head_.integer_bytes();
          const std::int64_t id = load_integer(place);
          if (!is_point(id)) file_.invalid_at_byte(place, wrong_point(section, row, id));
          out[row * width + k] = static_cast<VertexId>(id - 1);
        }
      });
    } else {
      for_each_token(section, [&](std::uint64_t row, std::uint64_t column, std::string_view token) {
        if (column == width) return;
        const auto id = file_.number<std::int64_t>(token);
        if (!is_point(id)) file_.invalid_in_line(token.data(), wrong_point(section, row, id));
        out[row * width + column] = static_cast<VertexId>(id - 1);
      });
    }
    turn_wedges(section, out);
  }

  // Medit sees the first triangle of a prism from inside, VTK from outside.
  static void turn_wedges(const MeditSection& section, VertexId* ids) {
    if (section.keyword->type != kVtkWedge) return;
    for (std::uint64_t row = 0; row < section.rows; ++row, ids += 6) {
      std::swap(ids[1], ids[2]);
      std::swap(ids[4], ids[5]);
    }
  }

  template <class Int>
  void read_references(Association association, Int* out) const {
    if (association == Association::kPoint) return read_column(head_.vertices, out);
    for (const MeditSection& section : head_.cells) {
      if (has_references(section)) {
        read_column(section, out);
      } else {
        std::fill_n(out, section.rows, Int{0});
      }
      out += section.rows;
    }
  }

  // The last one.
  template <class Int>
  void read_column(const MeditSection& section, Int* out) const {
    if (head_.binary) {
      const std::size_t place = head_.row_bytes(*section.keyword) - sizeof(Int);
      for_each_row(section, [&](std::size_t row, const std::byte* from) {
        out[row] = load<Int>(from + place, head_.swapped);
      });
    } else {
      const auto last = static_cast<std::uint64_t>(MeditHead::cell_columns(*section.keyword)) - 1;
      for_each_token(section, [&](std::uint64_t row, std::uint64_t column, std::string_view token) {
        if (column == last) out[row] = file_.number<Int>(token);
      });
    }
  }

  FormatFile file_;
  MeditHead head_;
  MeshDescription description_;
};

}  // namespace

std::unique_ptr<MeshSource> open_medit(MappedFile file, const OpenOptions& options) {
  return make_source(std::make_unique<MeditReader>(std::move(file)), options);
}

}  // namespace tetfusion
