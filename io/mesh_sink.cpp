#include "io/mesh_sink.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <span>
#include <utility>
#include <variant>

#include "base/error.h"
#include "io/output_file.h"
#include "io/vtu_writer.h"

namespace tetfusion {

namespace {

constexpr std::uint8_t kVtkTetra = 10;

VtuLayout layout_of(const OutputMesh& mesh, std::uint64_t lower_cells, Encoding encoding) {
  VtuLayout layout;
  layout.points = point_count(*mesh.points);
  layout.cells = mesh.tets->size() + lower_cells;
  layout.corners = 4 * mesh.tets->size() + (mesh.lower ? mesh.lower->connectivity.size() : 0);
  layout.point_type = point_type(*mesh.points);
  layout.point_data = mesh.point_data;
  layout.cell_data = mesh.cell_data;
  layout.encoding = encoding;
  for (std::size_t i = 0; i < mesh.field_data.arrays.size(); ++i) {
    layout.field_data.push_back(mesh.read_array(Association::kField, i));
  }
  return layout;
}

// Writes the arrays of one association, the values of one at a time.
void put_arrays(const OutputMesh& mesh, Association association, const AttributeSet& set,
                std::uint64_t tuples, VtuWriter* writer) {
  for (std::size_t i = 0; i < set.arrays.size(); ++i) {
    const ArrayInfo& info = set.arrays[i];
    const DataArray array = mesh.read_array(association, i);
    const std::uint64_t expected = tuples * info.components * size_of(info.type);
    if (array.bytes.size() != expected) {
      throw Error(ErrorCode::kBadInput,
                  fmt::format("array '{}' has {} bytes instead of the {} that {} tuples need",
                              info.name, array.bytes.size(), expected, tuples));
    }
    writer->put(array.bytes);
  }
}

void put_points(const Points& points, VtuWriter* writer) {
  std::visit([&](const auto& p) { writer->put(std::as_bytes(std::span(p))); }, points);
}

void put_cells(const Vector<Tet>& tets, const LowerCells* lower, VtuWriter* writer) {
  const std::uint64_t corners = 4 * tets.size();
  writer->put_computed<std::int64_t>(
      [&](std::uint64_t first, std::uint64_t count, std::int64_t* out) {
        for (std::uint64_t i = first; i < first + count; ++i) {
          *out++ = i < corners ? tets[i / 4][i % 4] : lower->connectivity[i - corners];
        }
      });
  writer->put_computed<std::int64_t>(
      [&](std::uint64_t first, std::uint64_t count, std::int64_t* out) {
        for (std::uint64_t i = first; i < first + count; ++i) {
          const std::uint64_t end =
              i < tets.size() ? 4 * (i + 1) : corners + lower->offsets[i - tets.size() + 1];
          *out++ = static_cast<std::int64_t>(end);
        }
      });
  writer->put_computed<std::uint8_t>(
      [&](std::uint64_t first, std::uint64_t count, std::uint8_t* out) {
        for (std::uint64_t i = first; i < first + count; ++i) {
          *out++ = i < tets.size() ? kVtkTetra : lower->types[i - tets.size()];
        }
      });
}

}  // namespace

void check_mesh_output(const std::string& path) {
  std::error_code error;
  const bool special = path == "-" || std::filesystem::is_other(path, error);
  std::string suffix = std::filesystem::path(path).extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (!special && suffix != ".vtu") {
    throw Error(ErrorCode::kUsage,
                fmt::format("cannot write {}: meshes are written as VTK XML unstructured grids; "
                            "give a name that ends in .vtu, or - for standard output",
                            path));
  }
  check_output_path(path);
}

void write_mesh(const OutputMesh& mesh, const std::string& path, const WriteOptions& options) {
  check_mesh_output(path);
  const std::uint64_t lower_cells = mesh.lower ? mesh.lower->size() : 0;
  OutputFile file(path, VtuWriter::access(options.encoding));
  VtuWriter writer(&file, layout_of(mesh, lower_cells, options.encoding), options.progress);
  put_arrays(mesh, Association::kPoint, mesh.point_data, point_count(*mesh.points), &writer);
  put_arrays(mesh, Association::kCell, mesh.cell_data, mesh.tets->size() + lower_cells, &writer);
  put_points(*mesh.points, &writer);
  put_cells(*mesh.tets, mesh.lower, &writer);
  writer.finish();
  file.commit();
}

}  // namespace tetfusion
