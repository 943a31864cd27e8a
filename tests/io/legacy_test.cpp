// Legacy .vtk files of unstructured grids: text and binary, with cells as counted lists (before
// version 5) and as offsets and connectivity, read and written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "io/left_out.h"
#include "io/mesh_format.h"
#include "io/open_mesh.h"
#include "io/write_mesh.h"
#include "support/format_files.h"
#include "support/mesh_file.h"
#include "support/meshes.h"
#include "support/stream_check.h"
#include "support/vtu_file_test.h"

namespace tetfusion {
namespace {

using testing::Bytes;
using testing::bytes_of;
using testing::cell_values;
using testing::dump;
using ::testing::ElementsAre;
using testing::point_values;
using testing::read_cell_array;
using testing::read_point_array;
using testing::replaced;
using testing::values;

class Legacy : public testing::FormatTest {
 protected:
  // Opens a file, which is the same mesh in windows.
  std::unique_ptr<MeshSource> open_both_ways(const std::string& bytes,
                                             const OpenOptions& options = {}) {
    auto source = open("a.vtk", bytes, options);
    testing::expect_windows_like_whole(dir_.file("a.vtk"), options);
    return source;
  }
  std::string dump_of(const std::string& bytes) { return dump(open_both_ways(bytes).get()); }
  std::string text_of(MeshSource* source, Encoding encoding) {
    write_mesh(source, dir_.file("out.vtk"), {encoding, {}});
    return bytes_of(dir_.file("out.vtk"));
  }
};

// Two tetrahedra, a triangle before the second one, a point; a point that nobody uses.
const std::string kPointSection = R"(POINTS 6 double
0 0 0  1 0 0.1  0 1 0
0 0 1  1 1 -1
9 9 9
)";
const std::string kCounted = R"(CELLS 4 16
4 0 1 2 3
3 1 2 3
4 4 1 3 2
1 2
CELL_TYPES 4
10
5 10
1
)";
const std::string kLists = R"(CELLS 5 12
OFFSETS vtktypeint64
0 4 7 11 12
CONNECTIVITY vtktypeint64
0 1 2 3 1 2 3 4 1 3 2 2
CELL_TYPES 4
10
5 10
1
)";
const std::string kDataSection = R"(CELL_DATA 4
SCALARS region int 1
LOOKUP_TABLE default
7 0 8 0
FIELD FieldData 2
stress 2 4 float
1 2 3 4 5 6 7 8
METADATA
COMPONENT_NAMES
in%20plane
across

mark 1 4 bit
1 0 0 1
POINT_DATA 6
SCALARS first%20one short
LOOKUP_TABLE mine
1 2 3 4 5 6
LOOKUP_TABLE mine 2
0 0 0 1
1 1 1 1
VECTORS velocity double
1 0 0 2 0 0 3 0 0 4 0 0 5 0 0 6 0 0
METADATA
INFORMATION 1
NAME L2_NORM_RANGE LOCATION vtkDataArray
DATA 2 1 6

NORMALS n float
0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1
GLOBAL_IDS gid vtkIdType
10 11 12 13 14 15
)";
const std::string kField = R"(FIELD FieldData 2
title 1 2 string
two%20words
100%25
TimeValue 1 1 double
0.5
)";

std::string head(const char* version, const char* kind) {
  return std::string("# vtk DataFile Version ") + version + "\na title\n" + kind +
         "\nDATASET UNSTRUCTURED_GRID\n";
}
std::string text4() {
  return head("4.2", "ASCII") + kField + kPointSection + kCounted + kDataSection;
}
std::string text5() {
  return head("5.1", "ASCII") + kField + kPointSection + kLists + kDataSection;
}

