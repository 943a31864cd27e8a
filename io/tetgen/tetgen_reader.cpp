#include "io/tetgen/tetgen_reader.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "base/numbers.h"
#include "io/files/guarded_reading.h"
#include "io/formats/counted_rows.h"
#include "io/formats/format_file.h"
#include "io/formats/format_source.h"
#include "io/formats/suffix.h"
#include "io/formats/text_tokens.h"
#include "io/source/cell_kinds.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

constexpr char kComment = '#';

// One of the files: its head, and its rows of `columns` numbers each.
struct Table {
  FormatFile file;
  std::vector<std::uint64_t> head;
  std::string_view body;
  std::uint64_t rows = 0;
  std::uint64_t columns = 0;
  std::shared_ptr<const TextTokens> tokens = nullptr;  // after find_numbers()

  // The head's number of that place; 0 where it ends before.
  std::uint64_t at(std::size_t i) const { return i < head.size() ? head[i] : 0; }
};

void parse_head(Table* table) {
  const FormatFile& file = table->file;
  TokenCursor cursor(file.text(), kComment);
  std::string_view token = cursor.next();
  if (token.empty()) file.fail("there is nothing in it");
  const char* const end = file.text().data() + file.text().size();
  const char* const line_end = std::find(token.data(), end, '\n');
  TokenCursor line({token.data(), static_cast<std::size_t>(line_end - token.data())}, kComment);
  for (token = line.next(); !token.empty(); token = line.next()) {
    table->head.push_back(file.number<std::uint64_t>(token));
  }
  table->rows = table->head[0];
  table->body = {line_end, static_cast<std::size_t>(end - line_end)};
}

Table open_table(MappedFile mapped) {
  Table table{{std::move(mapped)}, {}, {}, 0, 0, nullptr};
  read_guarded(table.file.file, [&] { parse_head(&table); });
  return table;
}

// A row takes a digit and a blank for each number.
void check_rows(const Table& table) {
  if (table.columns <= 4096 && table.rows <= table.body.size() / (2 * table.columns) + 1) return;
  table.file.fail_in_line(table.body.data(),
                          std::to_string(table.rows) + " rows of " + std::to_string(table.columns) +
                              " numbers do not fit into the " + std::to_string(table.body.size()) +
                              " bytes that follow");
}

// To be called when the table lies where it stays, and its columns are known.
void find_numbers(Table* table) {
  read_guarded(table->file.file, [&] {
    table->tokens = std::make_shared<const TextTokens>(table->file.file, table->body, kComment);
  });
  const std::uint64_t expected = table->rows * table->columns;
  if (table->tokens->size() == expected) return;
  fail_of_rows(table->file, "", table->body, kComment, *table->tokens, table->rows, table->columns);
}

// Calls f(row, column, token) for the numbers of some rows.
template <class F>
void for_each_number(const Table& table, std::uint64_t first, std::uint64_t rows, F f) {
  read_guarded(table.file.file, [&] { table.tokens->for_each(table.columns, first, rows, f); });
}

// TetGen's attributes are real numbers; of those that say regions "1", "1.0" and "1e0" are one.
std::optional<std::int64_t> whole_number(std::string_view token) {
  if (const auto whole = number_in<std::int64_t>(token)) return whole;
  constexpr double kExact = 0x1p53;  // from here on not all whole numbers are doubles
  const auto real = number_in<double>(token);
  if (!real || std::floor(*real) != *real || std::abs(*real) >= kExact) return std::nullopt;
  return static_cast<std::int64_t>(*real);
}

// Rows, between two places of a list that are kept in mind.
constexpr std::uint64_t kRowsPerPlace = 4096;
// Places whose rows are looked at together, so that threads share them.
constexpr std::uint64_t kPlacesAtOnce = 64;

// Faces or edges: where a row has its corners and its marker.
struct Sides {
  Table table;
  std::uint8_t type;
  std::optional<std::uint64_t> marker;
  // Of a list of all that the mesh has: how many rows have a marker that is not 0, before each of
  // kRowsPerPlace rows and at the end. These alone are cells.
  std::vector<std::uint64_t> marked = {};

