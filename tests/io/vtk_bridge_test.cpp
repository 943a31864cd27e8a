#include "io/vtk_bridge.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>

#include "base/error.h"
#include "mesh/predicates.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::filesystem::path plugin_file() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / "tetfusion-vtk.so";
}

// Two tetrahedra that share triangle (1, 2, 3), a triangle, a vertex, and point 5, which nobody
// uses.
constexpr char kTetsFile[] = R"(# vtk DataFile Version 3.0
two tetrahedra
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 6 double
0 0 0  1 0 0  0 1 0  0 0 1  1 1 1  9 9 9
CELLS 4 16
4 0 1 2 3
3 1 2 3
4 1 2 3 4
1 4
CELL_TYPES 4
10 5 10 1
CELL_DATA 4
SCALARS material int 1
LOOKUP_TABLE default
7 8 9 10
POINT_DATA 6
SCALARS first float 1
LOOKUP_TABLE default
0 1 2 3 4 5
SCALARS second short 1
LOOKUP_TABLE default
10 11 12 13 14 15
VECTORS velocity double
0 0 0  1 0 0  2 0 0  3 0 0  4 0 0  5 0 6
FIELD FieldData 1
nine 9 6 float
1 0 0 0 1 0 0 0 1
1 0 0 0 1 0 0 0 1
1 0 0 0 1 0 0 0 1
1 0 0 0 1 0 0 0 1
1 0 0 0 1 0 0 0 1
1 0 0 0 1 0 0 0 2
)";

// Two hexahedra side by side, a quadrilateral on the second one.
constexpr char kHexahedra[] = R"(# vtk DataFile Version 3.0
two hexahedra
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 12 float
0 0 0  1 0 0  2 0 0  0 1 0  1 1 0  2 1 0
0 0 1  1 0 1  2 0 1  0 1 1  1 1 1  2 1 1
CELLS 3 23
8 0 1 4 3 6 7 10 9
8 1 2 5 4 7 8 11 10
4 2 5 11 8
CELL_TYPES 3
12 12 9
CELL_DATA 3
SCALARS number int 1
LOOKUP_TABLE default
0 1 2
)";

constexpr char kStructured[] = R"(# vtk DataFile Version 3.0
a bent grid
ASCII
DATASET STRUCTURED_GRID
DIMENSIONS 3 2 2
POINTS 12 double
0 0 0  1 0 0  2 0 1  0 1 0  1 1 0  2 1 1
0 0 1  1 0 1  2 0 2  0 1 1  1 1 1  2 1 2
POINT_DATA 12
SCALARS height double 1
LOOKUP_TABLE default
0 0 1 0 0 1 1 1 2 1 1 2
)";

constexpr char kXmlStructured[] = R"(<?xml version="1.0"?>
<VTKFile type="StructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">
  <StructuredGrid WholeExtent="0 2 0 1 0 1">
    <FieldData>
      <DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">2.5</DataArray>
      <DataArray type="String" Name="Author" NumberOfTuples="2" format="ascii">
        65 100 97 0 66 111 98 0
      </DataArray>
    </FieldData>
    <Piece Extent="0 2 0 1 0 1">
      <PointData Scalars="id" GlobalIds="id">
        <DataArray type="Int64" Name="id" format="ascii">
          20 21 22 23 24 25 26 27 28 29 30 31
        </DataArray>
        <DataArray type="UInt8" Name="pair" NumberOfComponents="2" ComponentName0="left"
                   ComponentName1="right" format="ascii">
          0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 255
        </DataArray>
      </PointData>
      <CellData>
        <DataArray type="UInt8" Name="vtkGhostType" format="ascii">0 1</DataArray>
        <DataArray type="Float32" Name="heat" format="ascii">1.5 2.5</DataArray>
      </CellData>
      <Points>
        <DataArray type="Float32" NumberOfComponents="3" format="ascii">
          0 0 0  1 0 0  2 0 0  0 1 0  1 1 0  2 1 0
          0 0 1  1 0 1  2 0 1  0 1 1  1 1 1  2 1 1
        </DataArray>
      </Points>
    </Piece>
  </StructuredGrid>
</VTKFile>
)";

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

