// XDMF files with several grids, steps and blocks, and what they take from one another.
#include <cstddef>
#include <cstdint>
#include <string>

#include "io/open_mesh.h"
#include "support/xdmf_files.h"

namespace tetfusion {
namespace {

using ::testing::AllOf;
using testing::data_item;
using ::testing::ElementsAre;
using testing::grid_array;
using ::testing::HasSubstr;
using testing::heat_of;
using ::testing::IsEmpty;
using testing::kTwoTets;
using testing::raw_bytes;
using testing::replaced;
using testing::rows_of_array;
using testing::xdmf_text;

using XdmfGrids = testing::XdmfTest;

// Two steps of a temporal collection, each with what is given.
std::string at_times(const std::string& name, const std::string& first, const std::string& second) {
  return "<Grid Name=\"" + name + "\" GridType=\"Collection\" CollectionType=\"Temporal\">" +
         "<Grid><Time Value=\"0.5\"/>" + first + "</Grid><Grid><Time Value=\" +1.5 \"/>" + second +
         "</Grid></Grid>";
}

TEST_F(XdmfGrids, StepsAreThoseOfATemporalCollection) {
  const std::string again =
      "<xi:include xpointer=\"xpointer(//Grid[@Name=&quot;run&quot;]/Grid[1]/*[self::Topology or "
      "self::Geometry])\"/>";
  const std::string path =
      write("run.xdmf", xdmf_text(at_times("run", kTwoTets + heat_of("1"), again + heat_of("2"))));
  EXPECT_THAT(time_steps_of(path), ElementsAre(0.5, 1.5));
  for (const std::uint64_t step : {0, 1}) {
    OpenOptions options;
    options.time_step = step;
    const auto mesh = open_mesh(path, options);
    expect_two_tets(mesh.get());
    const double number = static_cast<double>(step) + 1;
    EXPECT_THAT(rows_of_array<double>(mesh.get(), Association::kCell, "heat"),
                ElementsAre(number, number));
    EXPECT_THAT(rows_of_array<double>(mesh.get(), Association::kField, "TimeValue"),
                ElementsAre(step == 0 ? 0.5 : 1.5));
    EXPECT_THAT(mesh->description().left_out, IsEmpty());
  }
  EXPECT_THAT(open_mesh(path)->description().left_out,
              ElementsAre(HasSubstr("the time steps from 1.5 to 1.5 (the first of 2")));
}

TEST_F(XdmfGrids, TimesAreSaidInSeveralWays) {
  const auto steps_of = [&](const std::string& domain) {
    return time_steps_of(write("run.xdmf", xdmf_text(domain)));
  };
  const auto collection = [](const std::string& time, int steps) {
    std::string text = "<Grid GridType=\"Collection\" CollectionType=\"temporal\">" + time;
    for (int i = 0; i < steps; ++i) text += "<Grid>" + std::string(kTwoTets) + "</Grid>";
    return text + "</Grid>";
  };
  const auto timed = [](const std::string& value) {
    return "<Grid><Time Value=\"" + value + "\"/>" + kTwoTets + "</Grid>";
  };
  EXPECT_THAT(
      steps_of(collection(
          "<Time TimeType=\"List\">" + data_item("Dimensions=\"3\"", "1 2 4") + "</Time>", 3)),
      ElementsAre(1, 2, 4));
  EXPECT_THAT(steps_of(collection("<Time TimeType=\"HyperSlab\">" +
                                      data_item("Dimensions=\"3\"", "1 0.5 3") + "</Time>",
                                  3)),
              ElementsAre(1, 1.5, 2));
  EXPECT_THAT(steps_of(collection("", 2)), ElementsAre(0, 1));
  EXPECT_THAT(steps_of(timed("7")), ElementsAre(7));
  EXPECT_THAT(steps_of(timed("7") + timed("8")), ElementsAre(7, 8));
  EXPECT_THAT(steps_of(timed("7") + timed("7")), ElementsAre(7));
  EXPECT_THAT(steps_of(at_times("a", kTwoTets, kTwoTets) + timed("3")), ElementsAre(0.5, 1.5));
  // A collection for each step, all of one name.
  const std::string each = "<Grid Name=\"t\" GridType=\"Collection\" CollectionType=\"Temporal\">";
  EXPECT_THAT(steps_of(each + timed("1") + "</Grid>" + each + timed("2") + "</Grid>"),
              ElementsAre(1, 2));
  // Where times begin again they are parts of the mesh, beside one another.
  const std::string both = each + timed("1") + timed("2") + "</Grid>";
  EXPECT_THAT(steps_of(both + both), ElementsAre(1, 2));
  EXPECT_THAT(fault_of(xdmf_text(collection(
                  "<Time Type=\"List\">" + data_item("Dimensions=\"3\"", "1 2 4") + "</Time>", 2))),
              HasSubstr("has 3 times for 2 grids"));
  EXPECT_THAT(fault_of(xdmf_text(timed("soon"))), HasSubstr("Value 'soon', which is no number"));
}

// Several functions of one mesh, each with steps of its own.
TEST_F(XdmfGrids, CollectionsWithOtherTimesAreReadByTime) {
  const auto grid = [](const std::string& time, const std::string& name) {
    return "<Grid><Time Value=\"" + time + "\"/>" + kTwoTets +
           grid_array(name, "Cell", data_item("", time + " " + time)) + "</Grid>";
  };
  const auto collection = [](const std::string& name, const std::string& grids) {
    return "<Grid Name=\"" + name + "\" GridType=\"Collection\" CollectionType=\"Temporal\">" +
           grids + "</Grid>";
  };
  const std::string path = write(
      "run.xdmf", xdmf_text(collection("a", grid("0", "a") + grid("1", "a") + grid("2", "a")) +
                            collection("b", grid("1", "b") + grid("3", "b"))));
  EXPECT_THAT(time_steps_of(path), ElementsAre(0, 1, 2, 3));
  OpenOptions options;
  options.time_step = 0;
  EXPECT_EQ(open_mesh(path, options)->description().cell_data.find("b"), AttributeSet::npos);
  options.time_step = 2;
  const auto mesh = open_mesh(path, options);
  expect_two_tets(mesh.get());
  EXPECT_EQ(mesh->description().pieces, 1u);  // the mesh is the same
  EXPECT_THAT(rows_of_array<double>(mesh.get(), Association::kCell, "a"), ElementsAre(2, 2));
  EXPECT_THAT(rows_of_array<double>(mesh.get(), Association::kCell, "b"), ElementsAre(1, 1));
}

// The upper tetrahedron, with points of its own.
constexpr char kUpperTet[] = R"(
  <Topology TopologyType="Tetrahedron"><DataItem NumberType="Int">0 1 2 3</DataItem></Topology>
  <Geometry><DataItem>1 0 0  0 1 0  0 0 1  1 1 1</DataItem></Geometry>)";
constexpr char kLowerTet[] = R"(
  <Topology TopologyType="Tetrahedron"><DataItem NumberType="Int">0 1 2 3</DataItem></Topology>
  <Geometry><DataItem>0 0 0  1 0 0  0 1 0  0 0 1</DataItem></Geometry>)";