  std::uint64_t cells() const { return marked.empty() ? table.rows : marked.back(); }
};

// Where cells that follow one another stand in a table.
struct Rows {
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};
  std::uint64_t first = 0, count = 0;
  Vector<std::uint64_t> cells = {};  // of each row the cell, from 0; empty: one after the other

  std::uint64_t cell(std::uint64_t row) const {
    return cells.empty() ? row - first : cells[row - first];
  }
};

class TetgenReader final : public FormatReader {
 public:
  // `path` is that of one of the two.
  TetgenReader(const std::string& path, Table nodes, Table tets)
      : nodes_(std::move(nodes)), tets_(std::move(tets)) {
    check_heads();
    open_sides(path, ".face", kVtkTriangle);
    open_sides(path, ".edge", kVtkLine);
    find_numbers(&nodes_);
    find_numbers(&tets_);
    for (Sides& sides : sides_) {
      find_numbers(&sides.table);
      leave_out_unmarked(&sides);
    }
    describe(path);
  }

  const MeshDescription& description() const override { return description_; }

  CellTypeCounts cell_types() const override {
    CellTypeCounts counts{};
    counts[tet_type()] += tets_.rows;
    for (const Sides& sides : sides_) counts[sides.type] += sides.cells();
    return counts;
  }

  void read_points(std::uint64_t first, std::uint64_t count, std::byte* out) const override {
    auto* const points = reinterpret_cast<Vec3<double>*>(out);
    for_each_number(
        nodes_, first, count, [&](std::uint64_t row, std::uint64_t column, std::string_view token) {
          if (column == 0) {
            check_number(row, token);
          } else if (column <= 3) {
            Vec3<double>& p = points[row - first];
            (column == 1 ? p.x : column == 2 ? p.y : p.z) = nodes_.file.number<double>(token);
          }
        });
  }

  ListedCells read_cells(std::uint64_t first, std::uint64_t count) const override {
    ListedCells cells;
    std::uint64_t ids = 0;
    for_each_part(first, count, [&](const Part& part) { ids += part.rows * part.width; });
    cells.ids.resize(ids);
    VertexId* out = cells.ids.data();
    for_each_part(first, count, [&](const Part& part) {
      cells.types.insert(cells.types.end(), part.rows, part.type);
      for_each_rows(part, [&](const Rows& rows) { read_corners(part, rows, out); });
      out += part.rows * part.width;
    });
    return cells;
  }

  void read_rows(Association association, std::size_t index, std::uint64_t first,
                 std::uint64_t count, std::byte* out) const override {
    if (association == Association::kPoint) {
      return read_column(nodes_, 4 + index, description_.point_data.arrays.at(index).type,
                         {first, count}, out);
    }
    const ValueType type = description_.cell_data.arrays.at(index).type;
    for_each_part(first, count, [&](const Part& part) {
      const std::uint64_t bytes = part.rows * size_of(type);
      std::fill_n(out, bytes, std::byte{0});
      const std::optional<std::uint64_t> column = column_of(part, index);
      const auto read = [&](const Rows& rows) {
        read_column(part.table, *column, type, rows, out);
      };
      if (column) for_each_rows(part, read);
      out += bytes;
    });
  }

 private:
  // Cells of a range that one table has.
  struct Part {
    const Table& table;
    const Sides* sides;  // nothing for tetrahedra
    std::uint8_t type;
    std::uint64_t width;  // corners
    std::uint64_t first, rows;
  };
  template <class F>
  void for_each_part(std::uint64_t first, std::uint64_t count, F f) const {
    std::uint64_t begin = 0;
    const auto add = [&](const Table& table, const Sides* sides, std::uint8_t type) {
      const std::uint64_t cells = sides == nullptr ? table.rows : sides->cells();
      const std::uint64_t from = std::max(first, begin);
      const std::uint64_t to = std::min(first + count, begin + cells);
      if (from < to) f(Part{table, sides, type, corners_of(type), from - begin, to - from});
      begin += cells;
    };
    add(tets_, nullptr, tet_type());
    for (const Sides& sides : sides_) add(sides.table, &sides, sides.type);
  }