class VtkBridge : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(plugin_file())) {
      GTEST_SKIP() << plugin_file() << " is not built: VTK was not found";
    }
  }

  std::string write(const std::string& name, const std::string& text) {
    std::ofstream(dir_.file(name), std::ios::binary) << text;
    return dir_.file(name);
  }

  std::unique_ptr<MeshSource> open(const std::string& text, const OpenOptions& options = {}) {
    return open_with_vtk(write("mesh.vtk", text), options);
  }

  // The message of the Error that opening and reading throws; nothing may be printed meanwhile.
  std::string error_of(const std::string& path, const OpenOptions& options = {},
                       ErrorCode expected = ErrorCode::kBadInput) {
    std::string message = "no error";
    ::testing::internal::CaptureStderr();
    ::testing::internal::CaptureStdout();
    try {
      open_with_vtk(path, options)->read_geometry();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), expected);
      message = error.what();
    }
    EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
    if (message != "no error") {
      EXPECT_THAT(message, HasSubstr(path));
    }
    return message;
  }

  testing::TempDir dir_;
};

const OpenOptions kSplit = {.tetrahedralize = true, .linearize = false};

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

std::string piece_of_two(const std::string& points, const std::string& arrays) {
  return R"(<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian">
<UnstructuredGrid><Piece NumberOfPoints="4" NumberOfCells="1">)" +
         arrays + R"(<Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">)" +
         points +
         R"(</DataArray></Points><Cells>
<DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 3</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">4</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">10</DataArray>
</Cells></Piece></UnstructuredGrid></VTKFile>)";
}

TEST_F(VtkBridge, MergesThePointsOfPieces) {
  write("a.vtu", piece_of_two("0 0 0 1 0 0 0 1 0 0 0 1", ""));
  write("b.vtu", piece_of_two("1 0 0 0 1 0 -0.0 0 1 1 1 1", ""));
  const std::string path = write("both.pvtu", R"(<VTKFile type="PUnstructuredGrid" version="1.0">
<PUnstructuredGrid GhostLevel="0"><PPoints><PDataArray type="Float32" NumberOfComponents="3"/></PPoints>
<Piece Source="a.vtu"/><Piece Source="b.vtu"/></PUnstructuredGrid></VTKFile>)");
  const auto mesh = open_with_vtk(path);
  EXPECT_EQ(mesh->description().pieces, 2u);
  const Geometry g = mesh->read_geometry();
  EXPECT_THAT(g.tets, ElementsAre(Tet{0, 1, 2, 3}, Tet{1, 2, 3, 4}));
  EXPECT_EQ(g.merged_points, 3u);
  EXPECT_THAT(g.point_source, ElementsAre(0, 1, 2, 3, 7));
}

// Doubles would make one of ids that follow one another beyond 2^53.
TEST_F(VtkBridge, GlobalIdsKeepAllTheirDigits) {
  const auto ids = [](int first) {
    std::string text;
    for (int i = 0; i < 4; ++i) text += std::to_string((std::int64_t{1} << 60) + first + i) + " ";
    return R"(<PointData><DataArray type="Int64" Name="GlobalNodeIds" format="ascii">)" + text +
           "</DataArray></PointData>";
  };
  write("a.vtu", piece_of_two("0 0 0 1 0 0 0 1 0 0 0 1", ids(0)));
  write("b.vtu", piece_of_two("1 0 0 0 1 0 0 0 1 1 1 1", ids(1)));
  const std::string path = write("both.vtm", R"(<VTKFile type="vtkMultiBlockDataSet" version="1.0">
<vtkMultiBlockDataSet><DataSet index="0" file="a.vtu"/><DataSet index="1" file="b.vtu"/>
</vtkMultiBlockDataSet></VTKFile>)");
  const Geometry g = open_with_vtk(path)->read_geometry();
  EXPECT_EQ(g.merged_points, 3u);
  EXPECT_THAT(g.tets, ElementsAre(Tet{0, 1, 2, 3}, Tet{1, 2, 3, 4}));
}

