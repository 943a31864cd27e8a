// What cannot be read, and what is said of it; and where there is no plugin to read it with.
#include <stdlib.h>

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "support/vtk_file_test.h"

namespace tetfusion {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::kHexahedra;
using testing::kSplit;
using testing::kStructured;
using testing::kTetsFile;
using testing::kXmlStructured;
using testing::plugin_file;

using VtkTrouble = testing::VtkFileTest;

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

TEST_F(VtkTrouble, NamesTheCellThatIsWrong) {
  EXPECT_THAT(error_of(write("a.vtk", with_cell("4 0 1 2 7", "10"))),
              AllOf(HasSubstr("cell 0"), HasSubstr("point 7"), HasSubstr("5")));
  EXPECT_THAT(error_of(write("b.vtk", with_cell("4 0 1 2 -1", "10"))), HasSubstr("point -1"));
  EXPECT_THAT(error_of(write("c.vtk", with_cell("3 0 1 2", "10"))), HasSubstr("has 3 vertices"));
  EXPECT_THAT(error_of(write("d.vtk", with_cell("4 0 1 2 3", "6")), kSplit), HasSubstr("strip"));
  EXPECT_THAT(error_of(write("e.vtk", with_cell("3 0 1 2", "5"))), HasSubstr("no tetrahedra"));
  EXPECT_THAT(error_of(write("f.vtk", with_cell("0", "0"))), HasSubstr("empty cell"));
}

TEST_F(VtkTrouble, TellsAnInvalidMeshFromADamagedFile) {
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

TEST_F(VtkTrouble, NamesThePointThatIsNotFinite) {
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

TEST_F(VtkTrouble, MissingEmptyAndForeignFiles) {
  error_of(dir_.file("missing.vtk"), {}, ErrorCode::kIo);
  EXPECT_THAT(error_of(write("empty.vtk", "")), HasSubstr("empty"));
  EXPECT_THAT(error_of(write("garbage.vtk", "this is not a mesh\n")), HasSubstr("not a mesh file"));
  EXPECT_THAT(error_of(write("garbage.e", "CDF\001 and no more")), HasSubstr("Exodus"));
  EXPECT_THAT(
      error_of(write("other.vtk", "# vtk DataFile Version 3.0\nx\nASCII\nDATASET WHATEVER\n")),
      HasSubstr("VTK"));
}

TEST_F(VtkTrouble, TruncatedFilesAreErrorsThatVtkDoesNotPrint) {
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

TEST_F(VtkTrouble, FilesThatCrashVtkAreErrors) {
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

}  // namespace
}  // namespace tetfusion