  // Where it has values for that cell array.
  std::optional<std::uint64_t> column_of(const Part& part, std::size_t array) const {
    if (part.sides != nullptr) return array == 0 ? part.sides->marker : std::nullopt;
    if (array >= tets_.at(2)) return {};
    return 1 + tets_.at(1) + array;
  }

  // Calls f(rows) for the rows that cells of a range stand in, not too many at a time.
  template <class F>
  static void for_each_rows(const Part& part, F f) {
    if (part.sides == nullptr || part.sides->marked.empty()) return f({part.first, part.rows});
    const std::vector<std::uint64_t>& marked = part.sides->marked;
    const std::uint64_t last = part.first + part.rows - 1;
    const auto place_of = [&](std::uint64_t cell) {
      const auto behind = std::upper_bound(marked.begin(), marked.end(), cell);
      return static_cast<std::uint64_t>(behind - marked.begin()) - 1;
    };
    const std::uint64_t end = place_of(last) + 1;
    for (std::uint64_t place = place_of(part.first); place < end; place += kPlacesAtOnce) {
      Rows rows;
      rows.first = place * kRowsPerPlace;
      rows.count = std::min(std::min(place + kPlacesAtOnce, end) * kRowsPerPlace, part.table.rows) -
                   rows.first;
      const Vector<std::uint8_t> is_marked = find_marked(*part.sides, rows.first, rows.count);
      rows.cells.assign(rows.count, Rows::kNone);
      std::uint64_t cell = marked[place];
      for (std::uint64_t i = 0; i < rows.count; ++i) {
        if (is_marked[i] == 0) continue;
        if (cell >= part.first && cell <= last) rows.cells[i] = cell - part.first;
        ++cell;
      }
      f(rows);
    }
  }

  static Vector<std::uint8_t> find_marked(const Sides& sides, std::uint64_t first,
                                          std::uint64_t rows) {
    Vector<std::uint8_t> marked(rows);
    for_each_number(sides.table, first, rows,
                    [&](std::uint64_t row, std::uint64_t column, std::string_view token) {
                      if (column == *sides.marker) marked[row - first] = whole_number(token) != 0;
                    });
    return marked;
  }

  // A mesh of t tetrahedra has (4t + b) / 2 faces, b of them on the boundary; and as many edges as
  // tetrahedra and points together, or more. Lists of so many have them all, as TetGen writes with
  // -f and -e: kept as cells they would hold the whole mesh.
  bool lists_all(const Table& table, std::uint8_t type) const {
    if (type == kVtkTriangle) return table.rows >= 2 * tets_.rows;
    const std::uint64_t middle = is_quadratic() ? table.rows : 0;  // a point in each
    return table.rows + middle >= tets_.rows + nodes_.rows;
  }

  void leave_out(std::uint64_t count, std::uint8_t type, const char* which, const Table& table) {
    if (count == 0) return;
    const char* const what = type == kVtkTriangle ? "faces" : "edges";
    description_.left_out.push_back(
        format_count(count) + " " + what + " " + which + ", as " +
        std::filesystem::path(table.file.file.path()).filename().string() + " lists all " + what);
  }

  // Markers that are not 0 say that a face or edge means something.
  void leave_out_unmarked(Sides* sides) {
    const Table& table = sides->table;
    if (!lists_all(table, sides->type)) return;
    if (!sides->marker) {
      sides->marked = {0};
      return leave_out(table.rows, sides->type, "without markers", table);
    }
    std::uint64_t marked = 0;
    for (std::uint64_t first = 0; first < table.rows;) {
      const std::uint64_t rows = std::min(kPlacesAtOnce * kRowsPerPlace, table.rows - first);
      const Vector<std::uint8_t> is_marked = find_marked(*sides, first, rows);
      for (std::uint64_t i = 0; i < rows; ++i) {
        if (i % kRowsPerPlace == 0) sides->marked.push_back(marked);
        marked += is_marked[i];
      }
      first += rows;
    }
    sides->marked.push_back(marked);
    leave_out(table.rows - marked, sides->type, "with marker 0", table);
  }