// The same in binary.
std::string binary(bool lists) {
  using Ints = std::vector<std::int32_t>;
  using Longs = std::vector<std::int64_t>;
  using Floats = std::vector<float>;
  using Doubles = std::vector<double>;
  Bytes out(true);
  out.text(head(lists ? "5.1" : "3.0", "BINARY"));
  out.text("FIELD FieldData 2\ntitle 1 2 string\n\xC9two words\xC4").text("100%\n");
  out.text("TimeValue 1 1 double\n").put(0.5).text("\nPOINTS 6 double\n");
  out.put_all(Doubles{0, 0, 0, 1, 0, 0.1, 0, 1, 0, 0, 0, 1, 1, 1, -1, 9, 9, 9});
  if (lists) {
    out.text("\nCELLS 5 12\nOFFSETS vtktypeint64\n").put_all(Longs{0, 4, 7, 11, 12});
    out.text("\nCONNECTIVITY vtktypeint64\n");
    out.put_all(Longs{0, 1, 2, 3, 1, 2, 3, 4, 1, 3, 2, 2});
  } else {
    out.text("\nCELLS 4 16\n");
    out.put_all(Ints{4, 0, 1, 2, 3, 3, 1, 2, 3, 4, 4, 1, 3, 2, 1, 2});
  }
  out.text("\nCELL_TYPES 4\n").put_all(Ints{10, 5, 10, 1});
  out.text("\nCELL_DATA 4\nSCALARS region int 1\nLOOKUP_TABLE default\n");
  out.put_all(Ints{7, 0, 8, 0}).text("\nFIELD FieldData 2\nstress 2 4 float\n");
  out.put_all(Floats{1, 2, 3, 4, 5, 6, 7, 8});
  out.text("\nMETADATA\nCOMPONENT_NAMES\nin%20plane\nacross\n\nmark 1 4 bit\n");
  out.put(std::uint8_t{0x90}).text("\nPOINT_DATA 6\nSCALARS first%20one short\n");
  out.text("LOOKUP_TABLE mine\n").put_all(std::vector<std::int16_t>{1, 2, 3, 4, 5, 6});
  out.text("\nLOOKUP_TABLE mine 2\n").put_all(std::vector<char>(8, 'A'));
  out.text("\nVECTORS velocity double\n");
  out.put_all(Doubles{1, 0, 0, 2, 0, 0, 3, 0, 0, 4, 0, 0, 5, 0, 0, 6, 0, 0});
  out.text("\nMETADATA\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\nDATA 2 1 6\n\n");
  out.text("NORMALS n float\n");
  for (int i = 0; i < 6; ++i) out.put_all(Floats{0, 0, 1});
  out.text("\nGLOBAL_IDS gid vtkIdType\n").put_all(Ints{10, 11, 12, 13, 14, 15}).text("\n");
  return out.str();
}

TEST_F(Legacy, ReadsText) {
  const auto source = open("a.vtk", text4());
  const MeshDescription& d = source->description();
  EXPECT_EQ(d.format, "VTK legacy unstructured grid, 4.2, ascii");
  EXPECT_EQ(d.points, 6u);
  EXPECT_EQ(d.cells, 4u);
  const Geometry mesh = source->read_geometry();
  expect_sample(mesh);
  EXPECT_THAT(mesh.tet_source, ElementsAre(0, 2));
  EXPECT_THAT(mesh.lower.types, ElementsAre(5, 1));
  EXPECT_THAT(mesh.lower.connectivity, ElementsAre(1, 2, 3, 2));
  EXPECT_EQ(mesh.unused_points, 1u);
  EXPECT_EQ(d.cell_data.active, (std::map<std::string, std::string>{{"Scalars", "region"}}));
  EXPECT_EQ(d.point_data.active, (std::map<std::string, std::string>{{"Scalars", "first one"},
                                                                     {"Vectors", "velocity"},
                                                                     {"Normals", "n"},
                                                                     {"GlobalIds", "gid"}}));
  EXPECT_THAT(cell_values<std::int32_t>(source.get(), "region"), ElementsAre(7, 0, 8, 0));
  const DataArray stress = read_cell_array(source.get(), "stress");
  EXPECT_THAT(values<float>(stress), ElementsAre(1, 2, 3, 4, 5, 6, 7, 8));
  EXPECT_THAT(stress.info.component_names, ElementsAre("in plane", "across"));
  EXPECT_THAT(cell_values<std::uint8_t>(source.get(), "mark"), ElementsAre(1, 0, 0, 1));
  EXPECT_THAT(point_values<std::int16_t>(source.get(), "first one"), ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(point_values<std::int32_t>(source.get(), "gid"), ElementsAre(10, 11, 12, 13, 14, 15));
  const DataArray title = source->read_array(Association::kField, 0);
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(title.bytes.data()), title.bytes.size()),
            std::string("two words\0"
                        "100%\0",
                        15));
  EXPECT_THAT(values<double>(source->read_array(Association::kField, 1)), ElementsAre(0.5));
}

