#include "io/medit/medit_reader.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <system_error>
#include <utility>

#include "io/files/guarded_reading.h"
#include "io/formats/byte_values.h"
#include "io/formats/counted_rows.h"
#include "io/formats/format_file.h"
#include "io/formats/format_source.h"
#include "io/formats/suffix.h"
#include "io/formats/text_tokens.h"
#include "io/medit/medit_head.h"
#include "io/source/cell_kinds.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

constexpr std::size_t kRowsPerBlock = 65536;

class MeditReader final : public FormatReader {
 public:
  explicit MeditReader(MappedFile file) : file_{std::move(file)} {
    read_guarded(file_.file, [&] {
      head_ = parse_medit_head(file_);
      has_floats_ = head_.float_coordinates() && (head_.binary || are_all_floats());
    });
    describe();
  }

  const MeshDescription& description() const override { return description_; }

  CellTypeCounts cell_types() const override {
    CellTypeCounts counts{};
    for (const MeditSection& section : head_.cells) counts[section.keyword->type] += section.rows;
    return counts;
  }

  void read_points(std::uint64_t first, std::uint64_t count, std::byte* out) const override {
    read_guarded(file_.file, [&] {
      if (has_floats_) {
        read_vertices(first, count, reinterpret_cast<Vec3<float>*>(out));
      } else {
        read_vertices(first, count, reinterpret_cast<Vec3<double>*>(out));
      }
    });
  }

  ListedCells read_cells(std::uint64_t first, std::uint64_t count) const override {
    ListedCells cells;
    read_guarded(file_.file, [&] {
      std::uint64_t ids = 0;
      for_each_part(first, count, [&](std::size_t s, std::uint64_t, std::uint64_t rows) {
        ids += rows * corners(head_.cells[s]);
      });
      cells.ids.resize(ids);
      cells.types.reserve(count);
      VertexId* out = cells.ids.data();
      for_each_part(first, count, [&](std::size_t s, std::uint64_t row, std::uint64_t rows) {
        const MeditSection& section = head_.cells[s];
        cells.types.insert(cells.types.end(), rows, section.keyword->type);
        read_corners(section, row, rows, out);
        out += rows * corners(section);
      });
    });
    return cells;
  }

  void read_rows(Association association, std::size_t, std::uint64_t first, std::uint64_t count,
                 std::byte* out) const override {
    read_guarded(file_.file, [&] {
      if (head_.long_integers()) {
        read_references(association, first, count, reinterpret_cast<std::int64_t*>(out));
      } else {
        read_references(association, first, count, reinterpret_cast<std::int32_t*>(out));
      }
    });
  }

 private:
  static std::size_t corners(const MeditSection& section) {
    return corners_of(section.keyword->type);
  }
  static bool has_references(const MeditSection& section) {
    return section.keyword->role != MeditKeyword::Role::kPoints;
  }