TEST_F(XdmfGrids, GridsBesideOneAnotherAreBlocks) {
  const std::string both = "<Grid Name=\"lower\">" + std::string(kLowerTet) +
                           grid_array("wet", "Cell", data_item("NumberType=\"Int\"", "7")) +
                           "</Grid><Grid Name=\"upper\">" + kUpperTet + "</Grid>";
  const std::string spatial = "<Grid GridType=\"Collection\" CollectionType=\"Spatial\">" + both +
                              grid_array("run", "Grid", data_item("NumberType=\"Int\"", "4")) +
                              "</Grid>";
  for (const std::string& domain :
       {spatial, "<Grid GridType=\"Tree\">" + spatial + "</Grid>",
        "<Grid GridType=\"Collection\" CollectionType=\"Temporal\">" + spatial + "</Grid>"}) {
    const auto mesh = mesh_of(xdmf_text(domain));
    const Geometry g = mesh->read_geometry();
    EXPECT_THAT(g.tets, ElementsAre(Tet{0, 1, 2, 3}, Tet{1, 2, 3, 4}));
    EXPECT_EQ(g.merged_points, 3u);
    EXPECT_THAT(rows_of_array<std::int32_t>(mesh.get(), Association::kCell, "block"),
                ElementsAre(0, 1));
    EXPECT_THAT(rows_of_array<std::int32_t>(mesh.get(), Association::kCell, "wet"),
                ElementsAre(7, 0));
    EXPECT_THAT(rows_of_array<std::int32_t>(mesh.get(), Association::kField, "run"),
                ElementsAre(4));
    const std::size_t names = mesh->description().field_data.find("block_names");
    ASSERT_NE(names, AttributeSet::npos);
    const auto bytes = mesh->read_array(Association::kField, names).bytes;
    EXPECT_EQ(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
              std::string("lower\0upper\0", 12));
  }
}