TEST_F(VtkBridge, BlocksWithoutAnArrayGetNotANumber) {
  write("a.vtu", piece_of_two("0 0 0 1 0 0 0 1 0 0 0 1", ""));
  write("b.vtu", piece_of_two("1 0 0 0 1 0 0 0 1 1 1 1",
                              R"(<CellData><DataArray type="Float64" Name="heat" format="ascii">3
</DataArray><DataArray type="Int32" Name="tag" format="ascii">4</DataArray></CellData>)"));
  const std::string path = write("both.vtm", R"(<VTKFile type="vtkMultiBlockDataSet" version="1.0">
<vtkMultiBlockDataSet><DataSet index="0" file="a.vtu"/><DataSet index="1" file="b.vtu"/>
</vtkMultiBlockDataSet></VTKFile>)");
  const auto mesh = open_with_vtk(path);
  EXPECT_EQ(mesh->read_geometry().tets.size(), 2u);
  const AttributeSet& set = mesh->description().cell_data;
  const DataArray heat = mesh->read_array(Association::kCell, set.find("heat"));
  ASSERT_EQ(heat.info.tuples, 2u);
  EXPECT_NE(heat.as<double>()[0], heat.as<double>()[0]);
  EXPECT_EQ(heat.as<double>()[1], 3.0);
  const DataArray tag = mesh->read_array(Association::kCell, set.find("tag"));
  EXPECT_THAT(tag.as<std::int32_t>(), ElementsAre(0, 4));
}

std::string point_values(const std::string& type, const std::string& name,
                         const std::string& values) {
  return R"(<DataArray type=")" + type + R"(" Name=")" + name + R"(" format="ascii">)" + values +
         "</DataArray>";
}

constexpr char kFirstPoints[] = "0 0 0 1 0 0 0 1 0 0 0 1";
constexpr char kSecondPoints[] = "1 0 0 0 1 0 0 0 1 1 1 1";  // the first three are seen above

std::string two_blocks(const std::string& first, const std::string& second) {
  return R"(<VTKFile type="vtkMultiBlockDataSet" version="1.0">
<vtkMultiBlockDataSet><DataSet index="0" file=")" +
         first + R"("/><DataSet index="1" file=")" + second + R"("/>
</vtkMultiBlockDataSet></VTKFile>)";
}

// What points have in the mesh, those of one block after those of the other.
template <class T>
std::vector<T> values_at_points(MeshSource* mesh, const std::string& name) {
  const AttributeSet& set = mesh->description().point_data;
  const DataArray array = mesh->read_array(Association::kPoint, set.find(name));
  std::vector<T> values;
  for (const std::uint64_t row : mesh->read_geometry().point_source) {
    values.push_back(array.as<T>()[row]);
  }
  return values;
}

TEST_F(VtkBridge, SeamsTakeValuesFromTheFirstBlockThatHasThem) {
  write("plain.vtu", piece_of_two(kFirstPoints, ""));
  write("rich.vtu",
        piece_of_two(kSecondPoints, "<PointData>" + point_values("Float64", "heat", "1 2 3 4") +
                                        point_values("Int32", "tag", "5 6 7 8") + "</PointData>"));
  for (const bool plain_first : {true, false}) {
    SCOPED_TRACE(plain_first);
    const std::string path = write("both.vtm", plain_first ? two_blocks("plain.vtu", "rich.vtu")
                                                           : two_blocks("rich.vtu", "plain.vtu"));
    const auto mesh = open_with_vtk(path);
    const auto heat = values_at_points<double>(mesh.get(), "heat");
    const auto tag = values_at_points<std::int32_t>(mesh.get(), "tag");
    const ::testing::Matcher<double> nothing = ::testing::IsNan();
    if (plain_first) {
      EXPECT_THAT(heat, ElementsAre(nothing, 1, 2, 3, 4));
      EXPECT_THAT(tag, ElementsAre(0, 5, 6, 7, 8));
    } else {
      EXPECT_THAT(heat, ElementsAre(1, 2, 3, 4, nothing));
      EXPECT_THAT(tag, ElementsAre(5, 6, 7, 8, 0));
    }
    // Nor has the copy that is merged anything else.
    const DataArray rows =
        mesh->read_array(Association::kPoint, mesh->description().point_data.find("heat"));
    const auto all = rows.as<double>();
    EXPECT_EQ(std::count_if(all.begin(), all.end(), [](double x) { return x != x; }), 1);
    EXPECT_EQ(mesh->read_geometry().differing_points, 0u);
  }
}

