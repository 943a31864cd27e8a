// XDMF files, as text and with binary files; with HDF5 files: cli/xdmf_test.py.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "support/format_files.h"
#include "support/vtk_file_test.h"

namespace tetfusion {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::replaced;
using testing::rows_of_array;
using testing::values_at_points;

constexpr char kTwoTets[] = R"(
  <Topology TopologyType="Tetrahedron" NumberOfElements="2">
    <DataItem Dimensions="2 4" NumberType="UInt" Format="XML">0 1 2 3  1 2 3 4</DataItem>
  </Topology>
  <Geometry GeometryType="XYZ">
    <DataItem Dimensions="5 3" Format="XML">0 0 0  1 0 0  0 1 0  0 0 1  1 1 1.1</DataItem>
  </Geometry>)";

std::string xdmf_text(const std::string& domain, const std::string& before = "") {
  return "<?xml version=\"1.0\"?>\n" + before +
         "<Xdmf Version=\"3.0\" xmlns:xi=\"http://www.w3.org/2001/XInclude\"><Domain>" + domain +
         "</Domain></Xdmf>\n";
}

std::string one_grid(const std::string& contents) {
  return xdmf_text("<Grid Name=\"mesh\" GridType=\"Uniform\">" + contents + "</Grid>");
}

std::string grid_array(const std::string& name, const std::string& center,
                       const std::string& item) {
  return "<Attribute Name=\"" + name + "\" AttributeType=\"Scalar\" Center=\"" + center + "\">" +
         item + "</Attribute>";
}

std::string data_item(const std::string& attributes, const std::string& text) {
  return "<DataItem " + attributes + ">" + text + "</DataItem>";
}

template <class T>
std::string raw_bytes(const std::vector<T>& values, bool is_big = false) {
  std::string bytes(values.size() * sizeof(T), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  for (std::size_t i = 0; is_big && i < bytes.size(); i += sizeof(T)) {
    std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(i),
                 bytes.begin() + static_cast<std::ptrdiff_t>(i + sizeof(T)));
  }
  return bytes;
}

class Xdmf : public testing::VtkFileTest {
 protected:
  std::unique_ptr<MeshSource> mesh_of(const std::string& text, const OpenOptions& options = {}) {
    return open_mesh(write("run.xdmf", text), options);
  }

  std::string fault_of(const std::string& text, const OpenOptions& options = {}) {
    return error_of(write("run.xdmf", text), options);
  }

  void expect_two_tets(MeshSource* mesh) {
    const Geometry g = mesh->read_geometry();
    EXPECT_THAT(g.tets, ElementsAre(Tet{0, 1, 2, 3}, Tet{1, 2, 3, 4}));
    EXPECT_EQ(point_count(g.points), 5u);
    std::visit([](const auto& points) { EXPECT_NEAR(double(points[4].z), 1.1, 1e-6); }, g.points);
  }

  // The cells of one topology over nine points on a curve, none of them flat.
  std::string fault_of_cells(const std::string& topology, const OpenOptions& options = {}) {
    return fault_of(one_grid(topology + kNinePoints), options);
  }

  Geometry cells_of(const std::string& topology, const OpenOptions& options = {}) {
    return mesh_of(one_grid(topology + kNinePoints), options)->read_geometry();
  }

  static constexpr char kNinePoints[] = R"(<Geometry Type="XYZ">
    <DataItem Dimensions="9 3">0 0 0  1 0 0  1 1 0  0 1 0  0 0 1  1 0 1  1 1 1  0 1 1  0.5 0.5 2
    </DataItem></Geometry>)";
};

