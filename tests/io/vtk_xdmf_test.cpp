// XDMF files, as text and with binary files; with HDF5 files: cli/xdmf_test.py.
#include <cstdint>
#include <string>
#include <variant>

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
using testing::one_grid;
using testing::raw_bytes;
using testing::replaced;
using testing::rows_of_array;
using testing::xdmf_text;

using Xdmf = testing::XdmfTest;

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