TEST_F(Legacy, ReadsTheSameOfEveryKind) {
  const std::string expected = dump_of(text4());
  EXPECT_EQ(dump_of(text5()), expected);
  EXPECT_EQ(dump_of(binary(false)), expected);
  EXPECT_EQ(dump_of(binary(true)), expected);
  std::string crlf;
  for (const char c : text5()) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_EQ(dump_of(crlf), expected);
  const std::string comment = replaced(text5(), "POINTS", "# points\nPOINTS");
  EXPECT_EQ(dump_of(replaced(comment, "CELL_TYPES 4", "cell_types 4")), expected);
}

TEST_F(Legacy, ComponentsMayHaveNoName) {
  const auto source = open("a.vtk", replaced(text5(), "in%20plane\n", "\n"));
  EXPECT_THAT(read_cell_array(source.get(), "stress").info.component_names,
              ElementsAre("", "across"));
  EXPECT_THAT(cell_values<std::uint8_t>(source.get(), "mark"), ElementsAre(1, 0, 0, 1));
  for (const Encoding encoding : {Encoding::kRaw, Encoding::kAscii}) {
    const auto back = open("b.vtk", text_of(source.get(), encoding));
    EXPECT_THAT(read_cell_array(back.get(), "stress").info.component_names,
                ElementsAre("", "across"));
  }
}

TEST_F(Legacy, WhatDescribesPointsDescribesNoFieldArray) {
  const auto source =
      open("a.vtk", replaced(text5(), "9 9 9\n", "9 9 9\nMETADATA\nCOMPONENT_NAMES\nx\ny\nz\n\n"));
  for (const ArrayInfo& info : source->description().field_data.arrays) {
    EXPECT_THAT(info.component_names, ElementsAre()) << info.name;
  }
}

std::string says_units(const std::string& word) {
  return "NAME UNITS_LABEL LOCATION vtkDataArray\nDATA " + word + "\n";
}