  void describe() {
    MeshDescription& d = description_;
    d.path = file_.file.path();
    d.format = std::string("Medit mesh, ") + (head_.binary ? "binary" : "text") + ", version " +
               std::to_string(head_.version);
    d.left_out = head_.left_out;
    name_values_beside();
    d.points = head_.vertices.rows;
    for (const MeditSection& section : head_.cells) d.cells += section.rows;
    d.point_type = has_floats_ ? ValueType::kFloat32 : ValueType::kFloat64;
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

  // A text of version 1 often has more digits than floats have.
  bool are_all_floats() const {
    Vector<Vec3<double>> points;
    bool are_floats = true;
    for (std::uint64_t first = 0; are_floats && first < head_.vertices.rows;
         first += kRowsPerBlock) {
      points.resize(std::min<std::uint64_t>(kRowsPerBlock, head_.vertices.rows - first));
      read_vertices(first, points.size(), points.data());
      are_floats = std::ranges::all_of(points, [](const Vec3<double>& p) {
        return is_text_of_float(p.x) && is_text_of_float(p.y) && is_text_of_float(p.z);
      });
    }
    return are_floats;
  }

  // With nine digits or more, or as short as can be.
  static bool is_text_of_float(double x) {
    constexpr double kNineDigits = 5e-9;
    const auto single = static_cast<float>(x);
    if (!(std::abs(x - double{single}) > kNineDigits * std::abs(x))) return true;
    std::array<char, 32> text{};
    const auto end = std::to_chars(text.begin(), text.end(), single).ptr;
    double back = 0;
    std::from_chars(text.begin(), end, back);
    return back == x;
  }

  // Values for the points lie in a file of their own, and may be a field or what mesh generators
  // take for sizes.
  void name_values_beside() {
    for (const char* suffix : {".sol", ".solb"}) {
      std::error_code not_there;
      const std::string path = with_suffix(description_.path, suffix);
      if (description_.path == "-" || !std::filesystem::is_regular_file(path, not_there)) continue;
      description_.left_out.push_back("the values in " +
                                      std::filesystem::path(path).filename().string());
    }
  }

  // Calls f(section, its first row, how many) for the sections that cells of a range are in.
  template <class F>
  void for_each_part(std::uint64_t first, std::uint64_t count, F f) const {
    std::uint64_t begin = 0;
    for (std::size_t s = 0; s < head_.cells.size(); ++s) {
      const std::uint64_t end = begin + head_.cells[s].rows;
      const std::uint64_t from = std::max(first, begin);
      const std::uint64_t to = std::min(first + count, end);
      if (from < to) f(s, from - begin, to - from);
      begin = end;
    }
  }

  // The numbers of a section in a text, which must be all there; counted when they are first asked
  // for.
  const TextTokens& tokens_of(const MeditSection& section) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::unique_ptr<const TextTokens>& tokens = tokens_[section.text.data()];
    if (tokens) return *tokens;
    const auto columns = static_cast<std::uint64_t>(MeditHead::cell_columns(*section.keyword));
    auto counted = std::make_unique<const TextTokens>(file_.file, section.text, kMeditComment);
    const std::uint64_t expected = section.rows * columns;
    if (counted->size() != expected) {
      fail_of_rows(file_, std::string(section.keyword->name) + ": ", section.text, kMeditComment,
                   *counted, section.rows, columns);
    }
    tokens = std::move(counted);
    return *tokens;
  }

  // Calls f(row, column, token) for the numbers of some rows.
  template <class F>
  void for_each_token(const MeditSection& section, std::uint64_t first, std::uint64_t rows,
                      F f) const {
    const auto columns = static_cast<std::uint64_t>(MeditHead::cell_columns(*section.keyword));
    tokens_of(section).for_each(columns, first, rows, f);
  }