  bool is_quadratic() const { return tets_.at(1) == 10; }
  std::uint8_t tet_type() const { return is_quadratic() ? kVtkQuadraticTetra : kVtkTetra; }

  void check_heads() {
    if (nodes_.at(1) != 3) {
      nodes_.file.fail("expected points of 3 dimensions, found " + std::to_string(nodes_.at(1)));
    }
    if (tets_.head.size() < 2) tets_.head.push_back(4);
    if (tets_.at(1) != 4 && tets_.at(1) != 10) {
      tets_.file.fail("expected tetrahedra of 4 or 10 points, found " +
                      std::to_string(tets_.at(1)));
    }
    for (const std::uint64_t count : {nodes_.at(2), nodes_.at(3), tets_.at(2)}) {
      if (count > 4096) nodes_.file.fail(std::to_string(count) + " attributes cannot be read");
    }
    nodes_.columns = 4 + nodes_.at(2) + nodes_.at(3);
    tets_.columns = 1 + tets_.at(1) + tets_.at(2);
    check_rows(nodes_);
    check_rows(tets_);
    if (nodes_.rows == 0 || tets_.rows == 0) tets_.file.fail("the mesh has no cells");
    if (nodes_.rows > kMaxPoints) {
      nodes_.file.fail(ErrorCode::kMemory,
                       std::to_string(nodes_.rows) + " points are more than can be held in memory");
    }
    read_guarded(nodes_.file.file, [&] {
      base_ = nodes_.file.number<std::uint64_t>(TokenCursor(nodes_.body, kComment).next());
    });
  }

  // TetGen may add the points in the middle of sides (with 10-node tetrahedra) before the marker,
  // and the tetrahedra beside them behind it.
  void open_sides(const std::string& mesh, const char* suffix, std::uint8_t type) {
    std::error_code error;
    const std::string path = with_suffix(mesh, suffix);
    if (!std::filesystem::exists(path, error)) return;
    MappedFile file = MappedFile::open(path);
    description_.files.push_back(path);
    Sides sides{open_table(std::move(file)), type, {}};
    Table& table = sides.table;
    if (table.rows == 0) return;
    const std::uint64_t middle = !is_quadratic() ? 0 : type == kVtkTriangle ? 3 : 1;
    const std::uint64_t least = 1 + corners_of(type) + middle + (table.at(1) != 0 ? 1 : 0);
    if (table.at(1) != 0) sides.marker = least - 1;
    read_guarded(table.file.file, [&] {
      const std::uint64_t numbers = TextTokens(table.file.file, table.body, kComment).size();
      table.columns = std::max(numbers / table.rows, least);
    });
    check_rows(table);
    sides_.push_back(std::move(sides));
  }

  void describe(const std::string& path) {
    MeshDescription& d = description_;
    d.path = path;
    const bool is_nodes = nodes_.file.file.path() == path;
    d.file_bytes = (is_nodes ? nodes_ : tets_).file.file.size();
    d.files.insert(d.files.begin(), (is_nodes ? tets_ : nodes_).file.file.path());
    d.format = "TetGen mesh";
    d.points = nodes_.rows;
    d.cells = tets_.rows;
    for (const Sides& sides : sides_) d.cells += sides.cells();
    d.point_type = ValueType::kFloat64;
    for (std::uint64_t k = 0; k < nodes_.at(2); ++k) {
      d.point_data.arrays.push_back(
          {"tetgen:attr" + std::to_string(k + 1), ValueType::kFloat64, 1, {}, d.points});
    }
    for (std::uint64_t k = 0; k < nodes_.at(3); ++k) {
      d.point_data.arrays.push_back({reference(k), ValueType::kInt32, 1, {}, d.points});
    }
    const std::uint64_t attributes = tets_.at(2);
    const bool has_markers = std::any_of(
        sides_.begin(), sides_.end(), [](const Sides& sides) { return sides.marker.has_value(); });
    for (std::uint64_t k = 0; k < std::max<std::uint64_t>(attributes, has_markers ? 1 : 0); ++k) {
      const ValueType type =
          k >= attributes ? ValueType::kInt32 : type_of_attribute(1 + tets_.at(1) + k);
      d.cell_data.arrays.push_back({reference(k), type, 1, {}, d.cells});
    }
  }

