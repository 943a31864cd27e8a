// Files of solvers that VTK reads: EnSight, OpenFOAM.
#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "io/open_mesh.h"
#include "support/vtk_file_test.h"

namespace tetfusion {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsNan;
using testing::rows_of_array;
using testing::values_at_points;

std::string texts_of(MeshSource* mesh, const std::string& name) {
  const std::size_t at = mesh->description().field_data.find(name);
  if (at == AttributeSet::npos) return "none";
  const auto bytes = mesh->read_array(Association::kField, at).bytes;
  std::string all(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::replace(all.begin(), all.end(), '\0', '|');
  return all;
}

std::vector<float> coordinates_of(const Geometry& g) {
  std::vector<float> all;
  for (const Vec3<float>& p : std::get<Vector<Vec3<float>>>(g.points)) {
    all.insert(all.end(), {p.x, p.y, p.z});
  }
  return all;
}

// The names of the files beside the one that is given, without folders.
std::vector<std::string> names_of_files(const MeshSource& mesh) {
  std::vector<std::string> names;
  for (const std::string& file : mesh.description().files) {
    EXPECT_TRUE(std::filesystem::exists(file)) << file;
    names.push_back(std::filesystem::path(file).filename().string());
  }
  return names;
}

// Two tetrahedra that share a face, each a part with points of its own.
class EnSight : public testing::VtkFileTest {
 protected:
  static std::string part(int number, const std::string& contents) {
    return "part\n" + std::to_string(number) + "\n" + contents;
  }

  // At two times: the second one moves the last point, has other values and another file of `heat`.
  std::string write_case(const std::string& times = "0.1 0.7") {
    const auto geometry = [](const std::string& last) {
      return "a mesh\nby hand\nnode id off\nelement id off\n" +
             part(1,
                  "rock\ncoordinates\n4\n0\n1\n0\n0\n0\n0\n1\n0\n0\n0\n0\n1\n"
                  "tetra4\n1\n1 2 3 4\n") +
             part(2, "vein of ore\ncoordinates\n4\n1\n0\n0\n" + last +
                         "\n0\n1\n0\n1\n0\n0\n1\n1\ntetra4\n1\n1 2 3 4\n");
    };
    write("mesh.geo07", geometry("1"));
    write("mesh.geo10", geometry("2"));
    for (const auto& [number, plus] : {std::pair<std::string, int>{"07", 0}, {"10", 100}}) {
      const auto value = [plus = plus](int v) { return std::to_string(v + plus) + "\n"; };
      write("heat." + number,
            "heat\n" + part(1, "coordinates\n" + value(1) + value(2) + value(3) + value(4)) +
                part(2, "coordinates\n" + value(2) + value(3) + value(4) + value(5)));
      write("stress." + number,
            "stress\n" + part(1, "tetra4\n" + value(7)) + part(2, "tetra4\n" + value(8)));
    }
    write("wet", "wet\n" + part(2, "coordinates\n5\n6\n7\n8\n"));
    return write("run.case", R"(# by hand
FORMAT
type: ensight gold

GEOMETRY
model: 1 mesh.geo**

VARIABLE
scalar per node: 1 heat heat.**
scalar per element: 1 stress stress.**
scalar per node: wet wet

TIME
time set: 1
number of steps: 2
filename start number: 7
filename increment: 3
time values: )" + times + "\n");
  }
};

TEST_F(EnSight, PartsAreBlocksOfOneMesh) {
  const auto mesh = open_with_vtk(write_case());
  const MeshDescription& d = mesh->description();
  EXPECT_EQ(d.format, "EnSight case, read with VTK");
  EXPECT_THAT(d.time_steps, ElementsAre(0.1, 0.7));  // as they are written: VTK's are rounded
  EXPECT_EQ(d.pieces, 2u);
  EXPECT_EQ(d.point_type, ValueType::kFloat32);
  const Geometry g = mesh->read_geometry();
  EXPECT_THAT(g.tets, ElementsAre(Tet{0, 1, 2, 3}, Tet{1, 2, 3, 4}));
  EXPECT_EQ(g.merged_points, 3u);
  EXPECT_EQ(g.differing_points, 0u);
  EXPECT_THAT(coordinates_of(g), ElementsAre(0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1));
  EXPECT_THAT(values_at_points<float>(mesh.get(), "heat"), ElementsAre(1, 2, 3, 4, 5));
  EXPECT_THAT(rows_of_array<float>(mesh.get(), Association::kCell, "stress"), ElementsAre(7, 8));
  EXPECT_THAT(rows_of_array<std::int32_t>(mesh.get(), Association::kCell, "block"),
              ElementsAre(0, 1));
  EXPECT_EQ(texts_of(mesh.get(), "block_names"), "rock|vein of ore|");
  EXPECT_THAT(rows_of_array<double>(mesh.get(), Association::kField, "TimeValue"),
              ElementsAre(0.1));
  EXPECT_THAT(d.left_out, ElementsAre(HasSubstr("the time steps from 0.7 to 0.7 (the first of 2")));
  EXPECT_THAT(names_of_files(*mesh), ElementsAre("mesh.geo07", "heat.07", "stress.07", "wet"));
}

TEST_F(EnSight, AnotherStepIsReadWhereItIsAskedFor) {
  OpenOptions options;
  for (const std::uint64_t step : {std::uint64_t{1}, kLastTimeStep}) {
    options.time_step = step;
    const auto mesh = open_mesh(write_case(), options);
    EXPECT_EQ(mesh->description().time_step, 1u);
    EXPECT_THAT(mesh->description().left_out, IsEmpty());
    const Geometry g = mesh->read_geometry();
    EXPECT_THAT(coordinates_of(g), ElementsAre(0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 2, 1, 1));
    EXPECT_THAT(values_at_points<float>(mesh.get(), "heat"), ElementsAre(101, 102, 103, 104, 105));
    EXPECT_THAT(rows_of_array<float>(mesh.get(), Association::kCell, "stress"),
                ElementsAre(107, 108));
    EXPECT_THAT(rows_of_array<double>(mesh.get(), Association::kField, "TimeValue"),
                ElementsAre(0.7));
    EXPECT_THAT(names_of_files(*mesh), ElementsAre("mesh.geo10", "heat.10", "stress.10", "wet"));
  }
  EXPECT_THAT(time_steps_of(dir_.file("run.case")), ElementsAre(0.1, 0.7));
  options.time_step = 2;
  EXPECT_THAT(error_of(dir_.file("run.case"), options, ErrorCode::kUsage),
              HasSubstr("no time step 2"));
}

TEST_F(EnSight, APartWithoutAnArrayHasNotANumber) {
  const auto mesh = open_with_vtk(write_case());
  EXPECT_THAT(values_at_points<float>(mesh.get(), "wet"),
              ElementsAre(IsNan(), 5.0F, 6.0F, 7.0F, 8.0F));
}

TEST_F(EnSight, FilesThatAreMissingAreNamed) {
  const std::string path = write_case();
  for (const char* name : {"wet", "heat.07", "mesh.geo07"}) {
    std::filesystem::remove(dir_.file(name));
    EXPECT_THAT(error_of(path), AllOf(HasSubstr(dir_.file(name)), HasSubstr("is not there")));
  }
  // Of another step only the geometry of the first is looked at.
  write_case();
  std::filesystem::remove(dir_.file("heat.07"));
  OpenOptions options;
  options.time_step = 1;
  EXPECT_EQ(error_of(path, options), "no error");
  EXPECT_THAT(error_of(write("none.case", "FORMAT\ntype: ensight gold\n")),
              HasSubstr("names no file of a geometry"));
}

// VTK's reader would look for the marks of steps that are missing without end.
TEST_F(EnSight, StepsOfOneFileNeedTheirMarks) {
  write_case();
  const auto step = [](const std::string& text) {
    return "BEGIN TIME STEP\n" + text + "END TIME STEP\n";
  };
  const auto heat = [](const std::string& values) {
    return "heat\n" + part(2, "coordinates\n" + values);
  };
  std::ifstream geometry(dir_.file("mesh.geo07"));
  write("all.geo", step({std::istreambuf_iterator<char>(geometry), {}}));
  const std::string both = step(heat("1\n2\n3\n4\n")) + step(heat("5\n6\n7\n8\n"));
  write("all.heat", both);
  const auto case_of = [](const std::string& model) {
    return "FORMAT\ntype: ensight gold\nGEOMETRY\nmodel: " + model +
           "\nVARIABLE\nscalar per node: 1 1 heat all.heat\nTIME\ntime set: 1\nnumber of steps: 2\n"
           "time values: 0 1\ntime set: 2\nnumber of steps: 1\ntime values: 0\n"
           "FILE\nfile set: 1\nnumber of steps: 2\nfile set: 2\nnumber of steps: 1\n";
  };
  const std::string path = write("all.case", case_of("2 2 all.geo"));
  OpenOptions options;
  options.time_step = 1;
  const auto mesh = open_with_vtk(path, options);
  EXPECT_THAT(values_at_points<float>(mesh.get(), "heat"),
              ElementsAre(IsNan(), 5.0F, 6.0F, 7.0F, 8.0F));
  EXPECT_THAT(names_of_files(*mesh), ElementsAre("all.geo", "all.heat"));
  write("all.heat", both.substr(0, both.size() / 2));
  EXPECT_EQ(error_of(path), "no error");
  EXPECT_THAT(error_of(path, options), AllOf(HasSubstr("all.heat"), HasSubstr("marks of 2")));
  EXPECT_THAT(error_of(write("mixed.case", case_of("1 mesh.geo07"))),
              AllOf(HasSubstr("mesh.geo07"), HasSubstr("no file set")));
}

TEST_F(EnSight, DamagedFilesAreErrorsThatNobodyPrints) {
  const std::string path = write_case();
  for (const std::string name : {"mesh.geo07", "heat.07", "stress.07", "run.case"}) {
    std::ifstream file(dir_.file(name));
    const std::string text(std::istreambuf_iterator<char>(file), {});
    for (std::size_t length = 1; length < text.size(); length += text.size() / 7) {
      write(name, text.substr(0, length));
      const std::string told = error_of(path);  // or none: what is missing may be whole numbers
      const std::size_t width = length - (text.substr(0, length).rfind('\n') + 1);
      if (name != "run.case" && width % 8 != 0 && width % 10 != 0 && width % 12 != 0) {
        EXPECT_NE(told, "no error") << name << " cut at " << length;
      }
    }
    write(name, text);
  }
  EXPECT_EQ(error_of(path), "no error");
}

// VTK's reader would take lines behind the end of the file, for minutes.
TEST_F(EnSight, CountsOfMoreThanTheFileHasAreErrors) {
  const std::string path = write_case();
  std::ifstream file(dir_.file("mesh.geo07"));
  const std::string text(std::istreambuf_iterator<char>(file), {});
  const auto with_count = [&](const std::string& kind, const std::string& from,
                              const std::string& to) {
    const std::string before = kind + "\n" + from + "\n";
    const std::size_t at = text.find(before);
    EXPECT_NE(at, std::string::npos) << kind;
    write("mesh.geo07", std::string(text).replace(at, before.size(), kind + " \n " + to + "\r\n"));
    return error_of(path);
  };
  for (const std::string many : {"400", "2000000000", "99999999999999999999", "-1"}) {
    for (const auto& [kind, count] :
         {std::pair<std::string, std::string>{"coordinates", "4"}, {"tetra4", "1"}}) {
      EXPECT_THAT(with_count(kind, count, many),
                  AllOf(HasSubstr("mesh.geo07 says that of '" + kind + "' there are " + many),
                        HasSubstr("damaged")));
    }
  }
  EXPECT_EQ(with_count("tetra4", "1", "1"), "no error");
}

TEST_F(EnSight, BytesOfADamagedCaseDoNotReachTheTerminal) {
  const std::string path =
      write("wrong.case", "FORMAT\ntype: ensight gold\nGEOMETRY\nmodel: me\x1Bsh\xFF.geo\n");
  EXPECT_THAT(error_of(path), HasSubstr("me?sh?.geo, which this case names, is not there"));
}

TEST_F(EnSight, TimesMustBeThoseThatVtkCanTellApart) {
  const std::string path = write_case();
  std::ifstream file(path);
  const std::string text(std::istreambuf_iterator<char>(file), {});
  const auto told = [&](const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return error_of(write("run.case", std::string(text).replace(at, text.size() - at, to)));
  };
  const std::size_t begin = text.find("time values:");
  ASSERT_NE(begin, std::string::npos);
  EXPECT_THAT(told("time values:", "time values: 10.0000000 10.0000002\n"),
              HasSubstr("single precision"));
  EXPECT_THAT(told("time values:", "time values: 1\n"), HasSubstr("and gives 1 time"));
  EXPECT_THAT(told("TIME", ""), HasSubstr("no time set"));
}

// Two tetrahedra that share a face; at 0.5 there are more fields.
class OpenFoam : public testing::VtkFileTest {
 protected:
  static std::string head(const std::string& kind, const std::string& object) {
    return "FoamFile\n{\n version 2.0;\n format ascii;\n class " + kind + ";\n object " + object +
           ";\n}\n";
  }

  void write_mesh(const std::string& points, const std::string& faces, const std::string& owner,
                  const std::string& neighbour, const std::string& boundary) {
    const std::string folder = "constant/polyMesh/";
    write(folder + "points", head("vectorField", "points") + points);
    write(folder + "faces", head("faceList", "faces") + faces);
    write(folder + "owner", head("labelList", "owner") + owner);
    write(folder + "neighbour", head("labelList", "neighbour") + neighbour);
    write(folder + "boundary", head("polyBoundaryMesh", "boundary") + boundary);
  }

  static std::string patch(const std::string& name, int faces, int first) {
    return name + "{type wall; nFaces " + std::to_string(faces) + "; startFace " +
           std::to_string(first) + ";}\n";
  }

  void write_field(const std::string& time, const std::string& kind, const std::string& name,
                   const std::string& inside, const std::string& wall, const std::string& inlet) {
    write(time + "/" + name, head(kind, name) + "dimensions [0 0 0 1 0 0 0];\ninternalField " +
                                 inside + ";\nboundaryField\n{\nwall{type fixedValue; value " +
                                 wall + ";}\ninlet{type fixedValue; value " + inlet + ";}\n}\n");
  }

  std::string write_case() {
    write_mesh("5((0 0 0)(1 0 0)(0 1 0)(0 0 1)(1 1 1))",
               "7(3(1 2 3) 3(0 2 1) 3(0 1 3) 3(0 3 2) 3(1 2 4) 3(2 3 4) 3(3 1 4))",
               "7(0 0 0 0 1 1 1)", "1(1)", "2(" + patch("wall", 3, 1) + patch("inlet", 3, 4) + ")");
    write_field("0", "volScalarField", "T", "uniform 5", "uniform 6", "uniform 7");
    write_field("0.5", "volScalarField", "T", "nonuniform List<scalar> 2(8 9)",
                "nonuniform List<scalar> 3(10 11 12)", "uniform 13");
    write_field("0.5", "volVectorField", "U", "nonuniform List<vector> 2((1 2 3)(4 5 6))",
                "uniform (0 0 0)", "uniform (7 8 9)");
    write("system/controlDict", head("dictionary", "controlDict"));
    return write("case.foam", "");
  }
};

TEST_F(OpenFoam, TheMeshAndItsPatchesAreBlocks) {
  const auto mesh = open_mesh(write_case());
  const MeshDescription& d = mesh->description();
  EXPECT_EQ(d.format, "OpenFOAM case, read with VTK");
  EXPECT_THAT(d.time_steps, ElementsAre(0, 0.5));
  EXPECT_EQ(d.cells, 8u);
  const Geometry g = mesh->read_geometry();
  EXPECT_THAT(coordinates_of(g), ElementsAre(0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1));
  ASSERT_EQ(g.tets.size(), 2u);
  EXPECT_EQ(std::set<VertexId>(g.tets[0].begin(), g.tets[0].end()),
            (std::set<VertexId>{0, 1, 2, 3}));
  EXPECT_EQ(std::set<VertexId>(g.tets[1].begin(), g.tets[1].end()),
            (std::set<VertexId>{1, 2, 3, 4}));
  EXPECT_THAT(g.lower.types, ElementsAre(5, 5, 5, 5, 5, 5));
  EXPECT_THAT(g.lower.connectivity,
              ElementsAre(0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 4, 2, 3, 4, 3, 1, 4));
  EXPECT_THAT(rows_of_array<std::int32_t>(mesh.get(), Association::kCell, "block"),
              ElementsAre(0, 0, 1, 1, 1, 2, 2, 2));
  EXPECT_EQ(texts_of(mesh.get(), "block_names"), "internalMesh|wall|inlet|");
  EXPECT_THAT(rows_of_array<float>(mesh.get(), Association::kCell, "T"),
              ElementsAre(5, 5, 6, 6, 6, 7, 7, 7));
  EXPECT_THAT(d.point_data.arrays, IsEmpty());  // none is made of the cells'
  EXPECT_EQ(d.field_data.find("CasePath"), AttributeSet::npos);
  EXPECT_THAT(names_of_files(*mesh),
              ElementsAre("T", "boundary", "faces", "neighbour", "owner", "points"));
  EXPECT_THAT(d.files, Contains(EndsWith("/0/T")));
}

TEST_F(OpenFoam, TheControlDictionaryStandsForTheCase) {
  write_case();
  OpenOptions options;
  options.time_step = 1;
  const auto mesh = open_mesh(dir_.file("system/controlDict"), options);
  EXPECT_THAT(rows_of_array<float>(mesh.get(), Association::kCell, "T"),
              ElementsAre(8, 9, 10, 11, 12, 13, 13, 13));
  EXPECT_THAT(rows_of_array<float>(mesh.get(), Association::kCell, "U"),
              ElementsAre(1, 2, 3, 4, 5, 6, 0, 0, 0, 0, 0, 0, 0, 0, 0, 7, 8, 9, 7, 8, 9, 7, 8, 9));
  EXPECT_THAT(rows_of_array<double>(mesh.get(), Association::kField, "TimeValue"),
              ElementsAre(0.5));
  EXPECT_THAT(mesh->description().files, Contains(EndsWith("/0.5/U")));
  EXPECT_THAT(mesh->description().left_out, IsEmpty());
}

TEST_F(OpenFoam, ACaseMayHaveNoTimes) {
  const std::string path = write_case();
  std::filesystem::remove_all(dir_.file("0"));
  std::filesystem::remove_all(dir_.file("0.5"));
  const auto mesh = open_mesh(path);
  EXPECT_THAT(mesh->description().time_steps, IsEmpty());
  EXPECT_EQ(mesh->description().field_data.find("TimeValue"), AttributeSet::npos);
  EXPECT_EQ(mesh->read_geometry().tets.size(), 2u);
  EXPECT_THAT(names_of_files(*mesh),
              ElementsAre("boundary", "faces", "neighbour", "owner", "points"));
}

TEST_F(OpenFoam, AFileThatIsCutOffIsAnError) {
  const std::string path = write_case();
  std::ifstream file(dir_.file("0/T"));
  const std::string text(std::istreambuf_iterator<char>(file), {});
  const std::string whole = "/* a ( in a comment */ // and { here\n" + text;
  write("0/T", whole);
  EXPECT_EQ(error_of(path), "no error");
  write("0/T", whole.substr(0, whole.rfind('}')));
  EXPECT_THAT(error_of(path), AllOf(HasSubstr("0/T"), HasSubstr("is not closed")));
}

// A short way of saying that a list has the same value so many times: VTK makes the list.
TEST_F(OpenFoam, AListThatTakesMoreMemoryThanMayBeTakenIsAnError) {
  const std::string path = write_case();
  const auto field_of = [&](const std::string& list) {
    write_field("0", "volScalarField", "T", "nonuniform List<scalar> " + list, "uniform 6",
                "uniform 7");
  };
  OpenOptions options;
  options.memory = 1;
  field_of("2{5}");
  EXPECT_EQ(error_of(path, options), "no error");
  field_of("200000000{5}");
  EXPECT_THAT(error_of(path, options, ErrorCode::kMemory),
              AllOf(HasSubstr("more than 256.0 MiB"), HasSubstr("give --memory 256M or more"),
                    HasSubstr("damaged")));
  // Twice what the run may take.
  options.memory = std::uint64_t{200} << 20;
  EXPECT_THAT(error_of(path, options, ErrorCode::kMemory),
              AllOf(HasSubstr("more than 400.0 MiB"), HasSubstr("give --memory 400M or more")));
}

TEST_F(OpenFoam, BytesOfADamagedFileDoNotReachTheTerminal) {
  const std::string path = write_case();
  for (const std::string byte : {"\x1B", "\x9B", "\xFF"}) {
    write_field("0", "volScalarField", "T", "nonuniform List<scalar> 2(8 " + byte + ")",
                "uniform 6", "uniform 7");
    EXPECT_THAT(error_of(path), EndsWith("found a non-digit character ?"));
  }
}

TEST_F(OpenFoam, CasesWithoutAMeshAreToldWhatIsMissing) {
  const std::string path = write_case();
  for (const char* name : {"points", "owner", "neighbour"}) {
    const std::string file = dir_.file("constant/polyMesh/" + std::string(name));
    std::filesystem::rename(file, file + ".away");
    EXPECT_THAT(error_of(path), HasSubstr(name));
    std::filesystem::rename(file + ".away", file);
  }
  std::filesystem::remove_all(dir_.file("constant"));
  EXPECT_THAT(error_of(path),
              AllOf(HasSubstr("no mesh in this case"), HasSubstr("polyMesh/faces")));
  std::filesystem::create_directories(dir_.file("processor0/constant/polyMesh"));
  EXPECT_THAT(error_of(path), AllOf(HasSubstr("decomposed"), HasSubstr("reconstructPar")));
}

TEST_F(OpenFoam, RegionsHaveBlocksOfTheirOwn) {
  const std::string path = write_case();
  for (const char* region : {"fluid", "solid"}) {
    std::filesystem::create_directories(dir_.file("constant/" + std::string(region)));
    std::filesystem::copy(dir_.file("constant/polyMesh"),
                          dir_.file("constant/" + std::string(region) + "/polyMesh"));
  }
  std::filesystem::remove_all(dir_.file("constant/polyMesh"));
  write("0/solid/T",
        head("volScalarField", "T") +
            "dimensions [0 0 0 1 0 0 0];\ninternalField uniform 3;\nboundaryField{}\n");
  const auto mesh = open_mesh(path);
  EXPECT_EQ(texts_of(mesh.get(), "block_names"),
            "fluid/internalMesh|fluid/wall|fluid/inlet|solid/internalMesh|solid/wall|solid/inlet|");
  EXPECT_THAT(mesh->description().files, Contains(EndsWith("/solid/polyMesh/points")));
  EXPECT_THAT(mesh->description().files, Contains(EndsWith("/0/solid/T")));
}

// Two prisms over a pentagon, one on the other. Every face of the patches must be one of the cut
// prisms, and the pentagon between them must be cut the same on either side.
TEST_F(OpenFoam, PolygonsOfPatchesAreCutAsThePolyhedraAre) {
  const std::array<std::string, 3> pentagons{
      "(0 0 Z)(2 0 Z)(3 2 Z)(1 3 Z)(-1 2 Z)", "(0 0 Z)(2 0 Z)(2 2 Z)(0 2 Z)(0 1 Z)",
      "(0 0 Z)(1 0 Z)(2 0 Z)(2 2 Z)(0 2 Z)"};  // regular, and with a corner that is none
  for (const std::string& pentagon : pentagons) {
    SCOPED_TRACE(pentagon);
    std::string points = "15(";
    for (const char* height : {"0", "1", "3"}) {
      std::string layer = pentagon;
      for (std::size_t at; (at = layer.find('Z')) != std::string::npos;) {
        layer.replace(at, 1, height);
      }
      points += layer;
    }
    std::string faces = "13(5(5 6 7 8 9) 5(4 3 2 1 0) 5(10 11 12 13 14)";
    for (const int low : {0, 5}) {
      for (int i = 0; i < 5; ++i) {
        const int next = (i + 1) % 5;
        faces += " 4(" + std::to_string(low + i) + " " + std::to_string(low + next) + " " +
                 std::to_string(low + 5 + next) + " " + std::to_string(low + 5 + i) + ")";
      }
    }
    write_mesh(points + ")", faces + ")", "13(0 0 1 0 0 0 0 0 1 1 1 1 1)", "1(1)",
               "2(" + patch("ends", 2, 1) + patch("sides", 10, 3) + ")");
    write("0/T", head("volScalarField", "T") +
                     "dimensions [0 0 0 1 0 0 0];\ninternalField nonuniform List<scalar> 2(4 5);\n"
                     "boundaryField{ends{type fixedValue; value nonuniform List<scalar> 2(6 7);}\n"
                     "sides{type fixedValue; value uniform 8;}}\n");
    const auto mesh = open_mesh(write("case.foam", ""), testing::kSplit);
    const Geometry g = mesh->read_geometry();
    std::map<std::set<VertexId>, int> cells_at;
    for (const Tet& tet : g.tets) {
      for (std::size_t skip = 0; skip < 4; ++skip) {
        std::set<VertexId> face(tet.begin(), tet.end());
        face.erase(tet[skip]);
        ++cells_at[face];
      }
    }
    std::set<std::set<VertexId>> boundary, patches;
    for (const auto& [face, cells] : cells_at) {
      EXPECT_LE(cells, 2);
      if (cells == 1) boundary.insert(face);
    }
    for (std::size_t i = 0; i + 2 < g.lower.connectivity.size(); i += 3) {
      patches.insert(
          {g.lower.connectivity[i], g.lower.connectivity[i + 1], g.lower.connectivity[i + 2]});
    }
    EXPECT_EQ(boundary.size(), 2 * 3 + 10 * 2u);
    EXPECT_EQ(patches, boundary);
    const auto rows = rows_of_array<float>(mesh.get(), Association::kCell, "T");
    std::map<float, int> triangles;
    for (const std::uint64_t row : g.lower_source) ++triangles[rows[row]];
    EXPECT_EQ(triangles, (std::map<float, int>{{6, 3}, {7, 3}, {8, 20}}));
  }
}

TEST(OpenFoamWithoutVtk, AnEmptyFileOfThatNameIsNoEmptyInput) {
  const testing::TempDir dir;
  std::ofstream(dir.file("case.foam")).flush();
  try {
    open_mesh(dir.file("case.foam"));
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadInput);
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr(dir.file("case.foam")), ::testing::Not(HasSubstr("is empty"))));
  }
}

}  // namespace
}  // namespace tetfusion
