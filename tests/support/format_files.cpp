#include "support/format_files.h"

#include <fmt/format.h>

#include <fstream>
#include <span>
#include <variant>

#include "io/open_mesh.h"
#include "io/write_mesh.h"
#include "support/stream_check.h"

namespace tetfusion::testing {

namespace {

void dump_array(const char* of, const DataArray& array, std::string* text) {
  *text += fmt::format("{} {} {} x {}:", of, array.info.name, vtk_name(array.info.type),
                       array.info.components);
  visit_type(array.info.type, [&](auto zero) {
    for (const auto value : array.as<decltype(zero)>()) *text += fmt::format(" {}", value);
  });
  *text += "\n";
}

}  // namespace

std::string replaced(std::string text, std::string_view from, std::string_view to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << "the text holds no " << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::string dump(MeshSource* source) {
  const Geometry mesh = source->read_geometry();
  std::string text;
  std::visit(
      [&](const auto& points) {
        text += sizeof(points[0].x) == 4 ? "float\n" : "double\n";
        for (const auto& p : points) text += fmt::format("{} {} {}\n", p.x, p.y, p.z);
      },
      mesh.points);
  for (const Tet& t : mesh.tets) {
    text += fmt::format("tet {} {} {} {}\n", t[0], t[1], t[2], t[3]);
  }
  for (std::size_t c = 0; c < mesh.lower.size(); ++c) {
    text += fmt::format("type {}:", mesh.lower.types[c]);
    for (std::uint64_t k = mesh.lower.offsets[c]; k < mesh.lower.offsets[c + 1]; ++k) {
      text += fmt::format(" {}", mesh.lower.connectivity[k]);
    }
    text += "\n";
  }
  const auto rows = [&](const char* name, const Vector<std::uint64_t>& of) {
    text += name;
    for (const std::uint64_t row : of) text += fmt::format(" {}", row);
    text += "\n";
  };
  rows("points", mesh.point_source);
  rows("tets", mesh.tet_source);
  rows("lower", mesh.lower_source);
  const MeshDescription& d = source->description();
  const auto arrays = [&](const char* of, Association association, const AttributeSet& set) {
    for (std::size_t i = 0; i < set.arrays.size(); ++i) {
      dump_array(of, source->read_array(association, i), &text);
    }
  };
  arrays("point", Association::kPoint, d.point_data);
  arrays("cell", Association::kCell, d.cell_data);
  arrays("field", Association::kField, d.field_data);
  return text;
}

void FormatTest::write(const std::string& name, const std::string& bytes) {
  std::ofstream out(dir_.file(name), std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  ASSERT_TRUE(out.good());
}

std::unique_ptr<MeshSource> FormatTest::open(const std::string& name, const std::string& bytes,
                                             const OpenOptions& options) {
  write(name, bytes);
  return open_mesh(dir_.file(name), options);
}

std::unique_ptr<MeshSource> FormatTest::open_and_compare(const std::string& name,
                                                         const std::string& bytes,
                                                         const OpenOptions& options) {
  write(name, bytes);
  expect_windows_like_whole(dir_.file(name), options, false);
  return open_mesh(dir_.file(name), options);
}

void FormatTest::expect_error(const std::string& name, const std::string& bytes,
                              const std::string& words, int code, const OpenOptions& options) {
  try {
    dump(open_and_compare(name, bytes, options).get());
    ADD_FAILURE() << "no error, expected: " << words;
  } catch (const Error& e) {
    const std::string message = e.what();
    EXPECT_EQ(e.exit_code(), code) << message;
    EXPECT_NE(message.find(dir_.path().string()), std::string::npos) << message;
    EXPECT_NE(message.find(words), std::string::npos) << message << "\nexpected: " << words;
  }
}

std::string FormatTest::read_or_refuse(const std::string& name, const std::string& bytes) {
  try {
    return dump(open(name, bytes, {true, true}).get());
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find(dir_.path().string()), std::string::npos) << e.what();
    return {};
  }
}

void FormatTest::expect_no_half_mesh(const std::string& name, const std::string& bytes) {
  const std::string whole = read_or_refuse(name, bytes);
  ASSERT_FALSE(whole.empty());
  for (std::size_t end = 0; end < bytes.size(); ++end) {
    const std::string found = read_or_refuse(name, bytes.substr(0, end));
    ASSERT_TRUE(found.empty() || found == whole) << "cut at byte " << end << ":\n" << found;
  }
}

void FormatTest::expect_no_crash(const std::string& name, const std::string& bytes) {
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (const int flip : {0x01, 0x10, 0x80, 0xFF}) {
      std::string other = bytes;
      other[i] = static_cast<char>(other[i] ^ flip);
      read_or_refuse(name, other);
    }
  }
}

void FormatTest::expect_sample(const Geometry& mesh) {
  std::vector<double> coordinates;
  for (const auto& p : std::get<Vector<Vec3<double>>>(mesh.points)) {
    coordinates.insert(coordinates.end(), {p.x, p.y, p.z});
  }
  EXPECT_EQ(coordinates, (std::vector<double>{0, 0, 0, 1, 0, 0.1, 0, 1, 0, 0, 0, 1, 1, 1, -1}));
  EXPECT_EQ(mesh.tets, (Vector<Tet>{{0, 1, 2, 3}, {4, 1, 3, 2}}));
}

void FormatTest::convert(MeshSource* source, const std::string& name) {
  write_mesh(source, dir_.file(name), {});
}

}  // namespace tetfusion::testing
