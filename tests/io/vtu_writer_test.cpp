#include "io/vtk/vtu_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "base/error.h"
#include "base/resources.h"
#include "io/formats/xml_text.h"
#include "io/mesh_format.h"
#include "io/open_mesh.h"
#include "io/source/mesh_sink.h"
#include "io/source/mesh_source.h"
#include "io/vtk/encode.h"
#include "support/mesh_file.h"
#include "support/meshes.h"
#include "support/temp_dir.h"
#include "support/write_mesh.h"

namespace tetfusion {
namespace {

using testing::bytes_of;
using ::testing::HasSubstr;
using testing::OutputMesh;
using testing::TempDir;

template <class T>
DataArray make_array(const std::string& name, std::uint32_t components,
                     const std::vector<T>& values) {
  DataArray array{{name, value_type_of<T>(), components, {}, values.size() / components}, {}};
  const auto bytes = std::as_bytes(std::span(values));
  array.bytes.assign(bytes.begin(), bytes.end());
  return array;
}

// A mesh with its arrays in memory, ready to be written.
struct Sample {
  Geometry mesh;
  std::map<Association, std::vector<DataArray>> arrays;
  std::map<Association, std::map<std::string, std::string>> active;

  AttributeSet attributes(Association association) {
    AttributeSet set;
    for (const DataArray& a : arrays[association]) set.arrays.push_back(a.info);
    set.active = active[association];
    return set;
  }
  OutputMesh output() {
    return {&mesh.points,
            &mesh.tets,
            &mesh.lower,
            attributes(Association::kPoint),
            attributes(Association::kCell),
            attributes(Association::kField),
            [this](Association a, std::size_t i) { return arrays[a][i]; }};
  }
};

template <class T>
std::vector<T> extremes(std::size_t count) {
  using Limits = std::numeric_limits<T>;
  std::vector<T> values{Limits::lowest(), Limits::max(), Limits::min(), T{0}, T{1}};
  if constexpr (std::is_floating_point_v<T>) {
    values.insert(values.end(), {Limits::denorm_min(), Limits::infinity(), -Limits::infinity(),
                                 Limits::quiet_NaN(), T(-0.0), T(0.1), T(1) / T(3)});
  }
  for (std::size_t i = values.size(); i < count; ++i) values.push_back(static_cast<T>(i % 100));
  values.resize(count);
  return values;
}

template <class T>
void add_extremes(Sample* sample, Association association, std::size_t tuples) {
  const std::string name(vtk_name(value_type_of<T>()));
  sample->arrays[association].push_back(make_array(name, 1, extremes<T>(tuples)));
}

Sample make_sample() {
  Sample s;
  s.mesh = testing::five_split_cube(2, 0.1);
  s.mesh.lower.types = {5, 3, 1};
  s.mesh.lower.offsets = {0, 3, 5, 6};
  s.mesh.lower.connectivity = {0, 1, 3, 7, 8, 26};
  const std::size_t points = point_count(s.mesh.points);
  const std::size_t cells = s.mesh.tets.size() + 3;
  for (const auto& [association, tuples] :
       {std::pair(Association::kPoint, points), std::pair(Association::kCell, cells)}) {
    add_extremes<std::int8_t>(&s, association, tuples);
    add_extremes<std::uint8_t>(&s, association, tuples);
    add_extremes<std::int16_t>(&s, association, tuples);
    add_extremes<std::uint16_t>(&s, association, tuples);
    add_extremes<std::int32_t>(&s, association, tuples);
    add_extremes<std::uint32_t>(&s, association, tuples);
    add_extremes<std::int64_t>(&s, association, tuples);
    add_extremes<std::uint64_t>(&s, association, tuples);
    add_extremes<float>(&s, association, tuples);
    add_extremes<double>(&s, association, tuples);
    DataArray vectors = make_array("a <b> & \"c\"\n\xC3\xA4", 3, extremes<float>(3 * tuples));
    vectors.info.component_names = {"X", "", "<Z>"};
    vectors.info.units = "\xC2\xB5m <&>\n\"s\"";
    s.arrays[association].push_back(vectors);
    s.active[association] = {{"Scalars", "Float64"}, {"Vectors", vectors.info.name}};
  }
  DataArray strings{{"titles", ValueType::kString, 1, {}, 3}, {}};
  const std::string text("first\0\0t\xC3\xA9tra\0", 14);
  const auto bytes = std::as_bytes(std::span(text));
  strings.bytes.assign(bytes.begin(), bytes.end());
  s.arrays[Association::kField] = {strings, make_array<double>("TimeValue", 1, {0.1}),
                                   make_array<std::int32_t>("nothing", 1, {})};
  for (DataArray& array : s.arrays[Association::kField]) array.info.units = "s";
  return s;
}

void expect_same_info(const ArrayInfo& a, const ArrayInfo& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.type, b.type) << a.name;
  EXPECT_EQ(a.components, b.components) << a.name;
  EXPECT_EQ(a.component_names, b.component_names) << a.name;
  EXPECT_EQ(a.units, b.units) << a.name;
  EXPECT_EQ(a.tuples, b.tuples) << a.name;
}

// Bit for bit, but a NaN may have other bits.
bool same_values(const DataArray& a, const DataArray& b) {
  if (a.bytes.size() != b.bytes.size()) return false;
  return visit_type(a.info.type, [&](auto zero) {
    using T = decltype(zero);
    const auto x = a.as<T>(), y = b.as<T>();
    return std::equal(x.begin(), x.end(), y.begin(), [](T p, T q) {
      if constexpr (std::is_floating_point_v<T>) {
        if (std::isnan(p)) return std::isnan(q);
      }
      return std::memcmp(&p, &q, sizeof(T)) == 0;
    });
  });
}

void expect_same_arrays(Sample* sample, Association association, const AttributeSet& read,
                        MeshSource* source) {
  const auto& written = sample->arrays[association];
  ASSERT_EQ(read.arrays.size(), written.size());
  for (std::size_t i = 0; i < written.size(); ++i) {
    expect_same_info(read.arrays[i], written[i].info);
    const DataArray values = source->read_array(association, i);
    EXPECT_TRUE(same_values(values, written[i])) << written[i].info.name;
  }
  EXPECT_EQ(read.active, sample->active[association]);
}

template <class Range>
std::vector<std::byte> bytes_of(const Range& range) {
  const auto bytes = std::as_bytes(std::span(range));
  return {bytes.begin(), bytes.end()};
}

void expect_same_mesh(Sample* sample, MeshSource* source) {
  const MeshDescription& d = source->description();
  expect_same_arrays(sample, Association::kPoint, d.point_data, source);
  expect_same_arrays(sample, Association::kCell, d.cell_data, source);
  expect_same_arrays(sample, Association::kField, d.field_data, source);
  const Geometry read = source->read_geometry();
  ASSERT_EQ(read.points.index(), sample->mesh.points.index());
  EXPECT_EQ(std::visit([](const auto& p) { return bytes_of(p); }, read.points),
            std::visit([](const auto& p) { return bytes_of(p); }, sample->mesh.points));
  EXPECT_EQ(read.tets, sample->mesh.tets);
  EXPECT_EQ(read.lower.types, sample->mesh.lower.types);
  EXPECT_EQ(read.lower.offsets, sample->mesh.lower.offsets);
  EXPECT_EQ(read.lower.connectivity, sample->mesh.lower.connectivity);
}

class WriteMesh : public ::testing::TestWithParam<Encoding> {};

TEST_P(WriteMesh, ReadsBackTheSame) {
  const TempDir dir;
  Sample sample = make_sample();
  write_mesh(sample.output(), dir.file("a.vtu"), {GetParam(), {}});
  expect_same_mesh(&sample, open_mesh(dir.file("a.vtu")).get());
}

TEST_P(WriteMesh, ReadsBackTheSameInFloat32) {
  const TempDir dir;
  Sample sample;
  sample.mesh = testing::to_float(testing::icosahedron_ball());
  write_mesh(sample.output(), dir.file("a.VTU"), {GetParam(), {}});
  expect_same_mesh(&sample, open_mesh(dir.file("a.VTU")).get());
}

// More than one batch of the encoders, and a size that is a multiple of nothing.
TEST_P(WriteMesh, ReadsBackALargeArray) {
  const TempDir dir;
  Sample sample;
  sample.mesh = testing::single_tet();
  std::vector<float> values(5'000'011);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i % 1000) * 0.25f;
  sample.arrays[Association::kField] = {make_array("large", 1, values)};
  write_mesh(sample.output(), dir.file("a.vtu"), {GetParam(), {}});
  expect_same_mesh(&sample, open_mesh(dir.file("a.vtu")).get());
}