TEST_F(Xdmf, ReadsTextWithItsArrays) {
  const auto mesh = mesh_of(one_grid(
      std::string(kTwoTets) +
      grid_array("T", "Node", data_item("Dimensions=\"5 1\" Format=\"XML\"", "1 2 3\n4 -1e-400")) +
      grid_array("id", "Cell",
                 data_item("Dimensions=\"2\" NumberType=\"Int\" Precision=\"8\"",
                           "9007199254740993 -9223372036854775808")) +
      grid_array("small", "Cell", data_item("Dimensions=\"2\" DataType=\"UChar\"", "0 +255")) +
      grid_array("seven", "Grid", data_item("Dimensions=\"1\" NumberType=\"Int\"", "7")) +
      "<Attribute Name=\"v\" Type=\"Vector\" Center=\"Cell\">" +
      data_item("Dimensions=\"2 3\" Precision=\"4\"", "1 2 3 <!-- so far --> 4 5 nan") +
      "</Attribute>"));
  const MeshDescription& d = mesh->description();
  EXPECT_EQ(d.format, "XDMF file, read with VTK");
  EXPECT_EQ(d.point_type, ValueType::kFloat64);  // what is written loses nothing
  EXPECT_THAT(d.left_out, IsEmpty());
  EXPECT_THAT(d.files, IsEmpty());
  EXPECT_THAT(d.time_steps, IsEmpty());
  expect_two_tets(mesh.get());
  EXPECT_THAT(rows_of_array<double>(mesh.get(), Association::kPoint, "T"),
              ElementsAre(1, 2, 3, 4, 0));
  EXPECT_THAT(rows_of_array<std::int64_t>(mesh.get(), Association::kCell, "id"),
              ElementsAre(9007199254740993, INT64_MIN));
  EXPECT_THAT(rows_of_array<std::uint8_t>(mesh.get(), Association::kCell, "small"),
              ElementsAre(0, 255));
  EXPECT_THAT(rows_of_array<std::int32_t>(mesh.get(), Association::kField, "seven"),
              ElementsAre(7));
  const DataArray v = mesh->read_array(Association::kCell, d.cell_data.find("v"));
  EXPECT_EQ(v.info.components, 3u);
  EXPECT_EQ(v.info.type, ValueType::kFloat32);
  EXPECT_EQ(v.as<float>()[4], 5);
}

TEST_F(Xdmf, ReadsBinaryFilesOfBothByteOrders) {
  for (const bool is_big : {false, true}) {
    write("data/points.bin",
          "head" + raw_bytes<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1.1f}, is_big));
    write("data/cells.bin", raw_bytes<std::int64_t>({0, 1, 2, 3, 1, 2, 3, 4}, is_big));
    write("T.bin", raw_bytes<std::int16_t>({-5, 300}, is_big));
    const std::string endian = is_big ? " Endian=\"Big\"" : " Endian=\"Little\"";
    const auto mesh = mesh_of(one_grid(
        "<Topology TopologyType=\"TETRAHEDRON\" NumberOfElements=\"2\">" +
        data_item(
            "Format=\"Binary\" NumberType=\"Int\" Precision=\"8\" Dimensions=\"2 4\"" + endian,
            "data/cells.bin") +
        "</Topology><Geometry>" +
        data_item("Format=\"Binary\" Seek=\"4\" Dimensions=\"5 3\"" + endian,
                  " data/points.bin\n") +
        "</Geometry>" +
        grid_array(
            "T", "cell",
            data_item("Format=\"binary\" DataType=\"Short\" Dimensions=\"2\"" + endian, "T.bin"))));
    EXPECT_EQ(mesh->description().point_type, ValueType::kFloat32);
    expect_two_tets(mesh.get());
    EXPECT_THAT(rows_of_array<std::int16_t>(mesh.get(), Association::kCell, "T"),
                ElementsAre(-5, 300));
    EXPECT_THAT(
        mesh->description().files,
        ElementsAre(dir_.file("data/points.bin"), dir_.file("data/cells.bin"), dir_.file("T.bin")));
  }
}

