// Results that are damaged between being written and being verified: each is caught, nothing of it
// gets the output's name, and the message says what is wrong.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <string_view>

#include "base/error.h"
#include "compare/point.h"
#include "driver/simplify.h"
#include "mesh/inspection/inspect.h"
#include "support/file_request.h"
#include "support/mesh_file.h"
#include "support/temp_dir.h"
#include "verify/result_seam.h"

namespace tetfusion {
namespace {

using testing::bytes_of;
using ::testing::HasSubstr;
using testing::MeshFile;
using testing::read_mesh_file;
using testing::rich_box;
using testing::TempDir;
namespace fs = std::filesystem;

using P = Vec3<double>;

Vector<P>& points_of(MeshFile* file) { return std::get<Vector<P>>(file->geometry.points); }

DataArray& array(std::vector<DataArray>& arrays, std::string_view name) {
  return *std::find_if(arrays.begin(), arrays.end(),
                       [&](const DataArray& a) { return a.info.name == name; });
}

std::uint8_t flags(const MeshFile& file, VertexId v) {
  Geometry copy = file.geometry;
  return inspect(copy).vertex_flags[v];
}

bool uses(const Tet& tet, VertexId v) { return std::find(tet.begin(), tet.end(), v) != tet.end(); }

// The materials of the cells round a vertex: a bit each.
unsigned materials(MeshFile* file, VertexId v) {
  const auto values = array(file->cell_arrays, "material").as<std::int32_t>();
  unsigned bits = 0;
  for (std::size_t t = 0; t < file->geometry.tets.size(); ++t) {
    if (uses(file->geometry.tets[t], v)) bits |= 1u << values[t];
  }
  return bits;
}

// The first vertex inside that is, or is not, on an interface.
VertexId inner_vertex(MeshFile* file, bool on_interface) {
  Geometry copy = file->geometry;
  const Inspection inspection = inspect(copy);
  for (VertexId v = 0; v < inspection.vertex_flags.size(); ++v) {
    const unsigned bits = materials(file, v);
    const bool between = (bits & (bits - 1)) != 0;
    if (inspection.vertex_flags[v] == 0 && bits != 0 && between == on_interface) return v;
  }
  throw std::runtime_error("there is no such vertex");
}

VertexId boundary_vertex(MeshFile* file) {
  for (VertexId v = 0;; ++v) {
    if ((flags(*file, v) & kBoundaryVertex) != 0) return v;
  }
}

std::size_t cell_at(const MeshFile& file, VertexId v) {
  const Vector<Tet>& tets = file.geometry.tets;
  const auto at = std::find_if(tets.begin(), tets.end(), [&](const Tet& t) { return uses(t, v); });
  return static_cast<std::size_t>(at - tets.begin());
}

void remove_cell(MeshFile* file, std::size_t cell) {
  if (cell < file->geometry.tets.size()) {
    file->geometry.tets.erase(file->geometry.tets.begin() + static_cast<std::ptrdiff_t>(cell));
  }
  for (DataArray& a : file->cell_arrays) {
    const std::size_t row = a.info.components * size_of(a.info.type);
    const auto at = a.bytes.begin() + static_cast<std::ptrdiff_t>(cell * row);
    a.bytes.erase(at, at + static_cast<std::ptrdiff_t>(row));
    --a.info.tuples;
  }
}

void copy_cell(MeshFile* file, std::size_t cell) {
  const Tet copy = file->geometry.tets[cell];
  file->geometry.tets.insert(file->geometry.tets.begin(), copy);
  for (DataArray& a : file->cell_arrays) {
    const std::size_t row = a.info.components * size_of(a.info.type);
    const auto at = a.bytes.begin() + static_cast<std::ptrdiff_t>(cell * row);
    const Vector<std::byte> bytes(at, at + static_cast<std::ptrdiff_t>(row));
    a.bytes.insert(a.bytes.begin(), bytes.begin(), bytes.end());
    ++a.info.tuples;
  }
}

using Change = std::function<void(MeshFile*)>;

// Damages each result with `change`, or its bytes with `change_bytes`.
class Damager : public ResultSeam {
 public:
  void written(const std::string& path) override {
    ++results;
    if (change_bytes) {
      std::string bytes = bytes_of(path);
      change_bytes(&bytes);
      put(path, bytes);
    }
    if (!change) return;
    MeshFile file = read_mesh_file(path);
    change(&file);
    const TempDir folder = TempDir::in_memory();
    file.write(folder.file("damaged.vtu"));
    put(path, bytes_of(folder.file("damaged.vtu")));
  }
  Change change;
  std::function<void(std::string*)> change_bytes;
  int results = 0;

