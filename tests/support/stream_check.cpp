#include "support/stream_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <variant>

#include "base/error.h"
#include "io/open_mesh.h"

namespace tetfusion::testing {

namespace {

using PlainBytes = Vector<std::byte>;

// One array by its rows, or the coordinates.
struct PlainColumn {
  PlainBytes bytes;
  std::size_t tuple = 0;

  void append_to(std::string* text, std::uint64_t row) const {
    text->append(reinterpret_cast<const char*>(bytes.data()) + row * tuple, tuple);
  }
};

struct PlainMesh {
  std::vector<PlainColumn> point_columns;  // by the ids of tets and lower
  std::vector<PlainColumn> cell_columns;   // by rows
  std::vector<Tet> tets;
  std::vector<std::uint64_t> tet_rows;
  LowerCells lower;
  std::vector<std::uint64_t> lower_rows;

  WrittenMesh write_out() const {
    WrittenMesh out;
    for (std::size_t t = 0; t < tets.size(); ++t) {
      out.push_back(write_cell(10, tets[t], tet_rows[t]));
    }
    for (std::size_t c = 0; c < lower.size(); ++c) {
      const std::span<const VertexId> ids(lower.connectivity);
      const auto corners = ids.subspan(lower.offsets[c], lower.offsets[c + 1] - lower.offsets[c]);
      out.push_back(write_cell(lower.types[c], corners, lower_rows[c]));
    }
    return out;
  }

  std::string write_cell(std::uint8_t type, std::span<const VertexId> ids,
                         std::uint64_t row) const {
    std::string text(1, static_cast<char>(type));
    for (const VertexId v : ids) {
      for (const PlainColumn& column : point_columns) column.append_to(&text, v);
    }
    for (const PlainColumn& column : cell_columns) column.append_to(&text, row);
    return text;
  }
};

std::size_t tuple_bytes(const ArrayInfo& info) { return info.components * size_of(info.type); }

// Row i of the result is row rows[i] of `all`, or row i when there are no `rows`.
PlainColumn pick(PlainBytes all, std::size_t tuple, const Vector<std::uint64_t>& rows) {
  if (rows.empty()) return {std::move(all), tuple};
  PlainColumn column{PlainBytes(rows.size() * tuple), tuple};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::copy_n(all.begin() + static_cast<std::ptrdiff_t>(rows[i] * tuple), tuple,
                column.bytes.begin() + static_cast<std::ptrdiff_t>(i * tuple));
  }
  return column;
}

std::vector<std::uint64_t> rows_or_identity(const Vector<std::uint64_t>& rows, std::size_t size) {
  if (!rows.empty()) return {rows.begin(), rows.end()};
  const Vector<std::uint64_t> identity = count_up<std::uint64_t>(size);
  return {identity.begin(), identity.end()};
}

// What a window must be besides being right.
void check_form(const CellWindow& w, std::uint64_t first, std::uint64_t count) {
  EXPECT_TRUE(w.tet_rows.empty() || w.tet_rows.size() == w.tets.size());
  EXPECT_EQ(w.lower_rows.size(), w.lower.size());
  EXPECT_EQ(w.lower.offsets.size(), w.lower.size() == 0 ? 0 : w.lower.size() + 1);
  EXPECT_LE(w.tets.size() + w.lower.size(), count);
  for (const Vector<std::uint64_t>& rows : {w.tet_rows, w.lower_rows}) {
    EXPECT_TRUE(std::is_sorted(rows.begin(), rows.end()));
    if (rows.empty()) continue;
    EXPECT_GE(rows.front(), first);
    EXPECT_LT(rows.back(), first + count);
  }
}

void append(const CellWindow& w, std::uint64_t first, PlainMesh* mesh) {
  for (std::size_t t = 0; t < w.tets.size(); ++t) {
    mesh->tets.push_back(w.tets[t]);
    mesh->tet_rows.push_back(w.tet_rows.empty() ? first + t : w.tet_rows[t]);
  }
  LowerCells& lower = mesh->lower;
  if (w.lower.size() > 0 && lower.offsets.empty()) lower.offsets.push_back(0);
  for (std::size_t c = 0; c < w.lower.size(); ++c) {
    lower.types.push_back(w.lower.types[c]);
    for (std::uint64_t k = w.lower.offsets[c]; k < w.lower.offsets[c + 1]; ++k) {
      lower.connectivity.push_back(w.lower.connectivity[k]);
    }
    lower.offsets.push_back(lower.connectivity.size());
    mesh->lower_rows.push_back(w.lower_rows[c]);
  }
}

PlainColumn read_rows(const MeshStream& stream, Association association, std::size_t index,
                      const ArrayInfo& info, std::uint64_t window) {
  const std::uint64_t rows = association == Association::kPoint ? stream.points() : stream.cells();
  PlainColumn column{PlainBytes(rows * tuple_bytes(info)), tuple_bytes(info)};
  for (std::uint64_t first = 0; first < rows; first += window) {
    const std::uint64_t count = std::min(window, rows - first);
    stream.read_rows(association, index, first, count,
                     std::span(column.bytes).subspan(first * column.tuple, count * column.tuple));
  }
  return column;
}

// The error's message, with its kind; nothing when there was none.
template <class F>
std::optional<std::string> error_of(F f) {
  try {
    f();
  } catch (const InvalidMesh& e) {
    return std::string("InvalidMesh: ") + e.what();
  } catch (const Error& e) {
    return std::to_string(e.exit_code()) + ": " + e.what();
  }
  return std::nullopt;
}

}  // namespace