TEST_F(Legacy, UnitsAreKept) {
  std::string bytes = replaced(
      text5(), "100%25\n", "100%25\n\nMETADATA\nINFORMATION 1\n" + says_units("language") + "\n");
  bytes = replaced(bytes, "across\n",
                   "across\nINFORMATION 3\nNAME OTHER LOCATION vtkDataArray\nDATA x\n" +
                       says_units("k%20Pa") + "NAME UNITS_LABEL LOCATION another\nDATA y\n");
  bytes = replaced(bytes, "DATA 2 1 6\n", "DATA 2 1 6\n" + says_units("%C2%B5m/s"));
  // The points' own are nobody's, and not those of the array before them.
  bytes = replaced(bytes, "9 9 9\n", "9 9 9\nMETADATA\nINFORMATION 1\n" + says_units("mm") + "\n");
  bytes = replaced(bytes, "10 11 12 13 14 15\n",
                   "10 11 12 13 14 15\nMETADATA\nINFORMATION 2\n" + says_units("") +
                       "NAME UNITS_LABEL LOCATION vtkDataArray\n\n");
  const auto expect_units = [](MeshSource* source) {
    const MeshDescription& d = source->description();
    const auto units = [](const AttributeSet& set, const char* name) {
      return set.arrays.at(set.find(name)).units;
    };
    EXPECT_EQ(units(d.field_data, "title"), "language");
    EXPECT_EQ(units(d.field_data, "TimeValue"), "");
    EXPECT_EQ(units(d.cell_data, "region"), "");
    EXPECT_EQ(units(d.cell_data, "stress"), "k Pa");
    EXPECT_EQ(units(d.point_data, "velocity"), "\xC2\xB5m/s");
    EXPECT_EQ(units(d.point_data, "gid"), "");
    EXPECT_THAT(read_cell_array(source, "stress").info.component_names,
                ElementsAre("in plane", "across"));
    EXPECT_EQ(read_cell_array(source, "stress").info.units, "k Pa");
  };
  const auto source = open("a.vtk", bytes);
  expect_units(source.get());
  for (const Encoding encoding : {Encoding::kRaw, Encoding::kAscii}) {
    const std::string written = text_of(source.get(), encoding);
    EXPECT_THAT(written, ::testing::HasSubstr("METADATA\nCOMPONENT_NAMES\nin%20plane\nacross\n"
                                              "INFORMATION 1\n" +
                                              says_units("k%20Pa") + "\n"));
    EXPECT_THAT(written,
                ::testing::HasSubstr("METADATA\nINFORMATION 1\n" + says_units("%C2%B5m/s") + "\n"));
    const auto back = open("b.vtk", written);
    expect_units(back.get());
    EXPECT_EQ(text_of(back.get(), encoding), written);
  }
  // One that is active as two kinds stands there twice.
  const std::string again = "NORMALS velocity double\n1 0 0 2 0 0 3 0 0 4 0 0 5 0 0 6 0 0\n";
  expect_units(open("c.vtk", bytes + "\n" + again).get());
}

// As VTK writes an array that is active as several kinds.
TEST_F(Legacy, OneArrayMayBeActiveAsSeveralKinds) {
  const std::string values3 = "1 0 0 2 0 0 3 0 0 4 0 0 5 0 0 6 0 0\n";
  const auto source =
      open("a.vtk", text5() + "TENSORS6 t float\n" + values3 + values3 + "VECTORS w double\n" +
                        values3 + "NORMALS w double\n" + values3);
  const AttributeSet& set = source->description().point_data;
  EXPECT_EQ(set.active.at("Normals"), "n");
  const auto twice = open("b.vtk", replaced(text5(), "NORMALS n float",
                                            "NORMALS velocity double\n" + values3 +
                                                "SCALARS n float 3\nLOOKUP_TABLE default"));
  const MeshDescription& d = twice->description();
  EXPECT_EQ(d.point_data.active.at("Vectors"), "velocity");
  EXPECT_EQ(d.point_data.active.at("Normals"), "velocity");
  EXPECT_EQ(d.point_data.arrays.size(), 4u);
  const auto back = open("c.vtk", text_of(twice.get(), Encoding::kAscii));
  EXPECT_EQ(back->description().point_data.active, d.point_data.active);
  EXPECT_EQ(back->description().point_data.arrays.size(), 4u);
  EXPECT_THAT(point_values<double>(back.get(), "velocity"),
              ElementsAre(1, 0, 0, 2, 0, 0, 3, 0, 0, 4, 0, 0, 5, 0, 0, 6, 0, 0));
  expect_error("d.vtk", text5() + "VECTORS n double\n" + values3,
               "two arrays called \"n\", of different types");
}