  // Calls f(row, bytes) for rows of a binary section.
  template <class F>
  void for_each_row(const MeditSection& section, std::uint64_t first, std::uint64_t rows,
                    F f) const {
    const std::size_t bytes = head_.row_bytes(*section.keyword);
    const auto* const from = reinterpret_cast<const std::byte*>(section.text.data());
    for_each_block(rows, kRowsPerBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t row = first + begin; row < first + end; ++row) f(row, from + row * bytes);
      file_.release(section.text.substr((first + begin) * bytes, (end - begin) * bytes));
    });
  }

  std::int64_t load_integer(const std::byte* from) const {
    return head_.long_integers() ? load<std::int64_t>(from, head_.swapped)
                                 : load<std::int32_t>(from, head_.swapped);
  }

  template <class Real>
  void read_vertices(std::uint64_t first, std::uint64_t count, Vec3<Real>* points) const {
    if (head_.binary) {
      for_each_row(head_.vertices, first, count, [&](std::size_t row, const std::byte* from) {
        points[row - first] = {load<Real>(from, head_.swapped),
                               load<Real>(from + sizeof(Real), head_.swapped),
                               load<Real>(from + 2 * sizeof(Real), head_.swapped)};
      });
    } else {
      for_each_token(head_.vertices, first, count,
                     [&](std::uint64_t row, std::uint64_t column, std::string_view token) {
                       if (column == 3) return;
                       Vec3<Real>& p = points[row - first];
                       (column == 0 ? p.x : column == 1 ? p.y : p.z) = file_.number<Real>(token);
                     });
    }
  }

  std::string wrong_point(const MeditSection& section, std::uint64_t row, std::int64_t id) const {
    return std::string(section.keyword->name) + ", row " + std::to_string(row + 1) +
           ": uses point " + std::to_string(id) + ", but there are points 1 to " +
           std::to_string(description_.points);
  }
  bool is_point(std::int64_t id) const {
    return id >= 1 && static_cast<std::uint64_t>(id) <= description_.points;
  }

  void read_corners(const MeditSection& section, std::uint64_t first, std::uint64_t rows,
                    VertexId* out) const {
    const std::size_t width = corners(section);
    if (head_.binary) {
      for_each_row(section, first, rows, [&](std::size_t row, const std::byte* from) {
        for (std::size_t k = 0; k < width; ++k) {
          const std::byte* const place = from + k * head_.integer_bytes();
          const std::int64_t id = load_integer(place);
          if (!is_point(id)) file_.invalid_at_byte(place, wrong_point(section, row, id));
          out[(row - first) * width + k] = static_cast<VertexId>(id - 1);
        }
      });
    } else {
      for_each_token(section, first, rows,
                     [&](std::uint64_t row, std::uint64_t column, std::string_view token) {
                       if (column >= width) return;
                       const auto id = file_.number<std::int64_t>(token);
                       if (!is_point(id)) {
                         file_.invalid_in_line(token.data(), wrong_point(section, row, id));
                       }
                       out[(row - first) * width + column] = static_cast<VertexId>(id - 1);
                     });
    }
    if (section.keyword->type == kVtkWedge) turn_wedges(rows, out);
  }

  // Medit sees the first triangle of a prism from inside, VTK from outside.
  static void turn_wedges(std::uint64_t rows, VertexId* ids) {
    for (std::uint64_t row = 0; row < rows; ++row, ids += 6) {
      std::swap(ids[1], ids[2]);
      std::swap(ids[4], ids[5]);
    }
  }

  template <class Int>
  void read_references(Association association, std::uint64_t first, std::uint64_t count,
                       Int* out) const {
    if (association == Association::kPoint) return read_column(head_.vertices, first, count, out);
    for_each_part(first, count, [&](std::size_t s, std::uint64_t row, std::uint64_t rows) {
      if (has_references(head_.cells[s])) {
        read_column(head_.cells[s], row, rows, out);
      } else {
        std::fill_n(out, rows, Int{0});
      }
      out += rows;
    });
  }

  // Some programs write them as reals; TetGen puts an attribute there, which may have any value.
  template <class Int>
  Int reference(const MeditSection& section, std::string_view token) const {
    if (token.find_first_of(".eEdD") == token.npos) return file_.number<Int>(token);
    const double real = file_.number<double>(token);
    if (std::floor(real) != real || std::abs(real) > std::numeric_limits<std::int32_t>::max()) {
      file_.fail_in_line(token.data(), std::string(section.keyword->name) + ": the reference " +
                                           quoted(token) +
                                           " is no whole number (from TetGen, take the .node and "
                                           ".ele files, which have attributes)");
    }
    return static_cast<Int>(real);
  }

  // The last one.
  template <class Int>
  void read_column(const MeditSection& section, std::uint64_t first, std::uint64_t rows,
                   Int* out) const {
    if (head_.binary) {
      const std::size_t place = head_.row_bytes(*section.keyword) - sizeof(Int);
      for_each_row(section, first, rows, [&](std::size_t row, const std::byte* from) {
        out[row - first] = load<Int>(from + place, head_.swapped);
      });
    } else {
      const auto last = static_cast<std::uint64_t>(MeditHead::cell_columns(*section.keyword)) - 1;
      for_each_token(section, first, rows,
                     [&](std::uint64_t row, std::uint64_t column, std::string_view token) {
                       if (column == last) out[row - first] = reference<Int>(section, token);
                     });
    }
  }

  FormatFile file_;
  MeditHead head_;
  bool has_floats_ = false;  // coordinates
  MeshDescription description_;
  mutable std::mutex mutex_;
  mutable std::map<const char*, std::unique_ptr<const TextTokens>> tokens_;  // by the section
};

}  // namespace

std::unique_ptr<MeshSource> open_medit(MappedFile file, const OpenOptions& options) {
  return make_source(std::make_unique<MeditReader>(std::move(file)), options);
}

}  // namespace tetfusion
