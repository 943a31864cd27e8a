#include "io/medit/medit_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/blocks.h"
#include "io/formats/text_rows.h"
#include "io/medit/medit_head.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kSmallFile = std::uint64_t{1} << 31;  // places have 32 bits, with sign

bool fits(const Vector<std::int64_t>& values) {
  return std::all_of(values.begin(), values.end(), [](std::int64_t value) {
    return value >= std::numeric_limits<std::int32_t>::min() &&
           value <= std::numeric_limits<std::int32_t>::max();
  });
}

// The cells of lower dimension that one keyword has.
struct LowerSection {
  const MeditKeyword* keyword;
  Vector<std::uint64_t> cells;
};

class MeditWriter {
 public:
  MeditWriter(MeshPasses* mesh, OutputFile* file, bool binary)
      : mesh_(*mesh), file_(file), binary_(binary) {
    const MeshDescription& d = mesh_.description();
    point_array_ = find_point_labels(d.point_data, kMeditReference);
    cell_array_ = mesh_.cell_labels();
    for (const char* name : {"Triangles", "Edges", "RequiredVertices"}) {
      const MeditKeyword* const keyword = find_medit_keyword(std::string_view(name));
      Vector<std::uint64_t> cells = mesh_.lower_of_type(keyword->type);
      if (!cells.empty()) lower_.push_back({keyword, std::move(cells)});
    }
  }

  void run(const std::function<void(double)>& progress) {
    const bool point_pass = is_long(mesh_.description().point_data, point_array_);
    const bool cell_pass = is_long(mesh_.description().cell_data, cell_array_);
    mesh_.expect((point_pass ? 2 : 1) * mesh_.points() + (cell_pass ? 2 : 1) * mesh_.tets(),
                 progress);
    lower_references_ = integers(mesh_.description().cell_data, cell_array_,
                                 mesh_.lower_rows(cell_array_), mesh_.lower().size());
    choose_version(point_pass, cell_pass);
    begin();
    put_points();
    put_tets();
    for (const LowerSection& section : lower_) put_lower(section);
    end();
  }

 private:
  static bool is_long(const AttributeSet& set, std::size_t array) {
    return array != MeshPasses::kNone && size_of(set.arrays[array].type) >= 4 &&
           set.arrays[array].type != ValueType::kInt32;
  }

  static Vector<std::int64_t> integers(const AttributeSet& set, std::size_t array,
                                       std::span<const std::byte> rows, std::size_t count) {
    if (array != MeshPasses::kNone) return to_integers(set.arrays[array], rows);
    return Vector<std::int64_t>(count, 0);
  }
  Vector<std::int64_t> point_references(std::span<const std::byte> rows, std::size_t count) const {
    return integers(mesh_.description().point_data, point_array_, rows, count);
  }
  Vector<std::int64_t> cell_references(std::span<const std::byte> rows, std::size_t count) const {
    return integers(mesh_.description().cell_data, cell_array_, rows, count);
  }

  void choose_version(bool look_at_points, bool look_at_cells) {
    bool small = fits(lower_references_) &&
                 mesh_.points() <= std::uint64_t{std::numeric_limits<std::int32_t>::max()};
    if (look_at_points) {
      mesh_.for_each_point_rows(point_array_, [&](std::uint64_t, const Vector<std::byte>& rows) {
        small = small && fits(point_references(rows, 0));
      });
    }
    if (look_at_cells) {
      mesh_.for_each_tets({cell_array_}, [&](std::uint64_t, const Vector<Tet>&,
                                             const std::vector<Vector<std::byte>>& rows) {
        small = small && fits(cell_references(rows[0], 0));
      });
    }
    head_.binary = binary_;
    head_.version = mesh_.description().point_type == ValueType::kFloat32 ? 1 : 2;
    if (!small) {
      head_.version = 4;
    } else if (binary_ && size() >= kSmallFile) {
      head_.version = 3;
    }
  }

  // ---- what holds the rows ----

  std::size_t place_bytes() const { return head_.version >= 3 ? 8 : 4; }
  std::uint64_t section_bytes(const MeditKeyword& keyword, std::uint64_t rows) const {
    return 4 + place_bytes() + head_.integer_bytes() + rows * head_.row_bytes(keyword);
  }
  // Of the binary file.
  std::uint64_t size() const {
    std::uint64_t bytes = 8 + (4 + place_bytes() + 4) + (4 + place_bytes());
    bytes += section_bytes(*find_medit_keyword("Vertices"), mesh_.points());
    bytes += section_bytes(*find_medit_keyword("Tetrahedra"), mesh_.tets());
    for (const LowerSection& section : lower_) {
      bytes += section_bytes(*section.keyword, section.cells.size());
    }
    return bytes;
  }

  template <class T>
  void put_value(T value) {
    file_->append(&value, sizeof value);
  }
  void put_integer(std::int64_t value) {
    if (head_.long_integers()) {
      put_value(value);
    } else {
      put_value(static_cast<std::int32_t>(value));
    }
  }
  void put_place(std::uint64_t place) {
    if (place_bytes() == 8) {
      put_value(place);
    } else {
      put_value(static_cast<std::uint32_t>(place));
    }
  }

  void begin() {
    if (!binary_) {
      put_text(fmt::format("MeshVersionFormatted {}\n\nDimension 3\n", head_.version), file_);
      return;
    }
    file_->expect(size());
    put_value(std::int32_t{1});
    put_value(static_cast<std::int32_t>(head_.version));
    put_value(std::int32_t{3});
    put_place(file_->size() + place_bytes() + 4);
    put_value(std::int32_t{3});
  }

