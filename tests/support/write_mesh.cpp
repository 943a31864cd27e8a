#include "support/write_mesh.h"

#include <span>
#include <variant>

#include "io/files/output_file.h"
#include "io/vtk/cell_order.h"
#include "io/vtk/vtu_writer.h"

namespace tetfusion::testing {

namespace {

VtuLayout layout_of(const OutputMesh& mesh, std::uint64_t cells, Encoding encoding) {
  VtuLayout layout;
  layout.points = point_count(*mesh.points);
  layout.cells = cells;
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

void put_arrays(const OutputMesh& mesh, Association association, const AttributeSet& set,
                VtuWriter* writer) {
  for (std::size_t i = 0; i < set.arrays.size(); ++i) {
    writer->put(mesh.read_array(association, i).bytes);
  }
}

void put_corners(const Vector<Tet>& tets, const LowerCells* lower, VtuWriter* writer) {
  const std::uint64_t corners = 4 * tets.size();
  writer->put_computed<std::int64_t>(
      [&](std::uint64_t first, std::uint64_t count, std::int64_t* out) {
        for (std::uint64_t i = first; i < first + count; ++i) {
          *out++ = i < corners ? tets[i / 4][i % 4] : lower->connectivity[i - corners];
        }
      });
}

}  // namespace

void write_mesh(const OutputMesh& mesh, const std::string& path, const WriteOptions& options) {
  const CellOrder cells{mesh.tets->size(), mesh.lower};
  OutputFile file(path, VtuWriter::access(options.encoding));
  VtuWriter writer(&file, layout_of(mesh, cells.size(), options.encoding), options.progress);
  put_arrays(mesh, Association::kPoint, mesh.point_data, &writer);
  put_arrays(mesh, Association::kCell, mesh.cell_data, &writer);
  std::visit([&](const auto& p) { writer.put(std::as_bytes(std::span(p))); }, *mesh.points);
  put_corners(*mesh.tets, mesh.lower, &writer);
  put_ends_and_types(cells, &writer);
  writer.finish();
  file.commit();
}

}  // namespace tetfusion::testing