TEST_P(WriteMesh, GivesTheSameBytesForAnyNumberOfThreads) {
  const TempDir dir;
  Sample sample = make_sample();
  sample.mesh = testing::five_split_cube(30);
  sample.arrays.clear();
  sample.active.clear();
  std::vector<std::string> files;
  for (const int threads : {1, 2, 3}) {
    set_thread_count(threads);
    write_mesh(sample.output(), dir.file("a.vtu"), {GetParam(), {}});
    files.push_back(bytes_of(dir.file("a.vtu")));
  }
  set_thread_count(0);
  EXPECT_TRUE(files[0] == files[1]);
  EXPECT_TRUE(files[0] == files[2]);
}

TEST_P(WriteMesh, ReportsProgressUpToOne) {
  const TempDir dir;
  Sample sample = make_sample();
  std::vector<double> shares;
  write_mesh(sample.output(), dir.file("a.vtu"),
             {GetParam(), [&](double s) { shares.push_back(s); }});
  ASSERT_FALSE(shares.empty());
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_GT(shares.front(), 0);
  EXPECT_EQ(shares.back(), 1);
}

TEST_P(WriteMesh, LeavesNothingWhenItIsInterrupted) {
  const TempDir dir;
  Sample sample = make_sample();
  const auto interrupt = [](double) { throw Error(ErrorCode::kInterrupted, "stop"); };
  EXPECT_THROW(write_mesh(sample.output(), dir.file("a.vtu"), {GetParam(), interrupt}), Error);
  EXPECT_TRUE(std::filesystem::is_empty(dir.path()));
}