// The value is the second block's: the first one lacks the array.
TEST_F(VtkBridge, CountsPointsWithOtherValuesInAnotherBlock) {
  const auto values = [](const std::string& heat, const std::string& two) {
    return "<PointData>" + point_values("Float64", "heat", heat) +
           R"(<DataArray type="Int32" Name="two" NumberOfComponents="2" format="ascii">)" + two +
           "</DataArray></PointData>";
  };
  write("a.vtu", piece_of_two(kFirstPoints, ""));
  write("b.vtu", piece_of_two(kSecondPoints, values("1 2 nan 4", "1 1 2 2 3 3 4 4")));
  write("c.vtu",
        piece_of_two("1 0 0 0 1 0 0 0 1 -1 -1 -1", values("1 9 nan 4", "1 1 0 2 3 8 4 4")));
  const std::string path = write("three.vtm", R"(<VTKFile type="vtkMultiBlockDataSet" version="1.0">
<vtkMultiBlockDataSet><DataSet index="0" file="a.vtu"/><DataSet index="1" file="b.vtu"/>
<DataSet index="2" file="c.vtu"/></vtkMultiBlockDataSet></VTKFile>)");
  const auto mesh = open_with_vtk(path);
  const Geometry g = mesh->read_geometry();
  EXPECT_EQ(g.merged_points, 6u);
  EXPECT_EQ(g.differing_points, 2u);
  const ::testing::Matcher<double> nothing = ::testing::IsNan();
  EXPECT_THAT(values_at_points<double>(mesh.get(), "heat"),
              ElementsAre(nothing, 1, 2, nothing, 4, 4));
}