TEST_F(Legacy, ReadsRareAttributes) {
  const std::string bytes = head("2.0", "ASCII") + R"(POINTS 4 int
0 0 0 1 0 0 0 1 0 0 0 1
CELLS 1 5
4 0 1 2 3
CELL_TYPES 1
10
POINT_DATA 4
COLOR_SCALARS colour 2
0 0.5 1 2 -1 nan .3 .7
TENSORS t9 float
1 2 3 4 5 6 7 8 9 1 2 3 4 5 6 7 8 9 1 2 3 4 5 6 7 8 9 1 2 3 4 5 6 7 8 9
TENSORS6 t6 float
1 2 3 4 5 6 1 2 3 4 5 6 1 2 3 4 5 6 1 2 3 4 5 6
TEXTURE_COORDINATES uv 2 float
0 0 0 1 1 0 1 1
PEDIGREE_IDS pid vtktypeint64
1 2 3 4
EDGE_FLAGS edge unsigned_char
1 1 0 1
SCALARS without_table float
1 2 3 4
Scalars of_freefem int1
LOOKUP_TABLE table
5 6 7 8
FIELD more 2
names 1 4 string
a b

c
d
NULL_ARRAY
)";
  const auto source = open("a.vtk", bytes);
  const MeshDescription& d = source->description();
  EXPECT_EQ(d.format, "VTK legacy unstructured grid, 2.0, ascii");
  EXPECT_THAT(d.unread, ElementsAre("names"));
  EXPECT_EQ(d.point_type, ValueType::kFloat64);
  EXPECT_THAT(point_values<std::uint8_t>(source.get(), "colour"),
              ElementsAre(0, 128, 255, 255, 0, 0, 77, 178));
  EXPECT_EQ(read_point_array(source.get(), "t9").info.components, 9u);
  EXPECT_EQ(read_point_array(source.get(), "t6").info.components, 6u);
  EXPECT_EQ(d.point_data.active, (std::map<std::string, std::string>{{"Scalars", "colour"},
                                                                     {"Tensors", "t9"},
                                                                     {"TCoords", "uv"},
                                                                     {"PedigreeIds", "pid"},
                                                                     {"EdgeFlag", "edge"}}));
  EXPECT_THAT(point_values<float>(source.get(), "without_table"), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(point_values<std::int32_t>(source.get(), "of_freefem"), ElementsAre(5, 6, 7, 8));
  dump_of(bytes);
}

TEST_F(Legacy, GhostsAreDropped) {
  const std::string bytes =
      replaced(kDataSection, "mark 1 4 bit\n1 0 0 1", "vtkGhostType 1 4 unsigned_char\n0 0 1 0");
  const auto source = open_both_ways(head("4.2", "ASCII") + kPointSection + kCounted + bytes);
  const Geometry mesh = source->read_geometry();
  EXPECT_EQ(mesh.tets.size(), 1u);
  EXPECT_EQ(mesh.ghost_cells, 1u);
}

TEST_F(Legacy, SplitsCells) {
  const std::string bytes = head("3.1", "ASCII") + R"(POINTS 8 float
0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1
CELLS 1 9
8 0 1 2 3 4 5 6 7
CELL_TYPES 1
12
)";
  expect_error("a.vtk", bytes, "cell 0 is a hexahedron (VTK cell type 12): use --tetrahedralize");
  EXPECT_GE(open_both_ways(bytes, {true, false, {}})->read_geometry().tets.size(), 5u);
}

// More cells than are counted in one go.
TEST_F(Legacy, ReadsLongListsInWindows) {
  const Geometry cube = testing::five_split_cube(20);
  Bytes out(true);
  const auto& points = std::get<Vector<Vec3<double>>>(cube.points);
  out.text(head("4.2", "BINARY") + "POINTS " + std::to_string(points.size()) + " double\n");
  for (const auto& p : points) out.put(p.x).put(p.y).put(p.z);
  std::vector<std::int32_t> list, types;
  for (std::size_t t = 0; t < cube.tets.size(); ++t) {
    if (t % 1000 == 7) {
      list.insert(list.end(), {1, static_cast<std::int32_t>(cube.tets[t][0])});
      types.push_back(1);
    }
    list.push_back(4);
    list.insert(list.end(), cube.tets[t].begin(), cube.tets[t].end());
    types.push_back(10);
  }
  out.text("\nCELLS " + std::to_string(types.size()) + " " + std::to_string(list.size()) + "\n");
  out.put_all(list).text("\nCELL_TYPES " + std::to_string(types.size()) + "\n").put_all(types);
  EXPECT_EQ(open_both_ways(out.str())->read_geometry().tets, cube.tets);
}

