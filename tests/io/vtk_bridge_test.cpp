#include "io/vtk_bridge.h"

#include <algorithm>
#include <array>
#include <string>

#include "io/open_mesh.h"
#include "mesh/predicates.h"
#include "support/vtk_file_test.h"

namespace tetfusion {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::kHexahedra;
using testing::kSplit;
using testing::kStructured;
using testing::kTetsFile;
using testing::kXmlStructured;

using VtkBridge = testing::VtkFileTest;

double volume(const Geometry& geometry) {
  double sum = 0;
  std::visit(
      [&](const auto& points) {
        for (const Tet& t : geometry.tets) {
          const Determinant six = determinant(points, t);
          EXPECT_EQ(six.sign(), 1);
          sum += six.value / 6;
        }
      },
      geometry.points);
  return sum;
}

TEST_F(VtkBridge, ReadsTetrahedraAndLowerCells) {
  const auto mesh = open(kTetsFile);
  const MeshDescription& d = mesh->description();
  EXPECT_EQ(d.points, 6u);
  EXPECT_EQ(d.cells, 4u);
  EXPECT_EQ(d.pieces, 1u);
  EXPECT_EQ(d.point_type, ValueType::kFloat64);
  EXPECT_EQ(d.file_bytes, sizeof(kTetsFile) - 1);
  EXPECT_THAT(d.format, HasSubstr("legacy VTK"));

  const Geometry g = mesh->read_geometry();
  EXPECT_THAT(g.tets, ElementsAre(Tet{0, 1, 2, 3}, Tet{1, 2, 3, 4}));
  EXPECT_THAT(g.tet_source, ElementsAre(0, 2));
  EXPECT_THAT(g.lower.types, ElementsAre(5, 1));
  EXPECT_THAT(g.lower.offsets, ElementsAre(0, 3, 4));
  EXPECT_THAT(g.lower.connectivity, ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(g.lower_source, ElementsAre(1, 3));
  EXPECT_EQ(point_count(g.points), 5u);
  EXPECT_EQ(g.unused_points, 1u);
  EXPECT_THAT(g.point_source, ElementsAre(0, 1, 2, 3, 4));
  EXPECT_EQ(std::get<1>(g.points)[4].z, 1.0);
}

TEST_F(VtkBridge, ReadsAllArraysOfALegacyFile) {
  const auto mesh = open(kTetsFile);
  const MeshDescription& d = mesh->description();
  ASSERT_EQ(d.point_data.arrays.size(), 4u);
  ASSERT_EQ(d.cell_data.arrays.size(), 1u);
  EXPECT_EQ(d.point_data.active.at("Scalars"), "first");
  EXPECT_EQ(d.point_data.active.at("Vectors"), "velocity");

  const auto read = [&](Association association, const AttributeSet& set, const char* name) {
    return mesh->read_array(association, set.find(name));
  };
  const DataArray second = read(Association::kPoint, d.point_data, "second");
  EXPECT_EQ(second.info.type, ValueType::kInt16);
  EXPECT_THAT(second.as<std::int16_t>(), ElementsAre(10, 11, 12, 13, 14, 15));
  const DataArray velocity = read(Association::kPoint, d.point_data, "velocity");
  EXPECT_EQ(velocity.info.components, 3u);
  EXPECT_EQ(velocity.info.tuples, 6u);
  EXPECT_EQ(velocity.as<double>()[17], 6.0);
  const DataArray nine = read(Association::kPoint, d.point_data, "nine");
  EXPECT_EQ(nine.info.components, 9u);
  EXPECT_EQ(nine.as<float>()[53], 2.0f);
  const DataArray material = read(Association::kCell, d.cell_data, "material");
  EXPECT_THAT(material.as<std::int32_t>(), ElementsAre(7, 8, 9, 10));
}

TEST_F(VtkBridge, HexahedraNeedTheOption) {
  EXPECT_THAT(error_of(write("hex.vtk", kHexahedra)),
              AllOf(HasSubstr("cell 0"), HasSubstr("hexahedron"), HasSubstr("--tetrahedralize")));
}

TEST_F(VtkBridge, SplitsHexahedraAndTheQuadrilateralsOnThem) {
  const Geometry g = open(kHexahedra, kSplit)->read_geometry();
  EXPECT_DOUBLE_EQ(volume(g), 2.0);
  EXPECT_EQ(g.tet_source.size(), g.tets.size());
  EXPECT_EQ(g.tet_source.front(), 0u);
  EXPECT_EQ(g.tet_source.back(), 1u);
  // Cut at its smallest vertex like the hexahedron below.
  EXPECT_THAT(g.lower.connectivity, ElementsAre(2, 5, 11, 2, 11, 8));
  EXPECT_THAT(g.lower_source, ElementsAre(2, 2));
  for (const std::array<VertexId, 3>& triangle : {std::array<VertexId, 3>{2, 5, 11}, {2, 11, 8}}) {
    EXPECT_EQ(std::count_if(g.tets.begin(), g.tets.end(),
                            [&](const Tet& t) {
                              return std::all_of(triangle.begin(), triangle.end(), [&](VertexId v) {
                                return std::find(t.begin(), t.end(), v) != t.end();
                              });
                            }),
              1);
  }
}

TEST_F(VtkBridge, ReadsLegacyStructuredGrids) {
  const auto mesh = open(kStructured, kSplit);
  const Geometry g = mesh->read_geometry();
  EXPECT_DOUBLE_EQ(volume(g), 2.0);
  EXPECT_EQ(point_count(g.points), 12u);
  EXPECT_THAT(g.point_source, IsEmpty());
  EXPECT_THAT(error_of(write("grid.vtk", kStructured)), HasSubstr("--tetrahedralize"));
}

TEST_F(VtkBridge, ReadsXmlStructuredGridsWithoutGhosts) {
  const auto mesh = open_with_vtk(write("grid.vts", kXmlStructured), kSplit);
  const MeshDescription& d = mesh->description();
  EXPECT_EQ(d.point_type, ValueType::kFloat32);
  EXPECT_THAT(d.format, HasSubstr("StructuredGrid"));
  const Geometry g = mesh->read_geometry();
  EXPECT_DOUBLE_EQ(volume(g), 1.0);
  EXPECT_EQ(g.ghost_cells, 1u);
  EXPECT_EQ(g.unused_points, 4u);
  EXPECT_THAT(g.point_source, ElementsAre(0, 1, 3, 4, 6, 7, 9, 10));

  ASSERT_EQ(d.cell_data.arrays.size(), 1u);
  EXPECT_EQ(d.cell_data.arrays[0].name, "heat");
  EXPECT_EQ(d.cell_data.arrays[0].units, "W / m");
  EXPECT_EQ(d.point_data.active.at("GlobalIds"), "id");
  const std::size_t pair = d.point_data.find("pair");
  ASSERT_NE(pair, AttributeSet::npos);
  EXPECT_THAT(d.point_data.arrays[pair].component_names, ElementsAre("left", "right"));
  EXPECT_EQ(mesh->read_array(Association::kPoint, pair).as<std::uint8_t>()[23], 255);

  const std::size_t author = d.field_data.find("Author");
  ASSERT_NE(author, AttributeSet::npos);
  EXPECT_EQ(d.field_data.arrays[author].type, ValueType::kString);
  EXPECT_EQ(d.field_data.arrays[author].tuples, 2u);
  const DataArray names = mesh->read_array(Association::kField, author);
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(names.bytes.data()), names.bytes.size()),
            std::string("Ada\0Bob\0", 8));
  const std::size_t time = d.field_data.find("TimeValue");
  ASSERT_NE(time, AttributeSet::npos);
  EXPECT_THAT(mesh->read_array(Association::kField, time).as<double>(), ElementsAre(2.5));
}