  static std::string reference(std::uint64_t k) {
    return k == 0 ? "tetgen:ref" : "tetgen:ref" + std::to_string(k + 1);
  }

  // Int32 or Int64 where all values are whole numbers, else Float64.
  ValueType type_of_attribute(std::uint64_t column) const {
    std::atomic<bool> whole = true, small = true;
    for_each_number(tets_, 0, tets_.rows,
                    [&](std::uint64_t, std::uint64_t c, std::string_view token) {
                      if (c != column) return;
                      const auto number = whole_number(token);
                      if (!number) whole = false;
                      if (number && static_cast<std::int32_t>(*number) != *number) small = false;
                    });
    if (!whole) return ValueType::kFloat64;
    return small ? ValueType::kInt32 : ValueType::kInt64;
  }

  void check_number(std::uint64_t row, std::string_view token) const {
    const auto number = nodes_.file.number<std::uint64_t>(token);
    if (number - base_ == row) return;
    nodes_.file.fail_in_line(token.data(), "point " + std::to_string(number) + " stands where " +
                                               std::to_string(base_ + row) + " is expected");
  }

  void read_corners(const Part& part, const Rows& rows, VertexId* out) const {
    const FormatFile& file = part.table.file;
    for_each_number(part.table, rows.first, rows.count,
                    [&](std::uint64_t row, std::uint64_t column, std::string_view token) {
                      const std::uint64_t cell = rows.cell(row);
                      if (column == 0 || column > part.width || cell == Rows::kNone) return;
                      const auto number = file.number<std::int64_t>(token);
                      const std::uint64_t place = static_cast<std::uint64_t>(number) - base_;
                      if (number < 0 || place >= nodes_.rows) {
                        file.invalid_in_line(token.data(),
                                             "uses point " + std::to_string(number) +
                                                 ", but there are points " + std::to_string(base_) +
                                                 " to " + std::to_string(base_ + nodes_.rows - 1));
                      }
                      out[cell * part.width + column - 1] = static_cast<VertexId>(place);
                    });
  }

  static void read_column(const Table& table, std::uint64_t wanted, ValueType type,
                          const Rows& rows, std::byte* out) {
    for_each_number(table, rows.first, rows.count,
                    [&](std::uint64_t row, std::uint64_t column, std::string_view token) {
                      const std::uint64_t cell = rows.cell(row);
                      if (column != wanted || cell == Rows::kNone) return;
                      const auto put = [&](auto value) {
                        std::memcpy(out + cell * sizeof value, &value, sizeof value);
                      };
                      const auto put_whole = [&]<class T>(T) {
                        const auto whole = whole_number(token);
                        const bool fits = whole && static_cast<T>(*whole) == *whole;
                        // What does not fit is told of there.
                        put(fits ? static_cast<T>(*whole) : table.file.number<T>(token));
                      };
                      if (type == ValueType::kFloat64) {
                        put(table.file.number<double>(token));
                      } else if (type == ValueType::kInt64) {
                        put_whole(std::int64_t{});
                      } else {
                        put_whole(std::int32_t{});
                      }
                    });
  }

  Table nodes_, tets_;
  std::vector<Sides> sides_;
  std::uint64_t base_ = 0;
  MeshDescription description_;
};

}  // namespace

std::unique_ptr<MeshSource> open_tetgen(MappedFile file, const OpenOptions& options) {
  const std::string path = file.path();
  const bool is_nodes = suffix_of(path) == ".node";
  MappedFile other = MappedFile::open(with_suffix(path, is_nodes ? ".ele" : ".node"));
  Table nodes = open_table(std::move(is_nodes ? file : other));
  Table tets = open_table(std::move(is_nodes ? other : file));
  return make_source(std::make_unique<TetgenReader>(path, std::move(nodes), std::move(tets)),
                     options);
}

}  // namespace tetfusion