// As FEniCSx writes those of cells and faces: the cells are listed again, in another order.
// The first one brings the points; what is known at them stands in the second.
TEST_F(XdmfGrids, PointsOfSeveralGridsHaveTheArraysOfAll) {
  const std::string points = "<Geometry GeometryType=\"XYZ\">" +
                             data_item("Dimensions=\"5 3\"", "0 0 0 1 0 0 0 1 0 0 0 1 1 1 1") +
                             "</Geometry>";
  const auto cells = [](const char* type, const std::string& item) {
    return std::string("<Topology TopologyType=\"") + type + "\">" + item + "</Topology>";
  };
  const std::string path =
      write("run.xdmf",
            xdmf_text("<Grid Name=\"facets\">" +
                      cells("Triangle", data_item("Dimensions=\"1 3\"", "0 1 2")) + points +
                      "</Grid><Grid Name=\"volume\">" +
                      cells("Tetrahedron", data_item("Dimensions=\"2 4\"", "0 1 2 3 1 2 3 4")) +
                      points + "<Attribute Name=\"u\" Center=\"Node\">" +
                      data_item("Dimensions=\"5\"", "1 2 3 4 5") + "</Attribute></Grid>"));
  const auto mesh = open_mesh(path);
  EXPECT_THAT(rows_of_array<double>(mesh.get(), Association::kPoint, "u"),
              ElementsAre(1, 2, 3, 4, 5));
  EXPECT_THAT(mesh->description().left_out, IsEmpty());
}

TEST_F(XdmfGrids, TagsOfCellsAreArraysOfTheMesh) {
  const std::string points = "<xi:include xpointer=\"xpointer(/Xdmf/Domain/Grid[1]/Geometry)\"/>";
  const auto tags = [&](const std::string& kind, const std::string& ids,
                        const std::string& values) {
    return "<Grid Name=\"" + kind + "s\">" + points + "<Topology TopologyType=\"" + kind + "\">" +
           data_item("NumberType=\"Int\"", ids) + "</Topology>" +
           grid_array(kind, "Cell", data_item("NumberType=\"Int\"", values)) + "</Grid>";
  };
  const std::string grid = "<Grid Name=\"mesh\">" + std::string(kTwoTets) + "</Grid>";
  const std::string cells = tags("Tetrahedron", "4 1 2 3  3 2 1 0", "20 10");
  const std::string faces = tags("Triangle", "2 1 0", "5");
  const auto mesh = mesh_of(xdmf_text(grid + cells + faces));
  expect_two_tets(mesh.get());
  EXPECT_THAT(mesh->read_geometry().lower.connectivity, ElementsAre(2, 1, 0));
  EXPECT_EQ(mesh->description().pieces, 2u);
  EXPECT_THAT(rows_of_array<std::int32_t>(mesh.get(), Association::kCell, "Tetrahedron"),
              ElementsAre(10, 20, 0));
  EXPECT_THAT(rows_of_array<std::int32_t>(mesh.get(), Association::kCell, "Triangle"),
              ElementsAre(0, 0, 5));
  // Some cells alone.
  const auto some = mesh_of(xdmf_text(grid + tags("Tetrahedron", "4 1 2 3", "20")));
  EXPECT_EQ(some->description().pieces, 1u);
  EXPECT_THAT(rows_of_array<std::int32_t>(some.get(), Association::kCell, "Tetrahedron"),
              ElementsAre(0, 20));
  const auto before = mesh_of(xdmf_text(
      "<Grid>" + replaced(points, "[1]", "[2]") +
      "<Topology TopologyType=\"Tetrahedron\"><DataItem NumberType=\"Int\">4 1 2 3</DataItem>"
      "</Topology>" +
      grid_array("tag", "Cell", data_item("NumberType=\"Int\"", "20")) + "</Grid>" + grid));
  expect_two_tets(before.get());
  EXPECT_EQ(before->description().pieces, 1u);
  EXPECT_THAT(rows_of_array<std::int32_t>(before.get(), Association::kCell, "tag"),
              ElementsAre(0, 20));
  // One twice is no list of tags.
  const auto twice = mesh_of(xdmf_text(grid + tags("Tetrahedron", "4 1 2 3 1 2 3 4", "20 30")));
  EXPECT_EQ(twice->description().pieces, 2u);
}