TEST_F(Legacy, SaysWhatIsWrongAndWhere) {
  const std::string t4 = text4();
  const std::string t5 = text5();
  const auto expect = [&](const std::string& bytes, const std::string& words) {
    expect_error("a.vtk", bytes, words);
  };
  expect(replaced(t4, "Version 4.2", "Version 6.0"), "line 1: version '6.0' is not known");
  expect(replaced(t4, "ASCII", "TEXT"), "line 3: expected ASCII or BINARY, found 'TEXT'");
  expect(replaced(t4, "DATASET UNS", "DATA UNS"), "line 4: expected DATASET UNSTRUCTURED_GRID");
  expect(replaced(t4, "POINTS 6", "POINTS six"), "line 11: expected a count, found 'six'");
  expect(replaced(t4, "POINTS 6 double", "POINTS 6"), "line 11: expected POINTS COUNT TYPE");
  expect(replaced(t4, "POINTS 6 double", "POINTS 6 quad"),
         "POINTS: arrays of type 'quad' cannot be");
  expect(replaced(t4, "POINTS 6", "POINTS 7"), "line 15: POINTS: expected 21 numbers, found 18");
  expect(replaced(t4, "POINTS 6", "POINTS 5"),
         "line 14: expected a section, as POINTS, CELLS or POINT_DATA, found '9 9 9'");
  expect(replaced(t4, "POINTS 6", "POINTS 666666666666"), "the file is cut off or damaged");
  expect(replaced(t4, "1 0 0.1", "1 0 0.1x"), "\"0.1x\" is not a number of type Float64");
  expect(replaced(t4, "4 4 1 3 2", "4 4 1 3 6"), "cell 2 uses point 6, but there are 6 points");
  expect(replaced(t4, "4 4 1 3 2", "4 4 1 -3 2"), "cell 2 uses point -3");
  expect(replaced(t4, "CELLS 4 16", "CELLS 3 16"),
         "CELLS: the list has 16 numbers, but its 3 cells end after 14");
  expect(replaced(t4, "4 4 1 3 2", "9 4 1 3 2"),
         "CELLS: cell 2 has 9 points, but 6 numbers follow");
  expect(replaced(t4, "CELLS 4 16", "CELLS 17 16"), "17 cells cannot be listed in 16 numbers");
  expect(replaced(t4, "CELL_TYPES 4", "CELL_TYPES 3"), "there are 3 CELL_TYPES, but 4 CELLS");
  expect(replaced(t4, "5 10", "6 10"), "cell 1 is a triangle strip");
  expect(replaced(t4, "10\n5", "10\n10"), "cell 1 has 3 vertices, expected 4 for a tetrahedron");
  expect(replaced(t4, "10\n5", "10\n999"), "cell 1 has the type 999, which VTK does not have");
  expect(replaced(t5, "OFFSETS", "offset"), "expected OFFSETS and a type");
  expect(replaced(t5, "0 4 7 11 12", "1 4 7 11 12"), "OFFSETS: expected the first one to be 0");
  expect(replaced(t5, "0 4 7 11 12", "0 4 7 11 13"), "cell 3 goes from 11 to 13, but there are 12");
  expect(replaced(t5, "CONNECTIVITY vtktypeint64", "CONNECTIVITY float"), "expected integers");
  expect(replaced(t5, "POINT_DATA 6", "POINT_DATA 5"),
         "POINT_DATA is of 5, but there are 6 points");
  expect(replaced(t5, "mark 1 4", "mark 1 3"), "array \"mark\" has 3 tuples, expected 4");
  expect(replaced(t5, "mark", "stress"), "there are two arrays called \"stress\": rename one");
  expect(replaced(t5, "NORMALS n", "NORMELS n"), "expected a section");
  expect(replaced(t5, "TimeValue 1 1", "TimeValue 0 1"), "0 components cannot be read");
  expect(head("4.2", "ASCII"), "there are no POINTS");
  expect(head("4.2", "ASCII") + kPointSection, "there are no CELLS");
  const std::string cut = binary(true);
  expect(cut.substr(0, 260), "rows of 3 values do not fit into");
  expect(replaced(cut, "POINTS 6", "POINTS 5"),
         "the section before it has another length than its");
}

