// What files are that the core does not read itself.
#include "io/foreign_format.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <span>
#include <string>
#include <string_view>

#include "base/error.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "support/temp_dir.h"
#include "support/vtk_file_test.h"

namespace tetfusion {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

FormatGuess guess(std::string_view text, const std::string& name = "mesh") {
  return guess_format(name, std::as_bytes(std::span(text.data(), text.size())));
}

TEST(GuessFormat, KnowsTheFirstBytes) {
  EXPECT_EQ(guess(testing::kTetsFile).format, ForeignFormat::kLegacyVtk);
  EXPECT_EQ(guess(testing::kXmlStructured).format, ForeignFormat::kXmlVtk);
  EXPECT_EQ(guess(testing::kXmlStructured).words, "a VTK XML file of type StructuredGrid");
  EXPECT_FALSE(guess(testing::kXmlStructured).is_list);
  EXPECT_TRUE(guess("<VTKFile type=\"Collection\">").is_list);
  EXPECT_TRUE(guess("<VTKFile><Collection>").is_list);
  EXPECT_THAT(guess("<VTKFile type=\"PUnstructuredGrid\">").words, HasSubstr("several files"));
  EXPECT_EQ(guess("<VTKFile").words, "a VTK XML file");
  EXPECT_EQ(guess("<VTKFile type=").words, "a VTK XML file");
  EXPECT_EQ(guess("<VTKFile type=\"").words, "a VTK XML file");
  EXPECT_EQ(guess("CDF\001").format, ForeignFormat::kNetCdf);
  EXPECT_EQ(guess("\x89HDF\r\n\x1a\n").format, ForeignFormat::kHdf5);
  for (const char* mark : {"@(#)", "\xc0\xa8\xa3\xa9"}) {
    EXPECT_EQ(guess(std::string(mark) + "ADF Database Version A02011").format, ForeignFormat::kAdf);
  }
  EXPECT_EQ(guess("hello").format, ForeignFormat::kUnknown);
  EXPECT_EQ(guess("").format, ForeignFormat::kUnknown);
}

TEST(GuessFormat, KnowsXdmfByItsRootOrElseItsName) {
  EXPECT_EQ(guess("<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">").format, ForeignFormat::kXdmf);
  EXPECT_EQ(guess("<Xdmf").words, "an XDMF file");
  const std::string late = "<!--" + std::string(5000, ' ') + "-->\n<Xdmf>";
  EXPECT_EQ(guess(late).format, ForeignFormat::kUnknown);
  for (const char* name : {"a.xdmf", "b/a.XMF"}) {
    EXPECT_EQ(guess(late, name).format, ForeignFormat::kXdmf);
    EXPECT_EQ(guess("hello", name).format, ForeignFormat::kUnknown);
  }
  EXPECT_TRUE(may_have_time_steps(ForeignFormat::kXdmf));
}

TEST(GuessFormat, KnowsEnSightByItsFirstSection) {
  EXPECT_EQ(guess("FORMAT\ntype: ensight gold\n").format, ForeignFormat::kEnSight);
  EXPECT_EQ(guess("# by hand\r\n\r\n  FORMAT\r\n\r\ntype:  ensight\r\n").format,
            ForeignFormat::kEnSight);
  EXPECT_EQ(guess("FORMAT\ntype: other\n").format, ForeignFormat::kUnknown);
  EXPECT_EQ(guess("GEOMETRY\nmodel: a.geo\n").format, ForeignFormat::kUnknown);
  EXPECT_EQ(guess("FORMAT").format, ForeignFormat::kUnknown);
}

TEST(GuessFormat, TheNameSaysOpenFoamWhereTheContentsSayNothing) {
  for (const char* name : {"case.foam", "a/b.FOAM", "case.OpenFOAM", "system/controlDict"}) {
    EXPECT_EQ(guess("", name).format, ForeignFormat::kOpenFoam) << name;
    EXPECT_EQ(guess("FoamFile\n{\n", name).format, ForeignFormat::kOpenFoam) << name;
    EXPECT_EQ(guess("# vtk DataFile", name).format, ForeignFormat::kLegacyVtk) << name;
  }
  EXPECT_EQ(guess("", "foam").format, ForeignFormat::kUnknown);
  EXPECT_EQ(guess("", "controlDict.txt").format, ForeignFormat::kUnknown);
}

TEST(UnreadFormats, AreRefusedWithWhatToDo) {
  const testing::TempDir dir;
  const auto told = [&](const std::string& name, const std::string& text) {
    std::ofstream(dir.file(name), std::ios::binary) << text;
    try {
      open_mesh(dir.file(name));
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBadInput);
      EXPECT_THAT(error.what(), HasSubstr(dir.file(name)));
      return std::string(error.what());
    }
    return std::string("no error");
  };
  const auto to_vtu = [](const char* what, const char* by) {
    return AllOf(HasSubstr(what), HasSubstr(by), HasSubstr(".vtu"));
  };
  EXPECT_THAT(told("a.inp", "*HEADING\n*NODE\n"), to_vtu("Abaqus", "meshio"));
  EXPECT_THAT(told("b.avs", "8 5 1 0 0\n"), to_vtu("AVS UCD", "meshio"));
  EXPECT_THAT(told("b.inp", "no numbers\n"), to_vtu("AVS UCD", "meshio"));
  EXPECT_THAT(told("a.bdf", "SOL 101\n"), to_vtu("NASTRAN", "meshio"));
  EXPECT_THAT(told("a.su2", "NDIME= 3\n"), to_vtu("SU2", "meshio"));
  EXPECT_THAT(told("a.neu", "        CONTROL INFO 1.2.1\n** GAMBIT NEUTRAL FILE\n"),
              AllOf(HasSubstr("GAMBIT"), HasSubstr("Exodus")));
  EXPECT_THAT(
      told("a.vtm", "<?xml version=\"1.0\"?>\n<VTKFile type=\"vtkHierarchicalBoxDataSet\">"),
      to_vtu("AMR", "ParaView"));
  EXPECT_THAT(told("a.sos", "FORMAT\ntype: master_server gold\n"), HasSubstr("server-of-servers"));
  EXPECT_THAT(told("a.gz", "\x1f\x8b\x08"), HasSubstr("unpack it"));
  // Contents that say a format come before the name.
  EXPECT_THAT(told("c.bdf", "MeshVersionFormatted 2\nDimension 3\n"),
              ::testing::Not(HasSubstr("NASTRAN")));
  EXPECT_THAT(told("a.txt", "hello"), HasSubstr("not a mesh file that is read"));
}

}  // namespace
}  // namespace tetfusion