TEST_P(WriteMesh, DoesNotDependOnTheSizesOfRuns) {
  const TempDir dir;
  VtuLayout layout;
  layout.points = 100'003;
  layout.point_data.arrays = {{"a", ValueType::kInt16, 1, {}, 0}};
  layout.encoding = GetParam();
  std::vector<std::int16_t> values(layout.points);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<std::int16_t>(i * i);
  const std::vector<float> points(3 * layout.points, 0.5f);
  std::vector<std::string> files;
  set_thread_count(1);  // whose batches are smaller than the arrays
  for (const std::size_t run : {std::size_t{1} << 20, std::size_t{2}, std::size_t{2006}}) {
    OutputFile file(dir.file("a.vtu"), VtuWriter::access(layout.encoding));
    VtuWriter writer(&file, layout);
    for (const auto& bytes : {std::as_bytes(std::span(values)), std::as_bytes(std::span(points))}) {
      for (std::size_t i = 0; i < bytes.size(); i += run) {
        writer.put(bytes.subspan(i, std::min(run, bytes.size() - i)));
      }
    }
    writer.finish();
    file.commit();
    files.push_back(bytes_of(dir.file("a.vtu")));
  }
  set_thread_count(0);
  EXPECT_TRUE(files[0] == files[1]);
  EXPECT_TRUE(files[0] == files[2]);
}

TEST_P(WriteMesh, WritesAnEmptyMesh) {
  const TempDir dir;
  VtuLayout layout;
  layout.point_data.arrays = {{"a", ValueType::kFloat32, 1, {}, 0}};
  layout.encoding = GetParam();
  OutputFile file(dir.file("a.vtu"), VtuWriter::access(layout.encoding));
  VtuWriter writer(&file, layout);
  EXPECT_EQ(writer.current(), nullptr);
  writer.finish();
  file.commit();
  const std::string text = bytes_of(dir.file("a.vtu"));
  EXPECT_THAT(text, HasSubstr("NumberOfPoints=\"0\" NumberOfCells=\"0\""));
  EXPECT_TRUE(text.ends_with("</VTKFile>\n"));
}

std::string encoding_name(const ::testing::TestParamInfo<Encoding>& test) {
  constexpr std::array kNames{"Raw", "Zlib", "Lz4", "Inline", "Ascii"};
  return kNames[static_cast<std::size_t>(test.param)];
}
INSTANTIATE_TEST_SUITE_P(All, WriteMesh,
                         ::testing::Values(Encoding::kRaw, Encoding::kZlib, Encoding::kLz4,
                                           Encoding::kInline, Encoding::kAscii),
                         encoding_name);

TEST(VtuWriter, NamesTheArraysInTheOrderOfTheFile) {
  const TempDir dir;
  VtuLayout layout;
  layout.points = 4;
  layout.cells = 1;
  layout.corners = 4;
  layout.point_data.arrays = {{"p", ValueType::kFloat64, 2, {}, 0}};
  layout.cell_data.arrays = {{"c", ValueType::kInt8, 1, {}, 0}};
  OutputFile file(dir.file("a.vtu"));
  VtuWriter writer(&file, layout);
  std::vector<std::string> names;
  while (writer.current() != nullptr) {
    const ArrayInfo info = *writer.current();
    names.push_back(info.name);
    writer.put(std::vector<std::byte>(info.values() * size_of(info.type)));
  }
  EXPECT_THAT(names,
              ::testing::ElementsAre("p", "c", "Points", "connectivity", "offsets", "types"));
}