TEST_F(VtkBridge, ReadsPartitionedDataSets) {
  write("a.vtu", piece_of_two(kFirstPoints, ""));
  write("b.vtu", piece_of_two(kSecondPoints, ""));
  const std::string parts = R"(<DataSet index="0" file="a.vtu"/><DataSet index="1" file="b.vtu"/>)";
  const std::string partitioned = "vtkPartitionedDataSet";
  const auto file = [](const std::string& type, const std::string& contents) {
    return R"(<VTKFile type=")" + type + R"(" version="1.0"><)" + type + ">" + contents + "</" +
           type + "></VTKFile>";
  };
  const std::vector<std::string> paths{
      write("p.vtpd", file(partitioned, parts)),
      write("p.vtpc", file(partitioned + "Collection",
                           R"(<Partitions index="0">)" + parts + "</Partitions>")),
      write("q.vtpc", file(partitioned + "Collection",
                           R"(<Partitions index="0"><DataSet index="0" file="a.vtu"/></Partitions>
<Partitions index="1"><DataSet index="0" file="b.vtu"/></Partitions>)"))};
  for (const std::string& path : paths) {
    SCOPED_TRACE(path);
    const auto mesh = open_with_vtk(path);
    EXPECT_EQ(mesh->description().pieces, 2u);
    const Geometry g = mesh->read_geometry();
    EXPECT_THAT(g.tets, ElementsAre(Tet{0, 1, 2, 3}, Tet{1, 2, 3, 4}));
    EXPECT_EQ(g.merged_points, 3u);
  }
  EXPECT_THAT(error_of(write("p.vtpd", file(partitioned, R"(<DataSet index="0" file="no.vtu"/>)"))),
              HasSubstr("VTK"));
}

std::vector<std::int32_t> block_of_each_cell(const std::string& path) {
  const auto mesh = open_with_vtk(path);
  const std::size_t at = mesh->description().cell_data.find("block");
  if (at == AttributeSet::npos) return {};
  const auto values = mesh->read_array(Association::kCell, at);
  const auto all = values.as<std::int32_t>();
  return {all.begin(), all.end()};
}

TEST_F(VtkBridge, CellsSayWhichOfSeveralBlocksTheyAreOf) {
  const std::string named = "<CellData>" + point_values("Int32", "block", "7") + "</CellData>";
  write("a.vtu", piece_of_two(kFirstPoints, ""));
  write("b.vtu", piece_of_two(kSecondPoints, ""));
  write("named.vtu", piece_of_two(kSecondPoints, named));
  std::string side = piece_of_two(kSecondPoints, "");
  const auto change = [&](const std::string& from, const std::string& to) {
    side.replace(side.find(from), from.size(), to);
  };
  change("0 1 2 3<", "0 1 2<");
  change(">4<", ">3<");
  change(">10<", ">5<");
  write("side.vtu", side);
  const auto blocks = [](const std::string& contents) {
    return R"(<VTKFile type="vtkMultiBlockDataSet" version="1.0"><vtkMultiBlockDataSet>)" +
           contents + "</vtkMultiBlockDataSet></VTKFile>";
  };
  const auto set = [](int index, const std::string& name) {
    return "<DataSet index=\"" + std::to_string(index) + "\" file=\"" + name + "\"/>";
  };
  EXPECT_THAT(
      block_of_each_cell(write("m.vtm", blocks(set(0, "side.vtu") + R"(<Block index="1">)" +
                                               set(0, "a.vtu") + set(1, "b.vtu") + "</Block>"))),
      ElementsAre(0, 1, 2));
  // A block of triangles is none of them, nor are the pieces of one block.
  EXPECT_THAT(block_of_each_cell(write("s.vtm", blocks(set(0, "side.vtu") + set(1, "b.vtu")))),
              IsEmpty());
  const std::string pieces =
      R"(<Piece index="0">)" + set(0, "a.vtu") + set(1, "b.vtu") + "</Piece>";
  EXPECT_THAT(block_of_each_cell(write("p.vtm", blocks(pieces))), IsEmpty());
  EXPECT_THAT(block_of_each_cell(write("n.vtm", blocks(set(0, "a.vtu") + set(1, "named.vtu")))),
              ElementsAre(0, 7));
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

std::string with_cell(const std::string& cell, const std::string& type) {
  return R"(# vtk DataFile Version 3.0
one cell
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 5 float
0 0 0  1 0 0  0 1 0  0 0 1  1 1 1
CELLS 1 )" +
         std::to_string(1 + std::count(cell.begin(), cell.end(), ' ')) + "\n" + cell +
         "\nCELL_TYPES 1\n" + type + "\n";
}

TEST_F(VtkBridge, NamesTheCellThatIsWrong) {
  EXPECT_THAT(error_of(write("a.vtk", with_cell("4 0 1 2 7", "10"))),
              AllOf(HasSubstr("cell 0"), HasSubstr("point 7"), HasSubstr("5")));
  EXPECT_THAT(error_of(write("b.vtk", with_cell("4 0 1 2 -1", "10"))), HasSubstr("point -1"));
  EXPECT_THAT(error_of(write("c.vtk", with_cell("3 0 1 2", "10"))), HasSubstr("has 3 vertices"));
  EXPECT_THAT(error_of(write("d.vtk", with_cell("4 0 1 2 3", "7")), kSplit), HasSubstr("polygon"));
  EXPECT_THAT(error_of(write("e.vtk", with_cell("3 0 1 2", "5"))), HasSubstr("no tetrahedra"));
  EXPECT_THAT(error_of(write("f.vtk", with_cell("0", "0"))), HasSubstr("empty cell"));
}

TEST_F(VtkBridge, TellsAnInvalidMeshFromADamagedFile) {
  const auto is_invalid = [&](const std::string& text) {
    try {
      open(text)->read_geometry();
    } catch (const InvalidMesh& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBadInput);
      return true;
    } catch (const Error&) {
    }
    return false;
  };
  EXPECT_TRUE(is_invalid(with_cell("4 0 1 2 7", "10")));
  EXPECT_TRUE(is_invalid(with_cell("4 0 1 2 -1", "10")));
  EXPECT_FALSE(is_invalid(with_cell("3 0 1 2", "10")));
  EXPECT_FALSE(is_invalid(kHexahedra));
}

// What both readers make of one mesh.
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

TEST_F(VtkBridge, NamesThePointThatIsNotFinite) {
  // Binary legacy files are big-endian. The ids fit into the last byte.
  std::string text =
      "# vtk DataFile Version 3.0\nx\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 float\n";
  const std::string zero(4, '\0'), one("\x3f\x80\0\0", 4), nan("\x7f\xc0\0\0", 4);
  text += zero + zero + zero + one + zero + zero + zero + one + zero;
  text += zero + zero + one + zero + nan + zero;
  text += "\nCELLS 1 5\n";
  const std::string with_nan = std::string("\0\0\0\4\0\0\0\0\0\0\0\1\0\0\0\2\0\0\0\4", 20);
  const std::string without = std::string("\0\0\0\4\0\0\0\0\0\0\0\1\0\0\0\2\0\0\0\3", 20);
  const std::string end = std::string("\nCELL_TYPES 1\n\0\0\0\12", 18);
  EXPECT_THAT(error_of(write("a.vtk", text + with_nan + end)),
              AllOf(HasSubstr("point 4"), HasSubstr("finite")));
  // Nobody uses it now.
  EXPECT_EQ(error_of(write("b.vtk", text + without + end)), "no error");
}

TEST_F(VtkBridge, MissingEmptyAndForeignFiles) {
  error_of(dir_.file("missing.vtk"), {}, ErrorCode::kIo);
  EXPECT_THAT(error_of(write("empty.vtk", "")), HasSubstr("empty"));
  EXPECT_THAT(error_of(write("garbage.vtk", "this is not a mesh\n")), HasSubstr("not a mesh file"));
  EXPECT_THAT(error_of(write("garbage.e", "CDF\001 and no more")), HasSubstr("Exodus"));
  EXPECT_THAT(
      error_of(write("other.vtk", "# vtk DataFile Version 3.0\nx\nASCII\nDATASET WHATEVER\n")),
      HasSubstr("VTK"));
}

TEST_F(VtkBridge, TruncatedFilesAreErrorsThatVtkDoesNotPrint) {
  for (const auto& [name, text] : {std::pair<std::string, std::string>{"t.vtk", kTetsFile},
                                   {"h.vtk", kHexahedra},
                                   {"s.vtk", kStructured},
                                   {"x.vts", kXmlStructured}}) {
    int errors = 0;
    for (std::size_t length = 30; length < text.size() * 9 / 10; length += 31) {
      errors += error_of(write(name, text.substr(0, length)), kSplit) != "no error" ? 1 : 0;
    }
    // What comes after the cells of a legacy file may be missing as a whole without anyone
    // noticing.
    EXPECT_GE(errors, 4) << name;
  }
  EXPECT_THAT(error_of(write("x.vts", std::string(kXmlStructured).substr(0, 900))),
              HasSubstr("VTK cannot read it"));
  const std::string tets = kTetsFile;
  EXPECT_NE(error_of(write("t.vtk", tets.substr(0, tets.find("1 2 3 4")))), "no error");
}

TEST_F(VtkBridge, FilesThatCrashVtkAreErrors) {
  // VTK 9.1 dereferences a null pointer here.
  EXPECT_NE(
      error_of(write("field.vtk",
                     "# vtk DataFile Version 3.0\nx\nBINARY\nDATASET STRUCTURED_GRID\nFIELD F")),
      "no error");
}

TEST(VtkBridgeWithoutPlugin, SaysHowToGetIt) {
  if (std::filesystem::exists(plugin_file())) GTEST_SKIP() << "the plugin is built";
  const testing::TempDir dir;
  std::ofstream(dir.file("a.vtk")) << kTetsFile;
  try {
    open_with_vtk(dir.file("a.vtk"));
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadInput);
    EXPECT_THAT(error.what(), AllOf(HasSubstr(dir.file("a.vtk")), HasSubstr("legacy VTK file"),
                                    HasSubstr(".vtu"), HasSubstr("libvtk9-dev")));
  }
}