TEST_F(VtkBridge, QuadraticTetrahedraNeedTheOption) {
  const std::string text = R"(# vtk DataFile Version 3.0
quadratic
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 10 float
0 0 0  2 0 0  0 2 0  0 0 2  1 0 0  1 1 0  0 1 0  0 0 1  1 0 1  0 1 1
CELLS 1 11
10 0 1 2 3 4 5 6 7 8 9
CELL_TYPES 1
24
)";
  EXPECT_THAT(error_of(write("q.vtk", text)), HasSubstr("--linearize"));
  const Geometry g = open(text, {.tetrahedralize = false, .linearize = true})->read_geometry();
  EXPECT_THAT(g.tets, ElementsAre(Tet{0, 1, 2, 3}));
  EXPECT_EQ(g.unused_points, 6u);
}

struct BothWays {
  Geometry native, vtk;
};

// A mesh of all kinds of cells that are read, as text for both readers. The types are those of
// VTK; `flags` is vtkGhostType.
constexpr char kMixed[] =
    R"(<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian">
<UnstructuredGrid><Piece NumberOfPoints="17" NumberOfCells="9">
<CellData><DataArray type="UInt8" Name="vtkGhostType" format="ascii">FLAGS</DataArray></CellData>
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">
  9 9 9  0 0 0  1 0 0  0 1 0  1 1 0  0 0 1  1 0 1  0 1 1  1 1 1  0.5 0.5 2
  3 0 0  3 1 0  3 0 1  2 2 2  2.1 2 2  2.2 2 2  2.3 2 2
