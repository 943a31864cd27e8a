// What fuzzing begins with: small files of every encoding, made by the tests' writer of .vtu, which
// is not the project's, and by the project's writers of the other formats. What is
// small is tried often.
#include <fcntl.h>

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "driver/checkpoint.h"
#include "driver/convert.h"
#include "fuzz/targets.h"
#include "io/files/file_system.h"
#include "io/mesh_format.h"
#include "io/open_mesh.h"
#include "io/source/mesh_source.h"
#include "io/store/manifest.h"
#include "io/store/section_file.h"
#include "support/mesh_file.h"
#include "support/temp_dir.h"
#include "support/vtu_text.h"

namespace tetfusion::fuzz {

namespace {

using testing::TempDir;
using testing::to_vtu;
using testing::VtuArrayText;
using testing::VtuData;
using testing::VtuPieceText;
using testing::VtuStyle;
using testing::VtuText;

constexpr std::size_t kBlock = 96;  // two of them in the largest arrays

// Two tetrahedra that share a face, one of them by way of a triangle's cell; and all kinds of
// arrays.
VtuPieceText piece(double shift, bool ghosts) {
  VtuPieceText p =
      testing::cell_piece({shift, 0, 0, shift + 1, 0, 0, shift, 1, 0, shift, 0, 1, shift + 1, 1, 1},
                          {10, 10, 5, 1}, {{0, 1, 2, 3}, {4, 1, 3, 2}, {0, 1, 2}, {3}});
  p.point_data = {
      {"f", "Float32", {0, 1, 2, 3, 4}, 1, {}},
      {"v", "Float64", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14}, 3, {}},
      {"GlobalNodeIds", "Int64", {10 * shift, 10 * shift + 1, 10 * shift + 2, 3, 4}, 1, {}}};
  p.cell_data = {{"material", "UInt8", {1, 2, 0, 0}, 1, {}}};
  if (ghosts) p.cell_data.push_back({"vtkGhostType", "UInt8", {0, 1, 0, 0}, 1, {}});
  p.point_attributes = " Scalars=\"f\" GlobalIds=\"GlobalNodeIds\"";
  return p;
}

// Cells to be split, and a ten-node tetrahedron.
VtuPieceText mixed_piece() {
  std::vector<double> xyz;
  for (int i = 0; i < 12; ++i) {
    for (const int c : {i & 1, i >> 1 & 1, i >> 2}) xyz.push_back(c);
  }
  return testing::cell_piece(xyz, {11, 12, 13, 14, 24, 22, 9},
                             {{0, 1, 2, 3, 4, 5, 6, 7},
                              {0, 1, 3, 2, 4, 5, 7, 6},
                              {0, 1, 2, 4, 5, 6},
                              {0, 1, 3, 2, 4},
                              {0, 1, 2, 4, 8, 9, 10, 11, 5, 6},
                              {0, 1, 2, 8, 9, 10},
                              {0, 1, 3, 2}});
}

VtuArrayText field(const char* name, const char* type, std::vector<double> values) {
  VtuArrayText array{name, type, std::move(values), 1, {}};
  array.attributes = " NumberOfTuples=\"" + std::to_string(array.values.size()) + "\"";
  return array;
}

std::vector<VtuStyle> styles() {
  std::vector<VtuStyle> all;
  for (const VtuData data : {VtuData::kAppendedRaw, VtuData::kAppendedBase64, VtuData::kInline}) {
    for (const char* compressor :
         {"", "vtkZLibDataCompressor", "vtkLZ4DataCompressor", "vtkLZMADataCompressor"}) {
      all.push_back({data, compressor, all.size() % 2 == 0 ? "UInt64" : "UInt32",
                     all.size() % 5 == 4, kBlock, "1.0"});
    }
  }
  all.push_back({VtuData::kAscii, "", "UInt64", false, kBlock, "1.0"});
  all.push_back({VtuData::kInline, "", "", true, kBlock, "0.1"});
  return all;
}

// With a length that says so, split and linearized.
std::string with_all_cells(std::string bytes) {
  while (bytes.size() % 4 != 3) bytes += '\n';
  return bytes;
}

std::string join(std::initializer_list<std::string> parts) {
  std::string all;
  for (const std::string& part : parts) {
    if (&part != parts.begin()) all += kCut;
    all += part;
  }
  return all;
}

// What the project's writers make of a small mesh with many arrays.
std::vector<std::string> converted(std::initializer_list<std::pair<const char*, Encoding>> names) {
  const TempDir dir = TempDir::in_memory();
  testing::write_file(dir.file("in.vtu"), to_vtu({{piece(0, false)}, {}}, {}));
  std::vector<std::string> files;
  for (const auto& [name, encoding] : names) {
    const auto source = open_mesh(dir.file("in.vtu"));
    convert_mesh(source.get(), dir.file(name), {encoding, {}});
    files.push_back(testing::bytes_of(dir.file(name)));
  }
  return files;
}

std::string section_file(std::initializer_list<std::string> pieces) {
  std::vector<PieceRef> refs;
  for (const std::string& p : pieces) {
    refs.push_back({static_cast<std::uint32_t>(3 * refs.size()), std::as_bytes(std::span(p))});
  }
  const TempDir dir = TempDir::in_memory();
  testing::write_file(dir.file("a"), "");
  const Descriptor fd(file_system().openat(AT_FDCWD, dir.file("a").c_str(), O_RDWR | O_CLOEXEC, 0));
  write_sections(fd.get(), plan_sections(generation_id("round-1"), 7, refs), refs);
  return testing::bytes_of(dir.file("a"));
}

std::string manifest() {
  const TempDir dir = TempDir::in_memory();
  testing::write_file(dir.file("manifest"), "");
  Manifest log(Descriptor(file_system().openat(AT_FDCWD, dir.file("manifest").c_str(),
                                               O_RDWR | O_CLOEXEC, 0)),
               "manifest");
  log.start("version 1\nreduction 0.9\n");
  log.commit({"round-0", 3, 77, false});
  log.mark_durable("round-0");
  log.commit({"round-1", 4, 78, false});
  return testing::bytes_of(dir.file("manifest"));
}

template <class Real>
std::string state() {
  RunState<Real> s;
  s.mesh.locks = {3, 17};
  s.input.lower.cells = {{5, 1}, {0, 3, 4}, {0, 1, 2, 3}};
  s.input.lower.loose_ids = {1, 2};
  s.fields = {{0, 1, 3.5, {}}, {1, 3, 0.75, 0.01}};
  s.field_names = {"f", "cell:stress"};
  s.rounds.resize(1);
  s.outputs = {{"level_1.vtu", 8, 5, 12, 0.5}};
  const Vector<std::byte> bytes = save(s);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

std::vector<std::string> vtu_seeds() {
  std::vector<std::string> seeds = vtk_seeds();
  for (const VtuStyle& style : styles()) {
    const bool two = seeds.size() % 2 == 1;
    VtuText mesh{{piece(0, two)},
                 {field("TimeValue", "Float64", {0.5}), field("title", "String", {116, 101, 0})}};
    if (two) mesh.pieces.push_back(piece(1, true));
    seeds.push_back(to_vtu(mesh, style));
  }
  seeds.push_back(with_all_cells(to_vtu({{mixed_piece()}, {}}, {})));
  seeds.push_back(with_all_cells(
      to_vtu({{mixed_piece()}, {}}, {VtuData::kAscii, "", "UInt64", false, kBlock, "1.0"})));
  return seeds;
}

std::vector<std::string> vtk_seeds() {
  return converted({{"raw.vtu", Encoding::kRaw},
                    {"zlib.vtu", Encoding::kZlib},
                    {"lz4.vtu", Encoding::kLz4},
                    {"inline.vtu", Encoding::kInline},
                    {"ascii.vtu", Encoding::kAscii}});
}

std::vector<std::string> pvtu_seeds() {
  const std::string pvtu =
      "<VTKFile type=\"PUnstructuredGrid\">\n<PUnstructuredGrid GhostLevel=\"1\">\n<PPoints/>\n"
      "<Piece Source=\"0.vtu\"/>\n<Piece Source=\"1.vtu\"/>\n</PUnstructuredGrid>\n</VTKFile>\n";
  std::vector<std::string> seeds;
  for (const VtuStyle& style :
       {VtuStyle{VtuData::kAscii, "", "UInt64", false, kBlock, "1.0"}, VtuStyle{},
        VtuStyle{VtuData::kInline, "vtkZLibDataCompressor", "UInt32", false, kBlock, "1.0"}}) {
    seeds.push_back(
        join({pvtu, to_vtu({{piece(0, true)}, {}}, style), to_vtu({{piece(1, true)}, {}}, style)}));
  }
  return seeds;
}

std::vector<std::string> pvd_seeds() {
  const auto list = [](const std::string& steps) {
    return "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\"><Collection>" + steps +
           "</Collection></VTKFile>\n";
  };
  return {list("<DataSet timestep=\"0\" file=\"a.vtu\"/><DataSet timestep=\"0.5\" group=\"\" "
               "part=\"0\" file=\"b/c.vtu\"/>"),
          list("<DataSet timestep=\"-1e3\" file=\"../a.vtu\"/>"), list("")};
}

// Those of version 5.1 are ours; the lists of earlier ones are made by hand.
std::vector<std::string> legacy_seeds() {
  std::vector<std::string> seeds =
      converted({{"a.vtk", Encoding::kRaw}, {"b.vtk", Encoding::kAscii}});
  const std::string cells = "CELLS 3 13\n4 0 1 2 3\n3 1 2 3\n4 1 2 3 4\nCELL_TYPES 3\n10 5 10\n";
  const std::string text =
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nFIELD f 1\nw 1 1 string\n"
      "a%20b\nPOINTS 5 int\n0 0 0 1 0 0 0 1 0 0 0 1 1 1 1\n";
  seeds.push_back(
      text + cells +
      "POINT_DATA 5\nCOLOR_SCALARS c 1\n0 .5 1 0 1\nSCALARS s float\nLOOKUP_TABLE t\n"
      "1 2 3 4 5\nLOOKUP_TABLE t 1\n0 0 0 1\nTEXTURE_COORDINATES u 2 double\n1 2 3 4 5 6 7 8 "
      "9 0\nCELL_DATA 3\nFIELD f 1\nvtkGhostType 1 3 unsigned_char\n0 0 1\n");
  std::string binary =
      "# vtk DataFile Version 4.2\nt\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 unsigned_char\n";
  const auto put = [&](std::initializer_list<char> bytes) { binary.append(bytes); };
  put({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
  binary += "\nCELLS 1 5\n";
  for (const char i : {4, 0, 1, 2, 3}) put({0, 0, 0, i});
  binary += "\nCELL_TYPES 1\n";
  put({0, 0, 0, 10});
  binary += "\nPOINT_DATA 4\nSCALARS b bit 1\nLOOKUP_TABLE default\nA\nFIELD f 1\nn 1 4 string\n";
  put({'\xC1', 'a', '\xC0', '\xC0', '\xC1', 'b', '\n'});
  seeds.push_back(binary);
  return seeds;
}

std::vector<std::string> medit_seeds() {
  return converted({{"a.mesh", Encoding::kRaw}, {"a.meshb", Encoding::kRaw}});
}

// Those of version 2.2 are ours; of others text is made by hand.
std::vector<std::string> gmsh_seeds() {
  std::vector<std::string> seeds =
      converted({{"a.msh", Encoding::kRaw}, {"b.msh", Encoding::kAscii}});
  seeds.push_back(
      "$NOD\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n7 1 1 -1\n$ENDNOD\n$ELM\n4\n"
      "1 4 9 5 4 1 2 3 4\n2 4 8 5 4 1 2 3 4\n5 4 9 6 4 7 2 4 3\n6 2 7 3 3 2 3 4\n$ENDELM\n"
      "$PhysicalNames\n3\n9 \"a\"\n7\"b\" c\n3 8 \"d\"\n$EndPhysicalNames\n"
      "$NodeData\n1\nT\n0\n3\n0\n1\n1\n7 1.5\n$EndNodeData\n");
  seeds.push_back(
      "$MeshFormat\n4 0 8\n$EndMeshFormat\n$Entities\n1 0 1 1\n1 0 0 0 0 0 0 1 2\n"
      "3 0 0 0 1 1 1 1 -7 0\n5 0 0 0 1 1 1 2 9 8 1 3\n$EndEntities\n$PartitionedEntities\n1\n"
      "1\n9 1\n1 0 0 1\n2 0 1 1 1 0 0 0 0 0 0 0\n6 3 5 1 1 0 0 0 1 1 1 0 0\n"
      "$EndPartitionedEntities\n$Nodes\n2 5\n5 3 0 3\n1 0 0 0\n2 1 0 0\n7 1 1 -1\n3 2 1 2\n"
      "3 0 1 0 .5 .5\n4 0 0 1 0 0\n$EndNodes\n$Elements\n3 3\n1 0 15 1\n1 2\n5 3 4 1\n"
      "2 1 2 3 4\n6 3 4 1\n3 7 2 4 3\n$EndElements\n");
  return seeds;
}

std::vector<std::string> tetgen_seeds() {
  return {
      join({"# made by hand\n5 3 2 1\n1 0 0 0 1.5 -1 1\n2 1 0 0.1 2.5 -2 0 # the second\n3 0 1 0 "
            "3.5 -3 1\n"
            "4 0 0 1 4.5 -4 1\n5 1 1 -1 5.5 -5 -2\n",
            "2 4 1\n1 1 2 3 4 10\n2 5 2 4 3 20\n# end\n", "1 1\n1 2 3 4 7\n", "1 1\n1 1 2 -8\n"}),
      join({"4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n", "1 4 0\n0 0 1 2 3\n"}),
      join({"10 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n4 .5 0 0\n5 .5 .5 0\n6 0 .5 0\n7 0 0 "
            ".5\n8 .5 0 .5\n"
            "9 0 .5 .5\n",
            "1 10 0\n0 0 1 2 3 4 5 6 7 8 9\n"})};
}

std::vector<std::string> chunk_store_seeds() {
  return {section_file({"a piece", std::string(5000, 'x'), "another"}), section_file({}),
          manifest(), state<float>(), state<double>()};
}

std::vector<std::string> command_seeds() {
  return {
      "simplify\nin.vtu\n-o\nout.vtu\n--reduction\n90%\n--max-error\n0.1%\n--array\nPressure:0.5%"
      "\n--memory\n1G\n"
      "--boundary\n0.5%\n--chunk-tets\n50k\n--threads\n2\n--report\nr.json\n--verify\n--conserve",
      "simplify\nin.vtu\n-o\nout_{lod}.vtu\n--lods\n50%,80%,95%\n--method\ntetfuse\n--scalar-"
      "tolerance\n0.025,off\n"
      "--stretch-factor\n5\n--aspect-ratio\n20\n--regions\nmaterial\n--boundary-rule\ntets\n--"
      "resume\n--dry-run",
      "simplify\n-\n-o\n-\n--tets\n2M\n--lods\n3\n--min-quality\n0.1\n--max-rms\n1%\n--"
      "encoding\nzlib\n--strict",
      "simplify\nin.vtu\n-o\nout.pvtu\n--pieces\n8\n--tetrahedralize\n--linearize\n--"
      "progress\nalways\n--quiet",
      "generate\nfive\n--tets\n10M\n-o\nbig.vtu\n--jitter\n0.3\n--grading\n4\n--seed\n7\n--time\n0."
      "5\n--shuffle\n--double",
      "compare\na.vtu\nb.vtu\n--max-error\n1%\n--max-rms\n1%\n--surface\n0.1%\n--array\nf\n--"
      "report\n-",
      "check\nin.vtu\n--strict\n--memory\n1G\n--scratch\n/tmp\n--report\n-",
      "check\nin.vtu\n--fix\nout.vtu",
      "apply\nrun.map\nin.vtu\n-o\nout.vtu\n--array\nf",
      "simplify\nin.vtu\n-o\nout.vtu\n--progressive\nrun.tfp",
      "simplify\nstep_1.vtu\nstep_2.vtu\n-o\nout_{step}.vtu\n--series\nshared\n--weight\nw",
      "simplify\nrun.pvd\n-o\nout.pvd\n--series\neach\n--array\nf",
      "refine\nrun.tfp\n-o\nout.vtu\n--tets\n10k",
      "simplify\nin.vtu\n-o\nout.vtu\n--map\nrun.map\n--original-ids\n--roi\nbox:0,0,0,1,1,1",
      "info\nin.vtu\n--verbose",
      "convert\nin.vtu\nout.msh\n--encoding\nascii",
      "--version",
      "simplify\n--help"};
}

}  // namespace tetfusion::fuzz