  void begin_section(const MeditKeyword& keyword, std::uint64_t rows) {
    if (!binary_) {
      put_text(fmt::format("\n{}\n{}\n", keyword.name, rows), file_);
      return;
    }
    const std::uint64_t next = file_->size() + section_bytes(keyword, rows);
    put_value(static_cast<std::int32_t>(keyword.number));
    put_place(next);
    put_integer(static_cast<std::int64_t>(rows));
  }

  void end() {
    if (!binary_) {
      put_text("\nEnd\n", file_);
      return;
    }
    put_value(std::int32_t{54});
    put_place(0);
  }

  // ---- rows ----

  // The bytes of `rows` rows; f(i, row) fills each.
  template <class F>
  void put_binary_rows(const MeditKeyword& keyword, std::size_t rows, F f) {
    const std::size_t bytes = head_.row_bytes(keyword);
    buffer_.resize(rows * bytes);
    for_each_block(rows, kTextRowsPerBlock, [&](std::size_t, std::size_t from, std::size_t to) {
      for (std::size_t i = from; i < to; ++i) f(i, buffer_.data() + i * bytes);
    });
    file_->append(buffer_.data(), buffer_.size());
  }

  std::byte* store(std::int64_t value, std::byte* to) const {
    const auto low = static_cast<std::int32_t>(value);
    if (head_.long_integers()) {
      std::memcpy(to, &value, sizeof value);
    } else {
      std::memcpy(to, &low, sizeof low);
    }
    return to + head_.integer_bytes();
  }

  template <class Real, class From>
  static std::byte* store_point(const Vec3<From>& p, std::byte* to) {
    const std::array<Real, 3> xyz = {static_cast<Real>(p.x), static_cast<Real>(p.y),
                                     static_cast<Real>(p.z)};
    std::memcpy(to, xyz.data(), sizeof xyz);
    return to + sizeof xyz;
  }

  void put_points() {
    const MeditKeyword& keyword = *find_medit_keyword("Vertices");
    begin_section(keyword, mesh_.points());
    mesh_.for_each_points({point_array_}, [&](std::uint64_t, const Points& points,
                                              const std::vector<Vector<std::byte>>& rows) {
      std::visit(
          [&](const auto& xyz) {
            const Vector<std::int64_t> references = point_references(rows[0], xyz.size());
            if (binary_) {
              put_binary_rows(keyword, xyz.size(), [&](std::size_t i, std::byte* to) {
                to = head_.float_coordinates() ? store_point<float>(xyz[i], to)
                                               : store_point<double>(xyz[i], to);
                store(references[i], to);
              });
            } else {
              put_text_rows(xyz.size(), file_, [&](std::size_t i, TextRow* row) {
                for (const auto x : {xyz[i].x, xyz[i].y, xyz[i].z}) {
                  head_.float_coordinates() ? row->add(x) : row->add(double{x});
                }
                row->add(references[i]);
              });
            }
          },
          points);
    });
  }

  // corner(i, k) is that corner of cell i, from 0; reference(i) its reference.
  template <class Corner, class Reference>
  void put_cells(const MeditKeyword& keyword, std::size_t cells, Corner corner,
                 Reference reference) {
    const auto corners = static_cast<std::size_t>(vtk_cell_size(keyword.type));
    const bool has_reference = keyword.role == MeditKeyword::Role::kCells;
    if (binary_) {
      put_binary_rows(keyword, cells, [&](std::size_t i, std::byte* to) {
        for (std::size_t k = 0; k < corners; ++k) to = store(std::int64_t{corner(i, k)} + 1, to);
        if (has_reference) store(reference(i), to);
      });
    } else {
      put_text_rows(cells, file_, [&](std::size_t i, TextRow* row) {
        for (std::size_t k = 0; k < corners; ++k) row->add(std::int64_t{corner(i, k)} + 1);
        if (has_reference) row->add(reference(i));
      });
    }
  }

  void put_tets() {
    const MeditKeyword& keyword = *find_medit_keyword("Tetrahedra");
    begin_section(keyword, mesh_.tets());
    mesh_.for_each_tets({cell_array_}, [&](std::uint64_t, const Vector<Tet>& tets,
                                           const std::vector<Vector<std::byte>>& rows) {
      const Vector<std::int64_t> references = cell_references(rows[0], tets.size());
      put_cells(
          keyword, tets.size(), [&](std::size_t i, std::size_t k) { return tets[i][k]; },
          [&](std::size_t i) { return references[i]; });
    });
  }

  void put_lower(const LowerSection& section) {
    begin_section(*section.keyword, section.cells.size());
    const LowerCells& lower = mesh_.lower();
    put_cells(
        *section.keyword, section.cells.size(),
        [&](std::size_t i, std::size_t k) {
          return lower.connectivity[lower.offsets[section.cells[i]] + k];
        },
        [&](std::size_t i) { return lower_references_[section.cells[i]]; });
  }

  MeshPasses& mesh_;
  OutputFile* file_;
  bool binary_;
  MeditHead head_;
  std::size_t point_array_ = MeshPasses::kNone;
  std::size_t cell_array_ = MeshPasses::kNone;
  std::vector<LowerSection> lower_;
  Vector<std::int64_t> lower_references_;
  Vector<std::byte> buffer_;
};

}  // namespace

void write_medit(MeshPasses* mesh, OutputFile* file, bool binary,
                 const std::function<void(double)>& progress) {
  MeditWriter(mesh, file, binary).run(progress);
}

}  // namespace tetfusion