WrittenMesh write_out_whole(MeshSource* source) {
  const MeshDescription& d = source->description();
  const Geometry g = source->read_geometry();
  PlainMesh mesh;
  mesh.tets.assign(g.tets.begin(), g.tets.end());
  mesh.tet_rows = rows_or_identity(g.tet_source, g.tets.size());
  mesh.lower = g.lower;
  mesh.lower_rows = rows_or_identity(g.lower_source, g.lower.size());
  std::visit(
      [&](const auto& points) {
        const std::span bytes = std::as_bytes(std::span(points));
        mesh.point_columns.push_back({PlainBytes(bytes.begin(), bytes.end()), sizeof(points[0])});
      },
      g.points);
  for (std::size_t i = 0; i < d.point_data.arrays.size(); ++i) {
    DataArray array = source->read_array(Association::kPoint, i);
    const std::size_t tuple = tuple_bytes(array.info);
    mesh.point_columns.push_back(pick(std::move(array.bytes), tuple, g.point_source));
  }
  for (std::size_t i = 0; i < d.cell_data.arrays.size(); ++i) {
    DataArray array = source->read_array(Association::kCell, i);
    mesh.cell_columns.push_back({std::move(array.bytes), tuple_bytes(array.info)});
  }
  return mesh.write_out();
}

WrittenMesh write_out_windows(const MeshSource& source, const MeshStream& stream,
                              std::uint64_t window) {
  const MeshDescription& d = source.description();
  PlainMesh mesh;
  std::uint64_t ghosts = 0;
  CellWindow w;
  for (std::uint64_t first = 0; first < stream.cells(); first += window) {
    const std::uint64_t count = std::min(window, stream.cells() - first);
    stream.read_cells(first, count, &w);
    check_form(w, first, count);
    append(w, first, &mesh);
    ghosts += w.ghost_cells;
  }
  EXPECT_EQ(ghosts, stream.ghost_cells());
  const std::size_t point = 3 * size_of(d.point_type);
  PlainColumn points{PlainBytes(stream.points() * point), point};
  for (std::uint64_t first = 0; first < stream.points(); first += window) {
    const std::uint64_t count = std::min(window, stream.points() - first);
    stream.read_points(first, count, std::span(points.bytes).subspan(first * point, count * point));
  }
  mesh.point_columns.push_back(std::move(points));
  for (std::size_t i = 0; i < d.point_data.arrays.size(); ++i) {
    mesh.point_columns.push_back(
        read_rows(stream, Association::kPoint, i, d.point_data.arrays[i], window));
  }
  for (std::size_t i = 0; i < d.cell_data.arrays.size(); ++i) {
    mesh.cell_columns.push_back(
        read_rows(stream, Association::kCell, i, d.cell_data.arrays[i], window));
  }
  return mesh.write_out();
}

void expect_windows_like_whole(const std::string& path, const OpenOptions& options,
                               bool same_message) {
  WrittenMesh expected;
  const auto error = error_of([&] { expected = write_out_whole(open_mesh(path, options).get()); });
  constexpr std::uint64_t kAll = std::uint64_t{1} << 40;
  for (const std::uint64_t window :
       {std::uint64_t{1}, std::uint64_t{3}, std::uint64_t{1000}, kAll}) {
    // Each window decodes a chunk of every array at least.
    if (expected.size() > 1000 * window) continue;
    // Damaged files come by the thousand.
    if (!same_message && window != 1) continue;
    WrittenMesh found;
    std::uint64_t differing = 0;
    const auto stream_error = error_of([&] {
      const auto source = open_mesh(path, options);
      const auto stream = open_stream(source.get());
      found = write_out_windows(*source, *stream, window);
      differing = stream->differing_points();
    });
    if (same_message) {
      EXPECT_EQ(stream_error.value_or("no error"), error.value_or("no error")) << window;
    } else {
      EXPECT_EQ(stream_error.has_value(), error.has_value())
          << window << "\nin windows: " << stream_error.value_or("no error")
          << "\nas a whole: " << error.value_or("no error");
      // Or one beside it, where a mesh is several.
      const std::string name = path.substr(0, path.rfind('.'));
      EXPECT_NE(stream_error.value_or(path).find(name), std::string::npos) << *stream_error;
    }
    if (!stream_error && !error) {
      EXPECT_TRUE(found == expected) << window;
      EXPECT_EQ(differing, open_mesh(path, options)->read_geometry().differing_points) << window;
    }
  }
}

}  // namespace tetfusion::testing