TEST_F(Xdmf, PartsAreTakenFromTextAndBinaryFiles) {
  const std::string list =
      data_item("Dimensions=\"3 2\" NumberType=\"UInt\" Precision=\"4\"", "1 0 1 2 1 2");
  const auto part = [&](const std::string& source) {
    return data_item("ItemType=\"HyperSlab\" Dimensions=\"2\"", list + source);
  };
  write("two.bin", raw_bytes<float>({0, 1, 2, 3, 4, 5, 6, 7}));
  // The second row of a file of which the XML, written with the first step, says only one.
  const auto mesh = mesh_of(one_grid(
      std::string(kTwoTets) +
      grid_array("text", "Cell", part(data_item("Dimensions=\"2 4\"", "0 1 2 3 4 5 6 7"))) +
      grid_array("file", "Cell",
                 part(data_item("Dimensions=\"1 4\" Format=\"Binary\"", "two.bin"))) +
      grid_array(
          "joined", "Cell",
          data_item("ItemType=\"Function\" Function=\"JOIN($0 , $1,$0)\" Dimensions=\"2 3\"",
                    data_item("Dimensions=\"2\"", "1 2") + data_item("Dimensions=\"2\"", "3 4")))));
  EXPECT_THAT(rows_of_array<double>(mesh.get(), Association::kCell, "text"), ElementsAre(4, 6));
  EXPECT_THAT(rows_of_array<float>(mesh.get(), Association::kCell, "file"), ElementsAre(4, 6));
  EXPECT_THAT(rows_of_array<double>(mesh.get(), Association::kCell, "joined"),
              ElementsAre(1, 3, 1, 2, 4, 2));
}

TEST_F(Xdmf, CellsOfAllKinds) {
  const OpenOptions all = {.tetrahedralize = true, .linearize = true};
  const auto topology = [](const std::string& attributes, const std::string& ids) {
    return "<Topology " + attributes + "><DataItem NumberType=\"Int\">" + ids +
           "</DataItem></Topology>";
  };
  EXPECT_EQ(cells_of(topology("Type=\"Hexahedron\" Dimensions=\"1\"", "0 1 2 3 4 5 6 7"), all)
                .tets.size(),
            6u);
  EXPECT_EQ(cells_of(topology("TopologyType=\"Wedge\"", "0 1 2 4 5 6"), all).tets.size(), 3u);
  EXPECT_EQ(cells_of(topology("TopologyType=\"pyramid\"", "0 1 2 3 8"), all).tets.size(), 2u);
  EXPECT_THAT(fault_of_cells(topology("TopologyType=\"Hexahedron\"", "0 1 2 3 4 5 6 7")),
              HasSubstr("--tetrahedralize"));
  for (const char* const name : {"Tetrahedron_10", "Tet_10"}) {
    const std::string ten =
        topology("TopologyType=\"" + std::string(name) + "\"", "0 1 3 4 8 8 8 8 8 8");
    EXPECT_THAT(cells_of(ten, all).tets, ElementsAre(Tet{0, 1, 2, 3}));
    EXPECT_THAT(fault_of_cells(ten), HasSubstr("--linearize"));
  }
  // As files of Fortran programs count.
  EXPECT_THAT(cells_of(topology("TopologyType=\"Tetrahedron\" BaseOffset=\"1\"", "1 2 4 5")).tets,
              ElementsAre(Tet{0, 1, 2, 3}));
  const Geometry mixed =
      cells_of(topology("TopologyType=\"Mixed\" NumberOfElements=\"6\"",
                        "6 0 1 3 4  4 0 1 3  2 2 0 1  1 1 4  3 3 0 1 4  38 0 1 3 4 8 8 8 8 8 8"),
               all);
  EXPECT_THAT(mixed.tets, ElementsAre(Tet{0, 1, 2, 3}, Tet{0, 1, 2, 3}));
  EXPECT_THAT(mixed.lower.types, ElementsAre(5, 3, 1, 5));
  EXPECT_THAT(mixed.lower.connectivity, ElementsAre(0, 1, 2, 0, 1, 3, 0, 1, 3));
  EXPECT_THAT(mixed.tet_source, ElementsAre(0, 5));
}