TEST(VtuWriter, RefusesWhatWasNotDeclared) {
  const TempDir dir;
  VtuLayout layout;
  layout.points = 2;
  OutputFile file(dir.file("a.vtu"));
  VtuWriter writer(&file, layout);
  EXPECT_THROW(writer.put(std::vector<std::byte>(25)), std::logic_error);
  EXPECT_THROW(writer.put_computed<double>([](auto, auto, auto) {}), std::logic_error);
  EXPECT_THROW(writer.finish(), std::logic_error);
}

TEST(MeshSink, RefusesOtherFormats) {
  const TempDir dir;
  for (const char* name : {"a.vts", "a", "vtu", "a.vtu.gz"}) {
    try {
      check_mesh_output(dir.file(name));
      ADD_FAILURE() << name;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kUsage);
      EXPECT_THAT(e.what(), HasSubstr(".vtu"));
    }
  }
  check_mesh_output("-");
  check_mesh_output("/dev/null");
  check_mesh_output(dir.file("a.Vtu"));
}

TEST(VtuWriter, LeavesOutMarkersOfArraysThatAreNotThere) {
  const TempDir dir;
  Sample sample;
  sample.mesh = testing::single_tet();
  sample.active[Association::kPoint] = {{"Scalars", "gone"}};
  write_mesh(sample.output(), dir.file("a.vtu"));
  EXPECT_TRUE(open_mesh(dir.file("a.vtu"))->description().point_data.active.empty());
}

std::string base64(const std::string& text) {
  Vector<char> out;
  base64_encode(std::as_bytes(std::span(text)), &out);
  return {out.begin(), out.end()};
}

class Compress : public ::testing::TestWithParam<Compression> {
 protected:
  Compress() : values_(4'000'003) {  // several batches, and a bit
    for (std::size_t i = 0; i < values_.size(); ++i) {
      values_[i] = static_cast<std::uint32_t>(i * i >> 7);
    }
  }
  ~Compress() override { set_thread_count(0); }
  void compress(const BlockCompressor::Sink& sink) {
    BlockCompressor(GetParam()).compress(std::as_bytes(std::span(values_)), sink);
  }

 private:
  std::vector<std::uint32_t> values_;
};

TEST_P(Compress, HandsOnTheSameBlocksInOrderFromAnyNumberOfThreads) {
  std::vector<std::vector<std::string>> blocks;
  for (const int threads : {1, 2, 5}) {
    set_thread_count(threads);
    auto& of_run = blocks.emplace_back();
    compress([&](std::span<const std::byte> block) {
      of_run.emplace_back(reinterpret_cast<const char*>(block.data()), block.size());
    });
  }
  const std::size_t size = BlockCompressor(GetParam()).block_bytes();
  EXPECT_EQ(blocks[0].size(), (16'000'012 + size - 1) / size);
  EXPECT_TRUE(blocks[0] == blocks[1]);
  EXPECT_TRUE(blocks[0] == blocks[2]);
}

TEST_P(Compress, AsksASinkThatHasFailedNoMore) {
  for (const int threads : {1, 3}) {
    set_thread_count(threads);
    int calls = 0;
    EXPECT_THROW(compress([&](std::span<const std::byte>) {
                   if (++calls == 3) throw Error(ErrorCode::kIo, "full");
                 }),
                 Error);
    EXPECT_EQ(calls, 3);
  }
}

// Leaves these numbers where the next call's local variables will be.
[[gnu::noinline]] void fill_stack(std::uint16_t number) {
  std::array<std::uint16_t, 200'000> numbers;
  numbers.fill(number);
  asm volatile("" : : "m"(numbers));  // somebody may look at them
}