TEST(VtkBridgeWithoutPlugin, ABrokenPluginIsAnError) {
  const testing::TempDir dir;
  std::ofstream(dir.file("a.vtk")) << kTetsFile;
  std::ofstream(dir.file("tetfusion-vtk.so")) << "not a library";
  ::setenv("TETFUSION_PLUGIN_PATH", dir.path().c_str(), 1);
  try {
    open_with_vtk(dir.file("a.vtk"));
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadInput);
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr(dir.file("tetfusion-vtk.so")), HasSubstr("cannot be loaded")));
  }
  ::unsetenv("TETFUSION_PLUGIN_PATH");
}

FormatGuess guess(std::string_view text) {
  return guess_format(std::as_bytes(std::span(text.data(), text.size())));
}

TEST(GuessFormat, KnowsTheFirstBytes) {
  EXPECT_EQ(guess(kTetsFile).format, ForeignFormat::kLegacyVtk);
  EXPECT_EQ(guess(kXmlStructured).format, ForeignFormat::kXmlVtk);
  EXPECT_EQ(guess(kXmlStructured).words, "a VTK XML file of type StructuredGrid");
  EXPECT_FALSE(guess(kXmlStructured).is_list);
  EXPECT_TRUE(guess("<VTKFile type=\"Collection\">").is_list);
  EXPECT_THAT(guess("<VTKFile type=\"PUnstructuredGrid\">").words, HasSubstr("several files"));
  EXPECT_EQ(guess("<VTKFile").words, "a VTK XML file");
  EXPECT_EQ(guess("<VTKFile type=").words, "a VTK XML file");
  EXPECT_EQ(guess("<VTKFile type=\"").words, "a VTK XML file");
  EXPECT_EQ(guess("CDF\001").format, ForeignFormat::kNetCdf);
  EXPECT_EQ(guess("\x89HDF\r\n\x1a\n").format, ForeignFormat::kHdf5);
  EXPECT_EQ(guess("hello").format, ForeignFormat::kUnknown);
  EXPECT_EQ(guess("").format, ForeignFormat::kUnknown);
}

}  // namespace
}  // namespace tetfusion