TEST_F(XdmfGrids, ReferencesAndEntities) {
  write("cells.bin", raw_bytes<std::int32_t>({0, 1, 2, 3, 1, 2, 3, 4}));
  const auto mesh = mesh_of(xdmf_text(
      data_item("Name=\"cells\" Format=\"Binary\" NumberType=\"Int\" Dimensions=\"2 4\"",
                "&Folder;&Name;.bin") +
          "<Grid Name=\"first\"><Topology TopologyType=\"Tetrahedron\">" +
          data_item("Reference=\"XML\"", "\n /Xdmf/Domain/DataItem[@Name=\"cells\"] ") +
          "</Topology><Geometry>" +
          data_item("Dimensions=\"5 3\"", "0 0 0  1 0 0  0 1 0  0 0 1  1 1 1.1") +
          "</Geometry></Grid><Grid><Topology Reference=\"/Xdmf/Domain/Grid[1]/Topology\"/>" +
          "<xi:include xpointer=\"element(/1/1/2/2)\"/>" + heat_of("3") + "</Grid>",
      "<!DOCTYPE Xdmf SYSTEM \"Xdmf.dtd\" [ <!ENTITY Folder './'>\n<!ENTITY Name \"cells\"> "
      "<!ENTITY Other SYSTEM \"/etc/passwd\"> ]>\n"));
  expect_two_tets(mesh.get());
  EXPECT_EQ(mesh->description().pieces, 1u);
  EXPECT_THAT(rows_of_array<double>(mesh.get(), Association::kCell, "heat"), ElementsAre(3, 3));
}

TEST_F(XdmfGrids, OtherFilesAreIncluded) {
  const std::string one = xdmf_text(
      "<Grid><Time Value=\"0.5\"/>" + std::string(kTwoTets) +
          grid_array("heat", "Cell", data_item("Format=\"Binary\" Dimensions=\"2\"", "&Name;")) +
          "</Grid>",
      "<!DOCTYPE Xdmf [ <!ENTITY Name \"T.bin\"> ]>");
  for (const char* const step : {"1", "2"}) {
    const std::string folder = std::string("steps/") + step;
    write(folder + "/one.xmf", replaced(one, "0.5", step));
    write(folder + "/T.bin", raw_bytes<float>({std::stof(step), 7}));
  }
  const auto include = [](const std::string& step, const std::string& where) {
    return "<xi:include href=\"steps/" + step + "/one.xmf\" xpointer=\"" + where + "\"/>";
  };
  const std::string path =
      write("run.xdmf", xdmf_text("<Grid GridType=\"Collection\" CollectionType=\"Temporal\">" +
                                  include("1", "xpointer(//Xdmf/Domain/Grid)") +
                                  include("2", "element(/1/1/1)") + "</Grid>"));
  EXPECT_THAT(time_steps_of(path), ElementsAre(1, 2));
  OpenOptions options;
  options.time_step = 1;
  const auto mesh = open_mesh(path, options);
  expect_two_tets(mesh.get());
  EXPECT_THAT(rows_of_array<float>(mesh.get(), Association::kCell, "heat"), ElementsAre(2, 7));
  EXPECT_THAT(mesh->description().files,
              ElementsAre(dir_.file("steps/1/one.xmf"), dir_.file("steps/2/one.xmf"),
                          dir_.file("steps/2/T.bin")));
  write("steps/2/T.bin", "");
  EXPECT_THAT(error_of(path, options),
              HasSubstr("run.xdmf: in " + dir_.file("steps/2/one.xmf") + ": byte "));
  write("steps/1/one.xmf", "<Xdmf>");
  EXPECT_THAT(error_of(path, options),
              AllOf(HasSubstr("in " + dir_.file("steps/1/one.xmf")), HasSubstr("is damaged")));
  // One that includes itself.
  write("steps/1/one.xmf", xdmf_text("<Grid GridType=\"Tree\"><xi:include href=\"one.xmf\" "
                                     "xpointer=\"xpointer(//Grid)\"/></Grid>"));
  EXPECT_THAT(fault_of(xdmf_text(include("1", "xpointer(//Grid)"))),
              HasSubstr("grids in grids without end"));
}

}  // namespace
}  // namespace tetfusion