TEST_F(Xdmf, CoordinatesInOtherForms) {
  const auto with = [](const std::string& geometry) {
    return one_grid(
        "<Topology TopologyType=\"Tetrahedron\"><DataItem NumberType=\"Int\">0 1 2 3 "
        "</DataItem></Topology>" +
        geometry);
  };
  const std::string x = data_item("Precision=\"4\"", "0 1 0 0"),
                    y = data_item("Precision=\"4\"", "0 0 1 0"),
                    z = data_item("Precision=\"4\"", "0 0 0 2");
  const auto mesh = mesh_of(with("<Geometry GeometryType=\"X_Y_Z\">" + x + y + z + "</Geometry>"));
  const Geometry g = mesh->read_geometry();
  EXPECT_EQ(std::get<Vector<Vec3<float>>>(g.points)[3].z, 2);
  EXPECT_EQ(std::get<Vector<Vec3<float>>>(g.points)[1].x, 1);
  // All in a plane: they are read, and the cell is flat.
  for (const std::string& flat :
       {"<Geometry GeometryType=\"XY\">" + data_item("Dimensions=\"4 2\"", "0 0 1 0 0 1 3 4"),
        "<Geometry GeometryType=\"X_Y\">" + data_item("", "0 1 0 3") + data_item("", "0 0 1 4")}) {
    const Geometry read = mesh_of(with(flat + "</Geometry>"))->read_geometry();
    EXPECT_EQ(std::get<Vector<Vec3<double>>>(read.points)[3].x, 3);
    EXPECT_EQ(std::get<Vector<Vec3<double>>>(read.points)[3].y, 4);
    EXPECT_EQ(std::get<Vector<Vec3<double>>>(read.points)[3].z, 0);
  }
  EXPECT_THAT(fault_of(with("<Geometry GeometryType=\"X_Y_Z\">" + x + y + "</Geometry>")),
              HasSubstr("has 2 DataItems, expected 3"));
  EXPECT_THAT(
      fault_of(with("<Geometry GeometryType=\"X_Y\">" + x + data_item("", "1 2") + "</Geometry>")),
      HasSubstr("different types or numbers"));
  EXPECT_THAT(fault_of(with("<Geometry GeometryType=\"ORIGIN_DXDYDZ\">" + x + y + "</Geometry>")),
              AllOf(HasSubstr("ORIGIN_DXDYDZ"), HasSubstr(".vts or .vti")));
}

// Two steps of a temporal collection, each with what is given.
std::string at_times(const std::string& name, const std::string& first, const std::string& second) {
  return "<Grid Name=\"" + name + "\" GridType=\"Collection\" CollectionType=\"Temporal\">" +
         "<Grid><Time Value=\"0.5\"/>" + first + "</Grid><Grid><Time Value=\" 1.5 \"/>" + second +
         "</Grid></Grid>";
}

std::string heat_of(const std::string& number) {
  return grid_array("heat", "Cell", data_item("Dimensions=\"2\"", number + " " + number));
}

