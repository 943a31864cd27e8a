// Medit meshes: text and binary of every version and byte order, read and written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <string>
#include <vector>

#include "io/left_out.h"
#include "io/open_mesh.h"
#include "support/format_files.h"
#include "support/mesh_file.h"
#include "support/vtu_file_test.h"

namespace tetfusion {
namespace {

using testing::Bytes;
using testing::bytes_of;
using testing::cell_values;
using ::testing::Contains;
using testing::dump;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::point_values;
using testing::replaced;

using Medit = testing::FormatTest;

const char* const kText = R"(# a comment: 1 2 3
MeshVersionFormatted 2
Dimension
3

Vertices
6
0 0 0 1
1 0 0.1 2
0 1 0 3 # the third
0 0 1e0 4
1 1 -1 5
9 9 9 9

Corners
1
1
Triangles 1
2 3 4 7
RequiredVertices
1
3
Tetrahedra
2
1 2 3 4 10
5 2 4 3 -20
Edges
1
1 2 30
End
)";

TEST_F(Medit, ReadsText) {
  const auto source = open_and_compare("a.mesh", kText);
  const MeshDescription& d = source->description();
  EXPECT_EQ(d.format, "Medit mesh, text, version 2");
  EXPECT_THAT(d.left_out, ElementsAre("Corners"));
  EXPECT_EQ(unread_of(d), d.path + " has parts that are not read, and left out: Corners");
  EXPECT_EQ(d.points, 6u);
  EXPECT_EQ(d.cells, 5u);
  const Geometry mesh = source->read_geometry();
  expect_sample(mesh);
  EXPECT_EQ(mesh.unused_points, 1u);
  EXPECT_THAT(mesh.lower.types, ElementsAre(5, 1, 3));
  EXPECT_THAT(mesh.lower.connectivity, ElementsAre(1, 2, 3, 2, 0, 1));
  EXPECT_THAT(mesh.tet_source, ElementsAre(2, 3));
  EXPECT_THAT(mesh.lower_source, ElementsAre(0, 1, 4));
  EXPECT_THAT(cell_values<std::int32_t>(source.get(), "medit:ref"), ElementsAre(7, 0, 10, -20, 30));
  EXPECT_THAT(point_values<std::int32_t>(source.get(), "medit:ref"), ElementsAre(1, 2, 3, 4, 5, 9));
}

TEST_F(Medit, TheVersionOfATextSaysTheTypes) {
  std::string text = kText;
  text.replace(text.find("Formatted 2"), 11, "Formatted 1");
  EXPECT_EQ(open("a.mesh", text)->description().point_type, ValueType::kFloat32);
  text.replace(text.find("Formatted 1"), 11, "Formatted 4");
  text.replace(text.find("-20"), 3, "-99999999999");
  const auto source = open_and_compare("a.mesh", text);
  EXPECT_EQ(source->description().point_type, ValueType::kFloat64);
  EXPECT_THAT(cell_values<std::int64_t>(source.get(), "medit:ref"),
              ElementsAre(7, 0, 10, -99999999999, 30));
}

// As TetGen writes it.
TEST_F(Medit, ATextOfVersion1KeepsItsDigits) {
  std::string text = kText;
  text.replace(text.find("Formatted 2"), 11, "Formatted 1");
  const auto type_of = [&](const std::string& x) {
    std::string with = text;
    with.replace(with.find("1 0 0.1 2"), 9, x + " 0 0.1 2");
    return open("a.mesh", with)->description().point_type;
  };
  for (const char* x : {"0.1", "0.100000001", "0.10000000149011612", "16777216", "3.1415927"}) {
    EXPECT_EQ(type_of(x), ValueType::kFloat32) << x;
  }
  for (const char* x : {"5412345.1", "0.1000000002", "3.14159265", "1e300", "16777217"}) {
    EXPECT_EQ(type_of(x), ValueType::kFloat64) << x;
  }
}

TEST_F(Medit, NumbersOfOtherKinds) {
  std::string text = kText;
  text.replace(text.find("1 0 0.1 2"), 9, "+1.0D+00 0 0.1d0 +2");
  text.replace(text.find("0 0 1e0 4"), 9, "1e-999\t0 1.e+0\r4");
  text.replace(text.find("1 2 3 4 10"), 10, "1 2 3 4 1.0e1");
  EXPECT_EQ(dump(open_and_compare("a.mesh", text).get()),
            dump(open_and_compare("b.mesh", kText).get()));
}

// The mesh of kText without what is passed over.
std::string binary(int version, bool swapped, bool with_end = true) {
  Bytes out(swapped);
  const auto integer = [&](std::int64_t value) {
    version == 4 ? out.put(value) : out.put(static_cast<std::int32_t>(value));
  };
  const std::size_t place = version >= 3 ? 8 : 4;
  const std::size_t word = version == 4 ? 8 : 4;
  const auto section = [&](int number, std::int64_t rows, std::size_t bytes) {
    out.put(number);
    const std::size_t next = out.size() + place + word + bytes;
    place == 8 ? out.put(std::int64_t(next)) : out.put(std::int32_t(next));
    integer(rows);
  };
  const auto integers = [&](const std::vector<int>& all) {
    for (const int value : all) integer(value);
  };
  out.put(std::int32_t{1}).put(std::int32_t{version}).put(std::int32_t{3});
  place == 8 ? out.put(std::int64_t{24}) : out.put(std::int32_t{20});
  out.put(std::int32_t{3});
  const std::vector<std::vector<double>> points = {{0, 0, 0, 1}, {1, 0, 0.1, 2}, {0, 1, 0, 3},
                                                   {0, 0, 1, 4}, {1, 1, -1, 5},  {9, 9, 9, 9}};
  section(4, 6, 6 * (3 * (version == 1 ? 4 : 8) + word));
  for (const auto& p : points) {
    for (int k = 0; k < 3; ++k) version == 1 ? out.put(float(p[k])) : out.put(p[k]);
    integer(static_cast<int>(p[3]));
  }
  section(6, 1, 4 * word);
  integers({2, 3, 4, 7});
  section(15, 1, word);
  integers({3});
  section(8, 2, 10 * word);
  integers({1, 2, 3, 4, 10, 5, 2, 4, 3, -20});
  section(13, 1, word);  // Corners
  integers({1});
  section(5, 1, 3 * word);
  integers({1, 2, 30});
  if (with_end) {
    out.put(std::int32_t{54});
    place == 8 ? out.put(std::int64_t{0}) : out.put(std::int32_t{0});
  }
  return out.str();
}

TEST_F(Medit, ReadsBinary) {
  for (int version = 1; version <= 4; ++version) {
    std::string text = kText;
    text.replace(text.find("Formatted 2"), 11, "Formatted " + std::to_string(version));
    const std::string expected = dump(open_and_compare("a.mesh", text).get());
    for (const bool swapped : {false, true}) {
      const auto source = open_and_compare("a.meshb", binary(version, swapped));
      EXPECT_EQ(dump(source.get()), expected) << version << swapped;
      EXPECT_EQ(source->description().format,
                "Medit mesh, binary, version " + std::to_string(version));
    }
  }
}

TEST_F(Medit, TheContentDecides) {
  EXPECT_EQ(dump(open_and_compare("a.msh", kText).get()),
            dump(open_and_compare("b.mesh", kText).get()));
  EXPECT_EQ(dump(open_and_compare("a", binary(2, true)).get()),
            dump(open_and_compare("b.mesh", kText).get()));
}

TEST_F(Medit, OtherCellsNeedAnOption) {
  const std::string head =
      "MeshVersionFormatted 2 Dimension 3 Vertices 8\n0 0 0 0\n1 0 0 0\n1 1 0 0\n0 1 0 0\n0 0 1 0\n"
      "1 0 1 0\n1 1 1 0\n0 1 1 0\n";
  const std::string hexahedron = head + "Hexahedra 1\n1 2 3 4 5 6 7 8 3\nEnd";
  expect_error("a.mesh", hexahedron, "cell 0 is a hexahedron (VTK cell type 12): use --tetra");
  EXPECT_EQ(open_and_compare("a.mesh", hexahedron, {true, false})->read_geometry().tets.size(), 6u);
  // Both halves of the cube: their tetrahedra are wound like those of VTK.
  const std::string prisms = head + "Prisms 2\n1 2 4 5 6 8 1\n2 3 4 6 7 8 2\nEnd";
  const auto source = open_and_compare("a.mesh", prisms, {true, false});
  const Geometry mesh = source->read_geometry();
  EXPECT_EQ(mesh.tets.size(), 6u);
  double volume = 0;
  for (const Tet& t : mesh.tets) {
    const auto p = [&](int k) { return testing::point(mesh, t[static_cast<std::size_t>(k)]); };
    const auto o = p(0), a = p(1), b = p(2), c = p(3);
    const double six = (a.x - o.x) * ((b.y - o.y) * (c.z - o.z) - (b.z - o.z) * (c.y - o.y)) -
                       (a.y - o.y) * ((b.x - o.x) * (c.z - o.z) - (b.z - o.z) * (c.x - o.x)) +
                       (a.z - o.z) * ((b.x - o.x) * (c.y - o.y) - (b.y - o.y) * (c.x - o.x));
    EXPECT_GT(six, 0);
    volume += six / 6;
  }
  EXPECT_DOUBLE_EQ(volume, 1);
  EXPECT_THAT(cell_values<std::int32_t>(source.get(), "medit:ref"), ElementsAre(1, 2));
  expect_error("a.mesh", head + "HexahedraQ2 1\n1 2 3\nEnd", "HexahedraQ2 cannot be read");
}

TEST_F(Medit, SaysWhatIsWrongAndWhere) {
  const auto with = [](const std::string& from, const std::string& to) {
    return replaced(kText, from, to);
  };
  expect_error("a.mesh", with("0 1 0 3", "0 x1 0 3"),
               "line 6: Vertices: 6 rows of 4 numbers do not fit into the 21 bytes that follow");
  expect_error("a.mesh", with("0 1 0 3", "0 1.5.2 0 3"),
               "line 10: expected a number, found '1.5.2'");
  expect_error("a.mesh", with("1 2 3 4 10", "1 2 3 4 1.5"),
               "line 25: Tetrahedra: the reference '1.5' is no whole number");
  expect_error("a.mesh", with("1 2 3 4 10", "1 2 3 4 3000000000"),
               "'3000000000' is too large or too small: expected -2147483648 to 2147483647");
  expect_error("a.mesh", with("1 2 3 4 10", "1 2 3 7 10"),
               "line 25: Tetrahedra, row 1: uses point 7, but there are points 1 to 6");
  expect_error("a.mesh", with("1 2 3 4 10", "1 2 3 0 10"), "uses point 0");
  expect_error("a.mesh", with("5 2 4 3 -20", "5 2 4 3 -20 8"),
               "line 26: Tetrahedra: expected 2 rows of 5 numbers, found 11 numbers");
  expect_error("a.mesh", with("Vertices\n6", "Vertices\n6000000000000000000"),
               "line 6: Vertices: 6000000000000000000 rows of 4 numbers do not fit");
  expect_error("a.mesh", with("Vertices\n6", "Vertices\n-6"),
               "expected a whole number, found '-6'");
  expect_error("a.mesh", with("Dimension\n3", "Dimension\n2"), "Dimension is 2, expected 3");
  expect_error("a.mesh", with("Formatted 2", "Formatted 5"), "MeshVersionFormatted is 5");
  expect_error("a.mesh", with("0 0 1e0 4", "0 0 nan 4"),
               "point 3 has the z coordinate nan, which is not finite");
  expect_error("a.mesh", with("Vertices", "Vortices"), "there are no Vertices");
  expect_error("a.mesh", "MeshVersionFormatted 2 Dimension 3 Vertices 0 End", "no cells");
  expect_error("a.mesh", "hello End",
               "line 1: expected MeshVersionFormatted, with which Medit's files begin, found "
               "'hello'");
  expect_error("a.mesh", "MFEM mesh v1.0\n\ndimension\n3\n", "a mesh of MFEM, not of Medit");
  expect_error("a.mesh", with("\nEnd\n", ""), "add a line End");
  expect_error("a.mesh", with("-20", "-20 0"),
               "line 26: Tetrahedra: expected 2 rows of 5 numbers, found 11 numbers, 6 in this "
               "line");
  expect_error("a.mesh", with("1 2 3 4 10", "1 2 3 4"),
               "line 25: Tetrahedra: expected 2 rows of 5 numbers, found 9 numbers, 4 in this "
               "line");
}

TEST_F(Medit, SaysWhatIsWrongInBinary) {
  const std::string good = binary(2, false);
  const auto with = [&](std::size_t at, std::int32_t value) {
    std::string bytes = good;
    std::memcpy(bytes.data() + at, &value, 4);
    return bytes;
  };
  expect_error("a.meshb", with(0, 7), "expected MeshVersionFormatted");
  expect_error("a.meshb", with(4, 9), "MeshVersionFormatted is 9");
  expect_error("a.meshb", with(24, 1 << 30), "byte 24: the next keyword is said to be at byte");
  expect_error("a.meshb", with(28, 1 << 30),
               "byte 28: Vertices: 1073741824 rows of 28 bytes do not fit before byte 200");
  expect_error("a.meshb", with(28, -1), "Vertices: -1 rows");
  expect_error("a.meshb", with(212, 77),
               "byte 212: Triangles, row 1: uses point 77, but there are points 1 to 6");
  expect_error("a.meshb", binary(2, false, false), "End is missing");
}

// Some programs do not write it, and a file may have been cut off between two sections.
TEST_F(Medit, EndMayBeMissingBehindAWholeSection) {
  const std::string text = kText;
  const std::string cut_off = text.substr(0, text.find("End"));
  const auto source = open_and_compare("a.mesh", cut_off);
  EXPECT_THAT(
      source->description().left_out,
      Contains("whatever stood behind Edges, if the file was cut off there (End is missing)"));
  const std::string whole = dump(open("a.mesh", text).get());
  EXPECT_EQ(dump(source.get()), whole);
  for (std::size_t end = 0; end < text.size(); ++end) {
    const std::string found = read_or_refuse("a.mesh", text.substr(0, end));
    const char next = text[end];
    if (found.empty() || found == whole) continue;
    // Half a mesh, and that is said: only where a section ends.
    EXPECT_TRUE(std::isalpha(next) || std::isspace(next)) << "cut at byte " << end;
    const auto said = open_mesh(dir_.file("a.mesh"), {})->description().left_out;
    EXPECT_THAT(said.back(), HasSubstr("End is missing")) << "cut at byte " << end;
  }
}

TEST_F(Medit, SurvivesDamage) {
  expect_no_crash("a.mesh", kText);
  for (const int version : {1, 4}) {
    expect_no_half_mesh("a.meshb", binary(version, version == 1));
    expect_no_crash("a.meshb", binary(version, version == 1));
  }
}

TEST_F(Medit, WritesText) {
  const auto source = open_and_compare("a.mesh", kText);
  convert(source.get(), "b.mesh");
  EXPECT_EQ(bytes_of(dir_.file("b.mesh")), R"(MeshVersionFormatted 2

Dimension 3

Vertices
6
0 0 0 1
1 0 0.1 2
0 1 0 3
0 0 1 4
1 1 -1 5
9 9 9 9

Tetrahedra
2
1 2 3 4 10
5 2 4 3 -20

Triangles
1
2 3 4 7

Edges
1
1 2 30

RequiredVertices
1
3

End
)");
}

TEST_F(Medit, WritesWhatItReads) {
  for (int version = 1; version <= 4; ++version) {
    const auto source = open_and_compare("a.meshb", binary(version, true));
    for (const char* name : {"b.mesh", "b.meshb"}) {
      convert(source.get(), name);
      const auto back = open_mesh(dir_.file(name));
      convert(back.get(), "c.vtu.meshb");
      EXPECT_EQ(dump(open_mesh(dir_.file("c.vtu.meshb")).get()), dump(back.get()));
      const Geometry before = source->read_geometry();
      const Geometry after = back->read_geometry();
      EXPECT_EQ(before.points.index(), after.points.index());
      EXPECT_EQ(before.tets, after.tets);
      EXPECT_THAT(point_values<std::int32_t>(open("d.meshb", binary(2, false)).get(), "medit:ref"),
                  ElementsAre(1, 2, 3, 4, 5, 9));
    }
  }
}

// Labels of 64 bits need a version whose coordinates are in double precision.
TEST_F(Medit, CoordinatesStayWhateverTheVersion) {
  testing::MeshFile box;
  box.geometry = testing::to_float(testing::five_split_cube(2, 0.3, 3));
  const auto& points = std::get<Vector<Vec3<float>>>(box.geometry.points);
  box.cell_arrays = {testing::make_array<std::int64_t>(
      "material", box.cells(), 1, [](auto i, auto) { return std::int64_t{1} << (i % 40); })};
  box.write(dir_.file("box.vtu"));
  const auto source = open_mesh(dir_.file("box.vtu"));
  for (const char* name : {"b.mesh", "b.meshb"}) {
    convert(source.get(), name);
    const Geometry back = open_mesh(dir_.file(name))->read_geometry();
    const auto& after = std::get<Vector<Vec3<double>>>(back.points);
    ASSERT_EQ(after.size(), points.size());
    for (std::size_t v = 0; v < points.size(); ++v) {
      EXPECT_EQ(after[v].x, double{points[v].x}) << name;
      EXPECT_EQ(after[v].y, double{points[v].y}) << name;
      EXPECT_EQ(after[v].z, double{points[v].z}) << name;
    }
  }
}

TEST_F(Medit, TakesMaterialsAsReferences) {
  const testing::MeshFile box = testing::rich_box(6);
  box.write(dir_.file("box.vtu"));
  const auto source = open_mesh(dir_.file("box.vtu"));
  EXPECT_EQ(
      left_out_of("x.mesh", source->description()),
      "x.mesh has no place for these arrays, which are left out: f, ids, rgb, tensor, stress, "
      "number, TimeValue");
  EXPECT_EQ(left_out_of("x.vtu", source->description()), "");
  for (const char* name : {"b.mesh", "b.meshb"}) {
    convert(source.get(), name);
    const auto back = open_mesh(dir_.file(name));
    const Geometry before = source->read_geometry();
    const Geometry after = back->read_geometry();
    EXPECT_EQ(before.tets, after.tets) << name;
    EXPECT_EQ(testing::coordinates<double>(before), testing::coordinates<double>(after)) << name;
    const auto old_values = cell_values<std::int32_t>(source.get(), "material");
    const auto new_values = cell_values<std::int32_t>(back.get(), "medit:ref");
    for (std::size_t t = 0; t < before.tets.size(); ++t) ASSERT_EQ(old_values[t], new_values[t]);
  }
}

}  // namespace
}  // namespace tetfusion