TEST_P(Compress, DoesNotDependOnWhatWasInMemory) {
  set_thread_count(1);
  // What repeats is 4 KiB away.
  std::vector<std::uint32_t> values(16'384);
  std::uint32_t x = 1;
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = i < 1024 ? (x = x * 1'664'525 + 1'013'904'223) : values[i - 1024];
  }
  std::set<std::string> results;
  for (const std::uint16_t number : {0, 1, 9, 12, 15}) {
    fill_stack(number);
    BlockCompressor(GetParam())
        .compress(std::as_bytes(std::span(values)), [&](std::span<const std::byte> block) {
          results.emplace(reinterpret_cast<const char*>(block.data()), block.size());
        });
  }
  EXPECT_EQ(results.size(), 1u);
}

// Bytes that end where what follows cannot be read, all the same: matches would go on.
TEST_P(Compress, ReadsNothingBeyondTheEnd) {
  set_thread_count(1);
  const std::size_t pages = std::size_t{1} << 20;
  void* const mapped =
      ::mmap(nullptr, pages + (1 << 16), PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(mapped, MAP_FAILED);
  ASSERT_EQ(::mprotect(mapped, pages, PROT_READ | PROT_WRITE), 0);
  const std::span all(static_cast<std::byte*>(mapped), pages);
  for (const std::size_t size : {std::size_t{1}, std::size_t{300}, std::size_t{5001}, pages - 3}) {
    std::size_t compressed = 0;
    BlockCompressor(GetParam()).compress(all.last(size), [&](std::span<const std::byte> block) {
      compressed += block.size();
    });
    EXPECT_GT(compressed, 0u) << size;
  }
  ::munmap(mapped, pages + (1 << 16));
}

INSTANTIATE_TEST_SUITE_P(All, Compress, ::testing::Values(Compression::kZlib, Compression::kLz4));

// RFC 4648, section 10.
TEST(Encode, Base64) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xFB\xFF\xBF"), "+/+/");
}

template <class T>
std::string text_of(const std::vector<T>& values, TextPosition position) {
  Vector<char> out;
  text_encode(value_type_of<T>(), std::as_bytes(std::span(values)), position, &out);
  return {out.begin(), out.end()};
}

TEST(Encode, ShortestText) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(text_of<float>({0.1f, -0.0f, std::nanf(""), -std::nanf(""), kInf, -kInf}, {0, 1}),
            "0.1 -0 nan nan inf -inf ");
  EXPECT_EQ(text_of<double>({1.0 / 3, 1e300, 5e-324}, {0, 1}), "0.3333333333333333 1e+300 5e-324 ");
  EXPECT_EQ(text_of<std::int8_t>({-128, 127}, {0, 1}), "-128 127 ");
  EXPECT_EQ(text_of<std::uint64_t>({0xFFFFFFFFFFFFFFFFu}, {0, 1}), "18446744073709551615 ");
}

TEST(Encode, WholeTuplesALine) {
  EXPECT_EQ(text_of<std::int32_t>({1, 2, 3, 4}, {10, 1}), "1 2\n3 4 ");
  EXPECT_EQ(text_of<std::int32_t>({1, 2, 3, 4}, {8, 5}), "1 2\n3 4 ");
  EXPECT_EQ(text_of<std::int32_t>({1, 2, 3}, {18, 20}), "1 2\n3 ");
}

TEST(Encode, Legible) {
  EXPECT_EQ(legible("a<b> \xC3\xA4 \xE2\x82\xAC 50%"), "a<b> \xC3\xA4 \xE2\x82\xAC 50%");
  EXPECT_EQ(legible("h\xE9, \xB0\x43, \xC3\xA9\xE9"), "h\xC3\xA9, \xC2\xB0\x43, \xC3\xA9\xC3\xA9");
  EXPECT_EQ(legible("\x1B[31m\n\t\x7F\xC2\x9B\x9B"), "%1B[31m\n\t%7F%9B%9B");
  EXPECT_TRUE(is_xml_text(legible("\xFF\xFE\x01\xED\xA0\x80\xEF\xBF\xBF")));
}

TEST(Encode, XmlEscape) {
  EXPECT_EQ(xml_escape("a<b>&\"c'"), "a&lt;b&gt;&amp;&quot;c'");
  EXPECT_EQ(xml_escape("tab\tline\n"), "tab&#9;line&#10;");
  EXPECT_EQ(xml_escape("\xC3\xA4 \xE2\x82\xAC \xF0\x9F\x98\x80"),
            "\xC3\xA4 \xE2\x82\xAC \xF0\x9F\x98\x80");
  EXPECT_EQ(xml_escape(std::string("\x01\0x", 3)), "??x");
  EXPECT_EQ(for_message("a<b> \xC3\xA4 \xE2\x82\xAC"), "a<b> \xC3\xA4 \xE2\x82\xAC");
  EXPECT_EQ(for_message("tab\t \x1B[2J \x7F \xC2\x9B \xC3"), "tab? ?[2J ? ? ?");
  EXPECT_FALSE(is_xml_text("what? \x01"));
  EXPECT_TRUE(is_xml_text("what? & <\xC3\xA4>"));
  EXPECT_EQ(xml_escape("\xE4q \xC3"), "?q ?");               // not UTF-8
  EXPECT_EQ(xml_escape("\xC0\x80 \xED\xA0\x80"), "?? ???");  // overlong, surrogate
}

}  // namespace
}  // namespace tetfusion