</DataArray></Points><Cells>
<DataArray type="Int64" Name="connectivity" format="ascii">
  1 2 4 3 5 6 8 7    5 6 8 7 9    2 4 6 8    8 4 2 6    2 10 4 8
  2 13 10 14 4 15    9    5 9 16    10 2 4 6
</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">8 13 17 21 25 31 32 35 39</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">12 14 8 9 10 22 1 21 10</DataArray>
</Cells></Piece></UnstructuredGrid></VTKFile>
)";

TEST_F(VtkBridge, AgreesWithTheNativeReader) {
  const OpenOptions kAll = {.tetrahedralize = true, .linearize = true};
  for (const char* flags : {"0 0 0 0 0 0 0 0 1", "0 0 0 0 8 0 0 0 0", "0 0 32 16 0 2 0 4 40"}) {
    SCOPED_TRACE(flags);
    std::string text = kMixed;
    text.replace(text.find("FLAGS"), 5, flags);
    const std::string path = write("mixed.vtu", text);
    const BothWays g{open_mesh(path, kAll)->read_geometry(),
                     open_with_vtk(path, kAll)->read_geometry()};
    EXPECT_EQ(g.native.tets, g.vtk.tets);
    EXPECT_EQ(g.native.tet_source, g.vtk.tet_source);
    EXPECT_EQ(g.native.lower.types, g.vtk.lower.types);
    EXPECT_EQ(g.native.lower.offsets, g.vtk.lower.offsets);
    EXPECT_EQ(g.native.lower.connectivity, g.vtk.lower.connectivity);
    EXPECT_EQ(g.native.lower_source, g.vtk.lower_source);
    EXPECT_EQ(g.native.point_source, g.vtk.point_source);
    EXPECT_EQ(g.native.unused_points, g.vtk.unused_points);
    EXPECT_EQ(g.native.ghost_cells, g.vtk.ghost_cells);
    EXPECT_GE(g.native.ghost_cells, 1u);
    EXPECT_GT(g.native.lower.size(), 3u);
  }
  std::string text = kMixed;
  text.replace(text.find("FLAGS"), 5, "0 0 0 0 0 0 0 0 0");
  const std::string path = write("mixed.vtu", text);
  for (const OpenOptions& options :
       {OpenOptions{}, OpenOptions{.tetrahedralize = true, .linearize = false}}) {
    std::string native;
    try {
      open_mesh(path, options)->read_geometry();
    } catch (const Error& error) {
      native = error.what();
    }
    EXPECT_EQ(error_of(path, options), native);
  }
}

}  // namespace
}  // namespace tetfusion
