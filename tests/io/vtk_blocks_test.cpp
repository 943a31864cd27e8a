// Files of several blocks or pieces, which become one mesh.
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "support/vtk_file_test.h"

namespace tetfusion {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

using testing::values_at_points;
using VtkBlocks = testing::VtkFileTest;

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

constexpr char kFirstPoints[] = "0 0 0 1 0 0 0 1 0 0 0 1";
constexpr char kSecondPoints[] = "1 0 0 0 1 0 0 0 1 1 1 1";  // the first three are seen above

std::string array_text(const std::string& type, const std::string& name,
                       const std::string& values) {
  return R"(<DataArray type=")" + type + R"(" Name=")" + name + R"(" format="ascii">)" + values +
         "</DataArray>";
}

std::string two_blocks(const std::string& first, const std::string& second) {
  return R"(<VTKFile type="vtkMultiBlockDataSet" version="1.0">
<vtkMultiBlockDataSet><DataSet index="0" file=")" +
         first + R"("/><DataSet index="1" file=")" + second + R"("/>
</vtkMultiBlockDataSet></VTKFile>)";
}

TEST_F(VtkBlocks, MergesThePointsOfPieces) {
  write("a.vtu", piece_of_two(kFirstPoints, ""));
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

// What the list says of arrays is not what they are, and it does not name all.
TEST_F(VtkBlocks, TypesOfArraysAreThoseOfThePieces) {
  const auto arrays = [](const std::string& type, const std::string& name) {
    return "<PointData>" + array_text(type, "T", "1.5 2.5 3.5 4.5") + "</PointData><CellData>" +
           array_text("Int32", name, "7") + "</CellData>";
  };
  write("a.vtu", piece_of_two(kFirstPoints, arrays("Float64", "tag")));
  write("b.vtu", piece_of_two(kSecondPoints, arrays("Float32", "other")));
  const std::string path = write("both.pvtu", R"(<VTKFile type="PUnstructuredGrid" version="1.0">
<PUnstructuredGrid GhostLevel="0"><PPoints><PDataArray type="Float32" NumberOfComponents="3"/></PPoints>
<PPointData><PDataArray type="Float32" Name="T"/></PPointData>
<Piece Source="a.vtu"/><Piece Source="b.vtu"/></PUnstructuredGrid></VTKFile>)");
  const auto mesh = open_with_vtk(path);
  const MeshDescription& d = mesh->description();
  EXPECT_EQ(d.files.size(), 2u);
  ASSERT_EQ(d.point_data.arrays.size(), 1u);
  EXPECT_EQ(d.point_data.arrays[0].type, ValueType::kFloat64);
  EXPECT_THAT(mesh->read_array(Association::kPoint, 0).as<double>(),
              ElementsAre(1.5, 2.5, 3.5, 4.5, 1.5, 2.5, 3.5, 4.5));
  ASSERT_EQ(d.cell_data.arrays.size(), 2u);
  EXPECT_THAT(mesh->read_array(Association::kCell, 0).as<std::int32_t>(), ElementsAre(7, 0));
  EXPECT_THAT(mesh->read_array(Association::kCell, 1).as<std::int32_t>(), ElementsAre(0, 7));
}

// Doubles would make one of ids that follow one another beyond 2^53.
TEST_F(VtkBlocks, GlobalIdsKeepAllTheirDigits) {
  const auto ids = [](int first) {
    std::string text;
    for (int i = 0; i < 4; ++i) text += std::to_string((std::int64_t{1} << 60) + first + i) + " ";
    return "<PointData>" + array_text("Int64", "GlobalNodeIds", text) + "</PointData>";
  };
  write("a.vtu", piece_of_two(kFirstPoints, ids(0)));
  write("b.vtu", piece_of_two(kSecondPoints, ids(1)));
  const std::string path = write("both.vtm", two_blocks("a.vtu", "b.vtu"));
  const Geometry g = open_with_vtk(path)->read_geometry();
  EXPECT_EQ(g.merged_points, 3u);
  EXPECT_THAT(g.tets, ElementsAre(Tet{0, 1, 2, 3}, Tet{1, 2, 3, 4}));
}

TEST_F(VtkBlocks, BlocksWithoutAnArrayGetNotANumber) {
  write("a.vtu", piece_of_two(kFirstPoints, ""));
  write("b.vtu", piece_of_two(kSecondPoints, "<CellData>" + array_text("Float64", "heat", "3") +
                                                 array_text("Int32", "tag", "4") + "</CellData>"));
  const std::string path = write("both.vtm", two_blocks("a.vtu", "b.vtu"));
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

TEST_F(VtkBlocks, ArraysOfOneKindTakeTheWiderType) {
  const auto block = [](const char* points, const char* real, const char* whole) {
    return piece_of_two(points, "<PointData>" + array_text(real, "heat", "0.1 0.2 0.3 0.4") +
                                    array_text(whole, "tag", "200 201 202 203") + "</PointData>");
  };
  write("narrow.vtu", block(kFirstPoints, "Float32", "UInt8"));
  write("wide.vtu", block(kSecondPoints, "Float64", "Int64"));
  for (const bool narrow_first : {true, false}) {
    const std::string path = write("both.vtm", narrow_first ? two_blocks("narrow.vtu", "wide.vtu")
                                                            : two_blocks("wide.vtu", "narrow.vtu"));
    const auto mesh = open_with_vtk(path);
    const double of_narrow = 0.1F, of_wide = 0.4;  // the point that no other block has
    EXPECT_EQ(values_at_points<double>(mesh.get(), "heat").back(),
              narrow_first ? of_wide : of_narrow);
    EXPECT_EQ(values_at_points<std::int64_t>(mesh.get(), "tag").back(), narrow_first ? 203 : 200);
  }
}

TEST_F(VtkBlocks, ArraysThatHaveNoTypeInCommonAreRefused) {
  const auto with = [](const char* points, const char* type) {
    return piece_of_two(points,
                        "<PointData>" + array_text(type, "heat", "1 2 3 4") + "</PointData>");
  };
  write("a.vtu", with(kFirstPoints, "Int64"));
  for (const char* other : {"Float64", "UInt64"}) {
    write("b.vtu", with(kSecondPoints, other));
    const std::string path = write("both.vtm", two_blocks("a.vtu", "b.vtu"));
    EXPECT_THAT([&] { open_with_vtk(path); },
                ::testing::ThrowsMessage<Error>(HasSubstr(
                    std::string("point array 'heat' is Int64 with 1 component in one block and ") +
                    other + " with 1 component in another")));
  }
}

TEST_F(VtkBlocks, SeamsTakeValuesFromTheFirstBlockThatHasThem) {
  write("plain.vtu", piece_of_two(kFirstPoints, ""));
  write("rich.vtu",
        piece_of_two(kSecondPoints, "<PointData>" + array_text("Float64", "heat", "1 2 3 4") +
                                        array_text("Int32", "tag", "5 6 7 8") + "</PointData>"));
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
TEST_F(VtkBlocks, CountsPointsWithOtherValuesInAnotherBlock) {
  const auto values = [](const std::string& heat, const std::string& two) {
    return "<PointData>" + array_text("Float64", "heat", heat) +
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
  EXPECT_EQ(g.largest_difference.array, mesh->description().point_data.find("heat"));
  EXPECT_EQ(g.largest_difference.share, 7.0 / 8);  // 2 and 9, of a range from 1 to 9
  const ::testing::Matcher<double> nothing = ::testing::IsNan();
  EXPECT_THAT(values_at_points<double>(mesh.get(), "heat"),
              ElementsAre(nothing, 1, 2, nothing, 4, 4));
}

TEST_F(VtkBlocks, ReadsPartitionedDataSets) {
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

TEST_F(VtkBlocks, CellsSayWhichOfSeveralBlocksTheyAreOf) {
  const std::string named = "<CellData>" + array_text("Int32", "block", "7") + "</CellData>";
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
  // A patch of triangles is a block, too; the pieces of a block are none.
  EXPECT_THAT(block_of_each_cell(write("s.vtm", blocks(set(0, "side.vtu") + set(1, "b.vtu")))),
              ElementsAre(0, 1));
  const std::string pieces =
      R"(<Piece index="0">)" + set(0, "a.vtu") + set(1, "b.vtu") + "</Piece>";
  EXPECT_THAT(block_of_each_cell(write("p.vtm", blocks(pieces))), IsEmpty());
  EXPECT_THAT(block_of_each_cell(write("n.vtm", blocks(set(0, "a.vtu") + set(1, "named.vtu")))),
              ElementsAre(0, 7));
}

TEST_F(VtkBlocks, NamesOfBlocksBecomeFieldData) {
  write("a.vtu", piece_of_two(kFirstPoints, ""));
  write("b.vtu", piece_of_two(kSecondPoints, ""));
  std::string blocks = two_blocks("a.vtu", "b.vtu");
  const auto names = [&] {
    const auto mesh = open_with_vtk(write("n.vtm", blocks));
    const std::size_t at = mesh->description().field_data.find("block_names");
    if (at == AttributeSet::npos) return std::string();
    const auto bytes = mesh->read_array(Association::kField, at).bytes;
    std::string all(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    std::replace(all.begin(), all.end(), '\0', '|');
    return all;
  };
  EXPECT_EQ(names(), "");
  blocks.insert(blocks.find("file="), "name=\"rock mass\" ");
  EXPECT_EQ(names(), "rock mass||");
}

TEST_F(VtkBlocks, OtherFieldDataOfLaterBlocksAreTold) {
  const auto with_step = [](std::string piece, const std::string& step) {
    std::string data = "<FieldData>" + array_text("Int32", "step", step) + "</FieldData>";
    data.insert(data.find(" format"), " NumberOfTuples=\"1\"");
    return piece.insert(piece.find("<Piece"), data);
  };
  const std::string path = write("m.vtm", two_blocks("a.vtu", "b.vtu"));
  write("a.vtu", with_step(piece_of_two(kFirstPoints, ""), "7"));
  write("b.vtu", with_step(piece_of_two(kSecondPoints, ""), "7"));
  EXPECT_THAT(open_with_vtk(path)->description().left_out, IsEmpty());
  write("b.vtu", with_step(piece_of_two(kSecondPoints, ""), "8"));
  EXPECT_THAT(open_with_vtk(path)->description().left_out,
              ElementsAre("other values of field array 'step' in later blocks"));
}

}  // namespace
}  // namespace tetfusion
