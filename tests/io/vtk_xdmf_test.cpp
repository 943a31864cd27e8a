// XDMF files, as text and with binary files; with HDF5 files: cli/xdmf_test.py.
#include <cstring>
#include <filesystem>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "support/vtk_file_test.h"

namespace tetfusion {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::kSplit;
using testing::rows_of_array;

constexpr char kTwoTets[] = R"(
  <Topology TopologyType="Tetrahedron" NumberOfElements="2">
    <DataItem Dimensions="2 4" NumberType="UInt" Format="XML">0 1 2 3  1 2 3 4</DataItem>
  </Topology>
  <Geometry GeometryType="XYZ">
    <DataItem Dimensions="5 3" Format="XML">0 0 0  1 0 0  0 1 0  0 0 1  1 1 1.1</DataItem>
  </Geometry>)";

std::string document(const std::string& domain, const std::string& before = "") {
  return "<?xml version=\"1.0\"?>\n" + before +
         "<Xdmf Version=\"3.0\" xmlns:xi=\"http://www.w3.org/2001/XInclude\"><Domain>" + domain +
         "</Domain></Xdmf>\n";
}

std::string uniform(const std::string& contents) {
  return document("<Grid Name=\"mesh\" GridType=\"Uniform\">" + contents + "</Grid>");
}

std::string attribute(const std::string& name, const std::string& center, const std::string& item) {
  return "<Attribute Name=\"" + name + "\" AttributeType=\"Scalar\" Center=\"" + center + "\">" +
         item + "</Attribute>";
}

std::string item(const std::string& attributes, const std::string& text) {
  return "<DataItem " + attributes + ">" + text + "</DataItem>";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

template <class T>
std::string bytes_of(const std::vector<T>& values, bool is_big = false) {
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
    return fault_of(uniform(topology + kNinePoints), options);
  }

  Geometry cells_of(const std::string& topology, const OpenOptions& options = {}) {
    return mesh_of(uniform(topology + kNinePoints), options)->read_geometry();
  }

  static constexpr char kNinePoints[] = R"(<Geometry Type="XYZ">
    <DataItem Dimensions="9 3">0 0 0  1 0 0  1 1 0  0 1 0  0 0 1  1 0 1  1 1 1  0 1 1  0.5 0.5 2
    </DataItem></Geometry>)";
};

TEST_F(Xdmf, ReadsTextWithItsArrays) {
  const auto mesh = mesh_of(uniform(
      std::string(kTwoTets) +
      attribute("T", "Node", item("Dimensions=\"5 1\" Format=\"XML\"", "1 2 3\n4 -1e-400")) +
      attribute("id", "Cell",
                item("Dimensions=\"2\" NumberType=\"Int\" Precision=\"8\"",
                     "9007199254740993 -9223372036854775808")) +
      attribute("small", "Cell", item("Dimensions=\"2\" DataType=\"UChar\"", "0 +255")) +
      attribute("seven", "Grid", item("Dimensions=\"1\" NumberType=\"Int\"", "7")) +
      "<Attribute Name=\"v\" Type=\"Vector\" Center=\"Cell\">" +
      item("Dimensions=\"2 3\" Precision=\"4\"", "1 2 3 <!-- so far --> 4 5 nan") +
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
          "head" + bytes_of<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1.1f}, is_big));
    write("data/cells.bin", bytes_of<std::int64_t>({0, 1, 2, 3, 1, 2, 3, 4}, is_big));
    write("T.bin", bytes_of<std::int16_t>({-5, 300}, is_big));
    const std::string endian = is_big ? " Endian=\"Big\"" : " Endian=\"Little\"";
    const auto mesh = mesh_of(uniform(
        "<Topology TopologyType=\"TETRAHEDRON\" NumberOfElements=\"2\">" +
        item("Format=\"Binary\" NumberType=\"Int\" Precision=\"8\" Dimensions=\"2 4\"" + endian,
             "data/cells.bin") +
        "</Topology><Geometry>" +
        item("Format=\"Binary\" Seek=\"4\" Dimensions=\"5 3\"" + endian, " data/points.bin\n") +
        "</Geometry>" +
        attribute(
            "T", "cell",
            item("Format=\"binary\" DataType=\"Short\" Dimensions=\"2\"" + endian, "T.bin"))));
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
      item("Dimensions=\"3 2\" NumberType=\"UInt\" Precision=\"4\"", "1 0 1 2 1 2");
  const auto part = [&](const std::string& source) {
    return item("ItemType=\"HyperSlab\" Dimensions=\"2\"", list + source);
  };
  write("two.bin", bytes_of<float>({0, 1, 2, 3, 4, 5, 6, 7}));
  // The second row of a file of which the XML, written with the first step, says only one.
  const auto mesh = mesh_of(uniform(
      std::string(kTwoTets) +
      attribute("text", "Cell", part(item("Dimensions=\"2 4\"", "0 1 2 3 4 5 6 7"))) +
      attribute("file", "Cell", part(item("Dimensions=\"1 4\" Format=\"Binary\"", "two.bin"))) +
      attribute("joined", "Cell",
                item("ItemType=\"Function\" Function=\"JOIN($0 , $1,$0)\" Dimensions=\"2 3\"",
                     item("Dimensions=\"2\"", "1 2") + item("Dimensions=\"2\"", "3 4")))));
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
            5u);
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
    return uniform(
        "<Topology TopologyType=\"Tetrahedron\"><DataItem NumberType=\"Int\">0 1 2 3 "
        "</DataItem></Topology>" +
        geometry);
  };
  const std::string x = item("Precision=\"4\"", "0 1 0 0"), y = item("Precision=\"4\"", "0 0 1 0"),
                    z = item("Precision=\"4\"", "0 0 0 2");
  const auto mesh = mesh_of(with("<Geometry GeometryType=\"X_Y_Z\">" + x + y + z + "</Geometry>"));
  const Geometry g = mesh->read_geometry();
  EXPECT_EQ(std::get<Vector<Vec3<float>>>(g.points)[3].z, 2);
  EXPECT_EQ(std::get<Vector<Vec3<float>>>(g.points)[1].x, 1);
  // All in a plane: they are read, and the cell is flat.
  for (const std::string& flat :
       {"<Geometry GeometryType=\"XY\">" + item("Dimensions=\"4 2\"", "0 0 1 0 0 1 3 4"),
        "<Geometry GeometryType=\"X_Y\">" + item("", "0 1 0 3") + item("", "0 0 1 4")}) {
    const Geometry read = mesh_of(with(flat + "</Geometry>"))->read_geometry();
    EXPECT_EQ(std::get<Vector<Vec3<double>>>(read.points)[3].x, 3);
    EXPECT_EQ(std::get<Vector<Vec3<double>>>(read.points)[3].y, 4);
    EXPECT_EQ(std::get<Vector<Vec3<double>>>(read.points)[3].z, 0);
  }
  EXPECT_THAT(fault_of(with("<Geometry GeometryType=\"X_Y_Z\">" + x + y + "</Geometry>")),
              HasSubstr("has 2 DataItems, expected 3"));
  EXPECT_THAT(
      fault_of(with("<Geometry GeometryType=\"X_Y\">" + x + item("", "1 2") + "</Geometry>")),
      HasSubstr("different types or numbers"));
  EXPECT_THAT(fault_of(with("<Geometry GeometryType=\"ORIGIN_DXDYDZ\">" + x + y + "</Geometry>")),
              AllOf(HasSubstr("ORIGIN_DXDYDZ"), HasSubstr(".vts or .vti")));
}

}  // namespace
}  // namespace tetfusion