 private:
  static void put(const std::string& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
  }
};

class DamagedResult : public ::testing::Test {
 protected:
  DamagedResult() { replace_result_seam(&seam); }
  ~DamagedResult() override { replace_result_seam(nullptr); }

  // What --verify says of a result that was damaged.
  std::string complaint(const Change& change) {
    seam.change = change;
    return complaint();
  }
  std::string complaint() {
    input.write(request.input);
    std::ofstream(request.output) << "old";
    try {
      simplify(request);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBroken) << error.what();
      EXPECT_GT(seam.results, 0);
      EXPECT_EQ(bytes_of(request.output), "old");
      const auto files = std::distance(fs::directory_iterator(folder.path()), {});
      EXPECT_EQ(files, 2) << "in.vtu and out.vtu";
      return error.what();
    }
    return "kept";
  }

  TempDir folder = TempDir::in_memory();
  MeshFile input = rich_box(8);
  SimplifyRequest request = [this] {
    SimplifyRequest r = testing::request_in(folder);
    r.behaviour.tets = 1200;
    r.behaviour.max_error = 0.05;
    r.verify = true;
    return r;
  }();
  Damager seam;
};

TEST_F(DamagedResult, IsNoneWhereNothingIsDamaged) {
  EXPECT_EQ(complaint([](MeshFile*) {}), "kept");
  EXPECT_EQ(seam.results, 1);
}

TEST_F(DamagedResult, AnInvertedCell) {
  EXPECT_THAT(complaint([](MeshFile* m) { points_of(m)[inner_vertex(m, false)].x += 3; }),
              HasSubstr("inverted cells"));
}

TEST_F(DamagedResult, AMovedBoundaryPoint) {
  EXPECT_THAT(complaint([](MeshFile* m) {
                double& x = points_of(m)[boundary_vertex(m)].x;
                x = std::nextafter(x, 100.0);
              }),
              HasSubstr("the triangles of its boundary are others than the input's, at ("));
}

TEST_F(DamagedResult, AHole) {
  EXPECT_THAT(complaint([](MeshFile* m) { remove_cell(m, cell_at(*m, inner_vertex(m, false))); }),
              HasSubstr("its boundary"));
}

TEST_F(DamagedResult, ADuplicateCell) {
  EXPECT_THAT(complaint([](MeshFile* m) { copy_cell(m, 7); }),
              HasSubstr("duplicate cells: it has 1, the input 0"));
}

TEST_F(DamagedResult, ALostArray) {
  EXPECT_THAT(complaint([](MeshFile* m) { m->point_arrays.erase(m->point_arrays.begin() + 2); }),
              HasSubstr("it lacks the arrays rgb"));
  EXPECT_THAT(complaint([](MeshFile* m) { m->cell_arrays.pop_back(); }),
              HasSubstr("it lacks the arrays cell:number"));
  EXPECT_THAT(complaint([](MeshFile* m) { m->field_arrays.pop_back(); }),
              HasSubstr("it lacks the arrays field:TimeValue"));
}

TEST_F(DamagedResult, AnotherType) {
  EXPECT_THAT(
      complaint([](MeshFile* m) { array(m->point_arrays, "ids").info.type = ValueType::kUInt64; }),
      HasSubstr("another type: ids (UInt64, was Int64)"));
  EXPECT_THAT(complaint([](MeshFile* m) { m->geometry = testing::to_float(m->geometry); }),
              HasSubstr("its points are Float32, the input's are Float64"));
}

TEST_F(DamagedResult, AValueThatIsNone) {
  EXPECT_THAT(complaint([](MeshFile* m) {
                array(m->point_arrays, "tensor").as<double>()[6 * inner_vertex(m, false) + 2] =
                    std::numeric_limits<double>::quiet_NaN();
              }),
              HasSubstr("tensor is not finite at 1 point"));
  EXPECT_THAT(complaint([](MeshFile* m) {
                array(m->cell_arrays, "stress").as<double>()[40] =
                    std::numeric_limits<double>::infinity();
              }),
              HasSubstr("cell:stress is not finite at 1 cell"));
}

TEST_F(DamagedResult, AValueThatIsNoneWhereThereWasABound) {
  EXPECT_THAT(complaint([](MeshFile* m) {
                array(m->point_arrays, "f").as<float>()[inner_vertex(m, false)] =
                    std::numeric_limits<float>::quiet_NaN();
              }),
              HasSubstr("of the input where the input's is"));
}

TEST_F(DamagedResult, AValueBeyondItsBound) {
  EXPECT_THAT(complaint([](MeshFile* m) {
                array(m->point_arrays, "f").as<float>()[inner_vertex(m, false)] += 4;
              }),
              HasSubstr("the largest error of f is "));
}

TEST_F(DamagedResult, ABoundaryTriangleThatIsGone) {
  EXPECT_THAT(complaint([](MeshFile* m) { remove_cell(m, cell_at(*m, boundary_vertex(m))); }),
              HasSubstr("the triangles of its boundary are others"));
}

TEST_F(DamagedResult, AnInterfaceThatHasMoved) {
  EXPECT_THAT(complaint([](MeshFile* m) {
                double& z = points_of(m)[inner_vertex(m, true)].z;
                z = std::nextafter(z, 100.0);
              }),
              HasSubstr("the triangles of its interfaces of regions are others"));
}

TEST_F(DamagedResult, ACellOfAnotherRegion) {
  EXPECT_THAT(complaint([](MeshFile* m) {
                auto& material = array(m->cell_arrays, "material").as<std::int32_t>()[3];
                material = 3 - material;
              }),
              HasSubstr("interfaces of regions are others"));
  // Where the surfaces between them stay.
  EXPECT_THAT(complaint([](MeshFile* m) {
                for (auto& value : array(m->cell_arrays, "material").as<std::int32_t>()) {
                  value = value == 1 ? 5 : value;
                }
              }),
              HasSubstr("the volume of region 1 of material has changed"));
}

TEST_F(DamagedResult, ACellOfAnotherRegionOfFloats) {
  input.cell_arrays.push_back(testing::make_array<float>(
      "zone", input.cells(), 1,
      [&](std::size_t t, auto) { return t < input.cells() / 2 ? 0.25F : 0.75F; }));
  request.behaviour.regions = {{"zone"}};
  EXPECT_EQ(complaint([](MeshFile*) {}), "kept");
  EXPECT_THAT(complaint([](MeshFile* m) {
                float& zone = array(m->cell_arrays, "zone").as<float>()[3];
                zone = 0.5F;
              }),
              HasSubstr("interfaces of regions are others"));
}

TEST_F(DamagedResult, AnIntegralThatHasChanged) {
  request.behaviour.conserve = true;
  request.behaviour.max_error.reset();
  input = rich_box(7);
  EXPECT_EQ(complaint([](MeshFile*) {}), "kept");
  EXPECT_THAT(complaint([](MeshFile* m) {
                double& v =
                    array(m->point_arrays, "tensor").as<double>()[6 * inner_vertex(m, false)];
                v += 1e-6 * std::abs(v);
              }),
              HasSubstr("the integral of tensor has changed"));
  EXPECT_THAT(complaint([](MeshFile* m) {
                double& v = array(m->cell_arrays, "stress").as<double>()[90];
                v += 1e-6 * std::abs(v);
              }),
              HasSubstr("the integral of cell:stress has changed"));
}

TEST_F(DamagedResult, ALostCellOfLowerDimension) {
  EXPECT_THAT(complaint([](MeshFile* m) {
                LowerCells& lower = m->geometry.lower;
                remove_cell(m, m->cells() - 1);
                lower.types.pop_back();
                lower.offsets.pop_back();
                lower.connectivity.resize(lower.offsets.back());
              }),
              HasSubstr("cells of lower dimension"));
}

TEST_F(DamagedResult, ASurfaceThatHasMovedTooFar) {
  input = rich_box(6);
  input.geometry.lower = {};
  for (DataArray& a : input.cell_arrays) {
    a.info.tuples = input.geometry.tets.size();
    a.bytes.resize(a.info.tuples * a.info.components * size_of(a.info.type));
  }
  request.behaviour.max_error.reset();
  const auto move = [](double by) {
    return [by](MeshFile* m) {
      P& p = points_of(m)[boundary_vertex(m)];
      p = {p.x - by, p.y - by, p.z - by};
    };
  };
  request.behaviour.boundary = Boundary::kWithin;
  request.behaviour.boundary_distance = 0.02;
  EXPECT_EQ(complaint(move(0)), "kept");
  EXPECT_THAT(complaint(move(0.5)), HasSubstr("of the diagonal from the input's, above 2 %, at ("));
  request.behaviour.boundary = Boundary::kPlanar;
  EXPECT_EQ(complaint(move(0)), "kept");
  EXPECT_THAT(complaint(move(1e-3)), HasSubstr("its boundary is "));
  // A hole, however near to the surface.
  request.behaviour.boundary = Boundary::kWithin;
  request.behaviour.boundary_distance = 0.9;
  request.behaviour.tets = 700;
  EXPECT_EQ(complaint(move(0)), "kept");
  EXPECT_THAT(complaint([](MeshFile* m) { remove_cell(m, cell_at(*m, inner_vertex(m, false))); }),
              HasSubstr("a hole or a tunnel has come or gone"));
}

TEST_F(DamagedResult, AMovedPointInTheRegionOfInterest) {
  const auto nearest = [](MeshFile* m, const P& place) {
    Vector<P>& points = points_of(m);
    return std::min_element(points.begin(), points.end(), [&](const P& p, const P& q) {
      return length(p - place) < length(q - place);
    });
  };
  const P centre{4, 4, 4};
  request.behaviour.interest = {"sphere=4,4,4,2.5"};
  request.behaviour.tets = 2000;
  EXPECT_EQ(complaint([](MeshFile*) {}), "kept");
  EXPECT_THAT(complaint([&](MeshFile* m) {
                P& p = *nearest(m, centre);
                p.x = std::nextafter(p.x, 100.0);
              }),
              HasSubstr("cells in the region of interest it lacks "));
}

TEST_F(DamagedResult, ACellThatIsTooLarge) {
  request.behaviour.boundary = Boundary::kWithin;
  request.behaviour.boundary_distance = 0.9;
  request.behaviour.max_volume = 1;
  request.behaviour.tets = 2000;
  EXPECT_EQ(complaint([](MeshFile*) {}), "kept");
  EXPECT_THAT(complaint([](MeshFile* m) {
                const P centre{4, 4, 4};
                P& p = points_of(m)[boundary_vertex(m)];
                p = centre + 4 * (p - centre);
              }),
              HasSubstr("its largest cell has the volume "));
}

TEST_F(DamagedResult, AFileThatIsNone) {
  seam.change_bytes = [](std::string* bytes) { bytes->resize(bytes->size() - 100); };
  EXPECT_THAT(complaint(), HasSubstr("it cannot be read again: the result"));
  seam.change_bytes = [](std::string* bytes) { *bytes = "no mesh"; };
  EXPECT_THAT(complaint(), HasSubstr("it cannot be read again"));
}

}  // namespace
}  // namespace tetfusion