TEST_F(Legacy, PointsThatNobodyUsesNeedNoNumbers) {
  dump_of(replaced(text4(), "9 9 9", "9 9 nan"));
  expect_error("a.vtk", replaced(text4(), "1 1 -1", "1 1 inf"), "point 4 has the z coordinate inf");
}

TEST_F(Legacy, SurvivesDamage) {
  for (const std::string& bytes : {text4(), text5(), binary(false), binary(true)}) {
    expect_no_crash("a.vtk", bytes);
  }
}

// Arrays come last: without them a file is whole.
TEST_F(Legacy, IsNeverReadByHalf) {
  for (std::string bytes : {text4(), text5(), binary(true), binary(false)}) {
    bytes.resize(bytes.find("CELL_DATA"));
    expect_no_half_mesh("a.vtk", bytes);
  }
}

TEST_F(Legacy, WritesText) {
  const auto source = open("a.vtk", binary(false));
  EXPECT_EQ(text_of(source.get(), Encoding::kAscii), R"(# vtk DataFile Version 5.1
TetFusion
ASCII
DATASET UNSTRUCTURED_GRID
FIELD FieldData 2
title 1 2 string
two%20words
100%25
TimeValue 1 1 double
0.5
POINTS 6 double
0 0 0
1 0 0.1
0 1 0
0 0 1
1 1 -1
9 9 9
CELLS 5 12
OFFSETS vtktypeint64
0
4
8
11
12
CONNECTIVITY vtktypeint64
0 1 2 3
4 1 3 2
1
2
3
2
CELL_TYPES 4
10
10
5
1
CELL_DATA 4
SCALARS region int 1
LOOKUP_TABLE default
7
8
0
0
FIELD FieldData 2
stress 2 4 float
1 2
5 6
3 4
7 8
METADATA
COMPONENT_NAMES
in%20plane
across

mark 1 4 unsigned_char
1
0
0
1
POINT_DATA 6
SCALARS first%20one short 1
LOOKUP_TABLE default
1
2
3
4
5
6
VECTORS velocity double
1 0 0
2 0 0
3 0 0
4 0 0
5 0 0
6 0 0
NORMALS n float
0 0 1
0 0 1
0 0 1
0 0 1
0 0 1
0 0 1
GLOBAL_IDS gid int
10
11
12
13
14
15
)");
}

TEST_F(Legacy, KeepsAllArrays) {
  testing::rich_box(6).write(dir_.file("box.vtu"));
  const auto source = open_mesh(dir_.file("box.vtu"));
  EXPECT_EQ(left_out_of("x.vtk", source->description()), "");
  for (const Encoding encoding : {Encoding::kRaw, Encoding::kAscii}) {
    const std::string bytes = text_of(source.get(), encoding);
    const auto back = open("b.vtk", bytes);
    EXPECT_EQ(back->description().point_data.active, source->description().point_data.active);
    // Cells of lower dimension have moved behind the tetrahedra, for good.
    const std::string again = text_of(back.get(), encoding);
    EXPECT_EQ(again, bytes);
    const Geometry before = source->read_geometry();
    const Geometry after = back->read_geometry();
    EXPECT_EQ(before.tets, after.tets);
    EXPECT_EQ(before.lower.connectivity, after.lower.connectivity);
    EXPECT_EQ(testing::coordinates<double>(before), testing::coordinates<double>(after));
    for (const ArrayInfo& info : source->description().point_data.arrays) {
      const DataArray array = read_point_array(back.get(), info.name);
      EXPECT_EQ(array.info.type, info.type);
      EXPECT_EQ(array.bytes, read_point_array(source.get(), info.name).bytes) << info.name;
    }
  }
}

}  // namespace
}  // namespace tetfusion
