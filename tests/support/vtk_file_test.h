// What the tests of files that VTK reads share.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "io/vtk_bridge.h"
#include "support/temp_dir.h"

namespace tetfusion::testing {

inline std::filesystem::path plugin_file() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / "tetfusion-vtk.so";
}

// Two tetrahedra that share triangle (1, 2, 3), a triangle, a vertex, and point 5, which nobody
// uses.
inline constexpr char kTetsFile[] = R"(# vtk DataFile Version 3.0
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
inline constexpr char kHexahedra[] = R"(# vtk DataFile Version 3.0
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

inline constexpr char kStructured[] = R"(# vtk DataFile Version 3.0
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

inline constexpr char kXmlStructured[] = R"(<?xml version="1.0"?>
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
        <DataArray type="Float32" Name="heat" format="ascii">1.5 2.5
          <InformationKey name="UNITS_LABEL" location="vtkDataArray">W / m</InformationKey>
        </DataArray>
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

inline const OpenOptions kSplit = {.tetrahedralize = true, .linearize = false};

// What points have in the mesh, those of one block after those of the other.
template <class T>
std::vector<T> values_at_points(MeshSource* mesh, const std::string& name) {
  const AttributeSet& set = mesh->description().point_data;
  const DataArray array = mesh->read_array(Association::kPoint, set.find(name));
  const std::size_t width = array.info.components;
  std::vector<T> values;
  for (const std::uint64_t row : mesh->read_geometry().point_source) {
    for (std::size_t c = 0; c < width; ++c) values.push_back(array.as<T>()[row * width + c]);
  }
  return values;
}

// All rows of an array, those of cells in the order of the file.
template <class T>
std::vector<T> rows_of_array(MeshSource* mesh, Association association, const std::string& name) {
  const MeshDescription& d = mesh->description();
  const AttributeSet& set = association == Association::kPoint  ? d.point_data
                            : association == Association::kCell ? d.cell_data
                                                                : d.field_data;
  const std::size_t index = set.find(name);
  if (index == AttributeSet::npos) {
    ADD_FAILURE() << "there is no array " << name;
    return {};
  }
  const DataArray array = mesh->read_array(association, index);
  const auto values = array.as<T>();
  return {values.begin(), values.end()};
}

// Skipped where the plugin is not built.
class VtkFileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(plugin_file())) {
      GTEST_SKIP() << plugin_file() << " is not built: VTK was not found";
    }
  }

  std::string write(const std::string& name, const std::string& text) {
    std::filesystem::create_directories(std::filesystem::path(dir_.file(name)).parent_path());
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
      EXPECT_THAT(message, ::testing::HasSubstr(path));
    }
    return message;
  }

  TempDir dir_;
};

}  // namespace tetfusion::testing
