// What the tests of XDMF files share.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "io/open_mesh.h"
#include "support/format_files.h"
#include "support/vtk_file_test.h"

namespace tetfusion::testing {

// Two tetrahedra that share a triangle, as the contents of a grid.
inline constexpr char kTwoTets[] = R"(
  <Topology TopologyType="Tetrahedron" NumberOfElements="2">
    <DataItem Dimensions="2 4" NumberType="UInt" Format="XML">0 1 2 3  1 2 3 4</DataItem>
  </Topology>
  <Geometry GeometryType="XYZ">
    <DataItem Dimensions="5 3" Format="XML">0 0 0  1 0 0  0 1 0  0 0 1  1 1 1.1</DataItem>
  </Geometry>)";

inline std::string xdmf_text(const std::string& domain, const std::string& before = "") {
  return "<?xml version=\"1.0\"?>\n" + before +
         "<Xdmf Version=\"3.0\" xmlns:xi=\"http://www.w3.org/2001/XInclude\"><Domain>" + domain +
         "</Domain></Xdmf>\n";
}

inline std::string one_grid(const std::string& contents) {
  return xdmf_text("<Grid Name=\"mesh\" GridType=\"Uniform\">" + contents + "</Grid>");
}

inline std::string grid_array(const std::string& name, const std::string& center,
                              const std::string& item) {
  return "<Attribute Name=\"" + name + "\" AttributeType=\"Scalar\" Center=\"" + center + "\">" +
         item + "</Attribute>";
}

inline std::string data_item(const std::string& attributes, const std::string& text) {
  return "<DataItem " + attributes + ">" + text + "</DataItem>";
}

inline std::string heat_of(const std::string& number) {
  return grid_array("heat", "Cell", data_item("Dimensions=\"2\"", number + " " + number));
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

// Its files are run.xdmf, with the text that is given.
class XdmfTest : public VtkFileTest {
 protected:
  std::unique_ptr<MeshSource> mesh_of(const std::string& text, const OpenOptions& options = {}) {
    return open_mesh(write("run.xdmf", text), options);
  }

  std::string fault_of(const std::string& text, const OpenOptions& options = {}) {
    return error_of(write("run.xdmf", text), options);
  }

  void expect_two_tets(MeshSource* mesh) {
    const Geometry g = mesh->read_geometry();
    EXPECT_THAT(g.tets, ::testing::ElementsAre(Tet{0, 1, 2, 3}, Tet{1, 2, 3, 4}));
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

}  // namespace tetfusion::testing