TEST_F(Xdmf, StepsAreThoseOfATemporalCollection) {
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

TEST_F(Xdmf, TimesAreSaidInSeveralWays) {
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
  EXPECT_THAT(fault_of(xdmf_text(collection(
                  "<Time Type=\"List\">" + data_item("Dimensions=\"3\"", "1 2 4") + "</Time>", 2))),
              HasSubstr("has 3 times for 2 grids"));
  EXPECT_THAT(fault_of(xdmf_text(timed("soon"))), HasSubstr("Value 'soon', which is no number"));
}

// Several functions of one mesh, each with steps of its own.
TEST_F(Xdmf, CollectionsWithOtherTimesAreReadByTime) {
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

TEST_F(Xdmf, GridsBesideOneAnotherAreBlocks) {
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
TEST_F(Xdmf, TagsOfCellsAreArraysOfTheMesh) {
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

TEST_F(Xdmf, ReferencesAndEntities) {
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

TEST_F(Xdmf, OtherFilesAreIncluded) {
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

TEST_F(Xdmf, FunctionsOfFiniteElements) {
  const auto function = [](const std::string& family, const std::string& numbers) {
    return "<Attribute ItemType=\"FiniteElementFunction\" ElementCell=\"tetrahedron\" " + family +
           " Center=\"Other\">" + data_item("NumberType=\"UInt\"", numbers) +
           data_item("", "0 10 20 30 40 50 60 70 80 90") + "</Attribute>";
  };
  const std::string linear = "ElementFamily=\"CG\" ElementDegree=\"1\" Name=\"f\"";
  const auto mesh =
      mesh_of(one_grid(kTwoTets + function(linear, "9 8 7 6  8 7 6 5") +
                       function("ElementFamily=\"CG\" ElementDegree=\"1\" Name=\"v\"",
                                "0 1 2 3  5 6 7 8  1 2 3 4  6 7 8 9") +
                       function("ElementFamily=\"DG\" ElementDegree=\"0\" Name=\"c\"", "4 2") +
                       function("ElementFamily=\"CG\" ElementDegree=\"2\" Name=\"q\"", "1")));
  EXPECT_THAT(rows_of_array<double>(mesh.get(), Association::kPoint, "f"),
              ElementsAre(90, 80, 70, 60, 50));
  EXPECT_THAT(rows_of_array<double>(mesh.get(), Association::kPoint, "v"),
              ElementsAre(0, 50, 10, 60, 20, 70, 30, 80, 40, 90));
  EXPECT_THAT(rows_of_array<double>(mesh.get(), Association::kCell, "c"), ElementsAre(40, 20));
  EXPECT_THAT(mesh->description().left_out, ElementsAre("function 'q' (CG 2)"));
  EXPECT_THAT(fault_of(one_grid(kTwoTets + function(linear, "9 8 7 6  8 7 6 10"))),
              HasSubstr("'f' wants value 10 of 10"));
  EXPECT_THAT(fault_of(one_grid(kTwoTets + function(linear, "9 8 7 6  8 7 6"))),
              HasSubstr("7 numbers of values for 2 cells"));
}

TEST_F(Xdmf, WhatIsNotReadIsSaid) {
  const auto mesh =
      mesh_of(one_grid(kTwoTets + grid_array("f", "Face", data_item("", "1")) + heat_of("1") +
                       heat_of("2") + "<Set Name=\"wall\" SetType=\"Node\"/>"));
  EXPECT_THAT(
      mesh->description().left_out,
      ElementsAre("array 'f' (Face)", "another cell array 'heat' of the same grid", "set 'wall'"));
  const auto first = mesh_of("<Xdmf><Domain><Grid>" + std::string(kTwoTets) +
                             "</Grid></Domain><Domain Name=\"other\"/></Xdmf>");
  EXPECT_THAT(first->description().left_out, ElementsAre("domain 'other'"));
  EXPECT_THAT(fault_of(one_grid("<Topology TopologyType=\"3DCoRectMesh\" Dimensions=\"2 2 2\"/>" +
                                std::string("<Geometry><DataItem>0 0 0</DataItem></Geometry>"))),
              AllOf(HasSubstr("structured grid (3DCoRectMesh)"), HasSubstr(".vts or .vti")));
}

TEST_F(Xdmf, ArraysInAFormThatIsNotReadAreLeftOut) {
  struct Case {
    const char *attributes, *words;
  };
  for (const Case& c :
       {Case{"Format=\"TIFF\"", "is of Format TIFF, which is not read: XML, HDF and Binary are"},
        Case{"Precision=\"3\"", "holds numbers of type Float, Precision 3, which are not read"},
        Case{"NumberType=\"String\"", "holds numbers of type String"},
        Case{"ItemType=\"Coordinates\"", "is of ItemType Coordinates"},
        Case{"ItemType=\"Function\" Function=\"SQRT($0)\"", "is a Function, SQRT($0), which"},
        Case{"ItemType=\"Function\" Function=\"JOIN($0, 0*$0)\"", "only JOIN of its items is"},
        Case{"Format=\"Binary\" Compression=\"Zlib\"", "is packed (Zlib)"}}) {
    const std::string form = data_item(std::string("Dimensions=\"2\" ") + c.attributes, "1 2");
    const auto mesh = mesh_of(one_grid(kTwoTets + grid_array("T", "Cell", form)));
    expect_two_tets(mesh.get());
    EXPECT_THAT(mesh->description().left_out,
                ElementsAre(AllOf(HasSubstr("array 'T', whose DataItem"), HasSubstr(c.words))));
    EXPECT_THAT(fault_of(one_grid("<Topology TopologyType=\"Tetrahedron\">" + form +
                                  "</Topology><Geometry>" + form + "</Geometry>")),
                HasSubstr("DataItem"));
  }
}

TEST_F(Xdmf, DamagedTextIsAnError) {
  const std::string good =
      one_grid(kTwoTets + grid_array("T", "Node", data_item("Dimensions=\"5\"", "1 2 3 4 5")));
  EXPECT_EQ(fault_of(good), "no error");
  struct Case {
    const char *from, *to, *words;
  };
  for (const Case& c : {
           Case{"1 2 3 4 5", "1 2 3 4", "says 5 values, and there are 4"},
           Case{"Dimensions=\"5\">1 2 3 4 5", ">1 2 3 4", "'T' has 4 values for 5 points"},
           Case{"1 2 3 4 5", "1 2 3 4 five", "has 'five' among its numbers"},
           Case{"\"5\"", "\"4294967296 4294967296 4294967296\"", "says 4294967296 x"},
           Case{"\"5\"", "\"-5\"", "has '-5' where a count is expected"},
           Case{"\"5\"", "\"5\" Reference=\"/Xdmf/Nowhere\"", "refers to '/Xdmf/Nowhere', where"},
           Case{"\"5\"", "\"5\" Reference=\"][\"", "which is no XPath"},
           Case{"\"5\"", "\"5\" Reference=\"//Attribute/DataItem\"", "stands for itself"},
           Case{"1 2 3  1 2 3 4", "1 2 3  1 2 3 7", "cell 1 uses point 7, but there are 5 points"},
           Case{"1 2 3  1 2 3 4", "1 2 3  1 2 3", "says 2 x 4 values, and there are 7"},
           Case{"1 2 3  1 2 3 4", "1 2 3  1 2 3 -1", "has '-1' among its numbers"},
           Case{"NumberOfElements=\"2\"", "NumberOfElements=\"3\"", "and 3 cells of 4"},
           Case{"NumberOfElements=\"2\"", "NodesPerElement=\"5\"", "a Tetrahedron has 4"},
           Case{"NumberOfElements=\"2\"", "Order=\"1 0 2 3\"", "an order of its own (1 0 2 3)"},
           Case{"\"Tetrahedron\"", "\"Dodecahedron\"", "is of type Dodecahedron"},
           Case{"\"Tetrahedron\"", "\"\"", "says no TopologyType"},
           Case{"\"Tetrahedron\"", "\"Mixed\"", "has cell 0 of type 0, which XDMF does not know"},
           Case{"1 1 1.1", "1 1", "says 5 x 3 values, and there are 14"},
           Case{"Dimensions=\"5 3\" Format=\"XML\">0 0 0", ">0 0",
                "14 coordinates, which are no rows of 3"},
           Case{"\"Uniform\"", "\"SubSet\"", "is of GridType SubSet"},
           Case{"<Domain>", "<Domain><xi:include href=\"a.xmf\"/>", "a.xmf, which is not there"},
           Case{"<Domain>", "<Domain><xi:include href=\"../a.xmf\"/>", "not below the folder"},
           Case{"<Domain>", "<Domain><xi:include xpointer=\"element(/1/7)\"/>",
                "includes 'element(/1/7)', where there is nothing"},
           Case{"<Domain>", "<Domain><xi:include xpointer=\"xpointer(//Grid[)\"/>",
                "which is no XPath"},
           Case{"Geometry ", "Geometrie ", "is damaged or cut off"},
           Case{"</Domain>", "", "is damaged or cut off"},
       }) {
    EXPECT_THAT(fault_of(replaced(good, c.from, c.to)),
                AllOf(HasSubstr(c.words), HasSubstr(dir_.file("run.xdmf") + ": ")))
        << c.to;
  }
  EXPECT_THAT(fault_of("<Xdmf><Domain/></Xdmf>"), HasSubstr("has no grids"));
  EXPECT_THAT(fault_of("<Xdmf/>"), HasSubstr("has no Domain"));
  EXPECT_THAT(fault_of("<nothing/>"), HasSubstr("has no element <Xdmf>"));
  EXPECT_THAT(fault_of(one_grid("")), HasSubstr("has no Geometry"));
  std::string deep;
  for (int i = 0; i < 100; ++i) deep.insert(0, "<Grid GridType=\"Tree\">").append("</Grid>");
  EXPECT_THAT(fault_of(xdmf_text(deep)), HasSubstr("grids in grids without end"));
  EXPECT_THAT(fault_of(xdmf_text(
                  "<Grid GridType=\"Tree\"><xi:include xpointer=\"xpointer(//Grid)\"/></Grid>")),
              HasSubstr("grids in grids without end"));
  EXPECT_THAT(fault_of(xdmf_text("<Grid GridType=\"Tree\"><xi:include "
                                 "xpointer=\"xpointer(//Grid)\"/><xi:include "
                                 "xpointer=\"xpointer(//Grid)\"/></Grid>")),
              HasSubstr("without end"));
}

TEST_F(Xdmf, DamagedBinaryFilesAreErrors) {
  const auto with = [&](const std::string& attributes, const std::string& name) {
    return fault_of(
        one_grid(kTwoTets +
                 grid_array("T", "Cell",
                            data_item("Format=\"Binary\" Dimensions=\"2\" " + attributes, name))));
  };
  write("T.bin", raw_bytes<float>({1, 2}));
  write("empty.bin", "");
  EXPECT_EQ(with("", "T.bin"), "no error");
  EXPECT_THAT(with("Precision=\"8\"", "T.bin"),
              AllOf(HasSubstr("says 2 values of 8 bytes from byte 0 of"), HasSubstr("at byte 8")));
  EXPECT_THAT(with("Seek=\"1\"", "T.bin"), HasSubstr("which ends at byte 8"));
  EXPECT_THAT(with("Seek=\"18446744073709551615\"", "T.bin"), HasSubstr("which ends at byte 8"));
  EXPECT_THAT(with("", "missing.bin"),
              AllOf(HasSubstr(dir_.file("missing.bin")), HasSubstr("is not there")));
  EXPECT_THAT(with("", "empty.bin"), HasSubstr("is empty, or no file"));
  EXPECT_THAT(with("", "."), HasSubstr("is empty, or no file"));
  EXPECT_THAT(with("", "../T.bin"), HasSubstr("not below the folder of this file"));
  EXPECT_THAT(with("", "/etc/passwd"), HasSubstr("an absolute path"));
  EXPECT_THAT(with("", " "), HasSubstr("names no file"));
}

TEST_F(Xdmf, PartsOutsideAreErrors) {
  write("T.bin", raw_bytes<float>({1, 2, 3, 4, 5, 6}));
  const auto with = [&](const std::string& list, const std::string& source) {
    return fault_of(one_grid(
        kTwoTets +
        grid_array("T", "Cell",
                   data_item("ItemType=\"HyperSlab\" Dimensions=\"2\"",
                             data_item("NumberType=\"Int\" Precision=\"8\"", list) + source))));
  };
  const std::string text = data_item("Dimensions=\"3 2\"", "1 2 3 4 5 6");
  for (const std::string& source :
       {text, data_item("Dimensions=\"3 2\" Format=\"Binary\"", "T.bin")}) {
    EXPECT_EQ(with("2 0 1 1 1 2", source), "no error");
    EXPECT_THAT(with("3 0 1 1 1 2", source), HasSubstr("is not inside of 3 x 2"));
    EXPECT_THAT(with("0 1 1 1 1 2", source), HasSubstr("is not inside of 3 x 2"));
    EXPECT_THAT(with("0 0 1 0 1 2", source), HasSubstr("is not inside of 3 x 2"));
    EXPECT_THAT(with("1 0 4000000000000000 1 2 1", source), HasSubstr("is not inside of 3 x 2"));
    EXPECT_THAT(with("2 0 1 1 1 1", source), HasSubstr("says 2 values, and there are 1"));
    EXPECT_THAT(with("0 1 2", source), HasSubstr("along 1 dimensions of 3 x 2"));
    EXPECT_THAT(with("2 0 1 1 1", source), HasSubstr("not a start, a step and a count"));
    EXPECT_THAT(with("0 0 1 1 -1 2", source), HasSubstr("not a start, a step and a count"));
  }
  EXPECT_THAT(with("0 0 1 1 1 2", ""), HasSubstr("a HyperSlab of 1 DataItems"));
  // Cut off: what the XML says of it is not believed.
  const std::string cut = data_item("Dimensions=\"5000 2\" Format=\"Binary\"", "T.bin");
  EXPECT_EQ(with("2 0 1 1 1 2", cut), "no error");
  EXPECT_THAT(with("3 0 1 1 1 2", cut), HasSubstr("is not inside of 3 x 2"));
  EXPECT_THAT(with("4000 0 1 1 1 2", cut), HasSubstr("is not inside of 3 x 2"));
}

}  // namespace
}  // namespace tetfusion
