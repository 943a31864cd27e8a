#include "io/gmsh/gmsh_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <unordered_map>
#include <variant>
#include <vector>

#include "base/blocks.h"
#include "base/error.h"
#include "io/formats/text_rows.h"
#include "io/gmsh/gmsh_head.h"
#include "io/gmsh/gmsh_steps.h"
#include "mesh/regions/region_names.h"
#include "mesh/split_cells.h"
#include "mesh/time_value.h"

namespace tetfusion {

namespace {

constexpr std::size_t kNoArray = MeshPasses::kNone;

int gmsh_type(std::uint8_t vtk) {
  switch (vtk) {
    case kVtkLine:
      return 1;
    case kVtkTriangle:
      return 2;
    case kVtkTetra:
      return 4;
    default:
      return 15;
  }
}

class GmshWriter {
 public:
  GmshWriter(MeshPasses* mesh, OutputFile* file, bool binary, const TellUser& tell)
      : mesh_(*mesh), file_(file), binary_(binary), tell_(tell) {
    const AttributeSet& cells = mesh_.description().cell_data;
    physical_ = mesh_.cell_labels();
    own_physical_ = find_integer_label(cells, kGmshPhysical);
    geometrical_ = find_integer_label(cells, kGmshGeometrical);
  }

  void run(const std::function<void(double)>& progress) {
    check_size();
    const std::size_t point_arrays = mesh_.description().point_data.arrays.size();
    const std::size_t cell_arrays = mesh_.description().cell_data.arrays.size();
    mesh_.expect(
        (1 + passes(mesh_.description().point_data)) * mesh_.points() +
            (1 + passes(mesh_.description().cell_data) + (makes_groups() ? 1 : 0)) * mesh_.tets(),
        progress);
    put_head();
    put_names();
    put_nodes();
    choose_entities();
    put_elements();
    const double time = find_time();
    const auto of_points = gmsh_steps_of(mesh_.description().point_data, time);
    for (std::size_t i = 0; i < point_arrays; ++i) put_node_data(i, of_points[i]);
    const auto of_cells = gmsh_steps_of(mesh_.description().cell_data, time);
    for (std::size_t i = 0; i < cell_arrays; ++i) {
      if (!is_tag(i)) put_element_data(i, of_cells[i]);
    }
  }

 private:
  std::uint64_t cells() const { return mesh_.tets() + mesh_.lower().size(); }

  static std::size_t find_integer_label(const AttributeSet& cells, const char* name) {
    const std::size_t i = cells.find(name);
    return i != kNoArray && is_integer_label(cells.arrays[i]) ? i : kNoArray;
  }
  // Of an array that is none in Gmsh's files.
  bool makes_groups() const { return physical_ != kNoArray && physical_ != own_physical_; }
  // A material that is the physical group stays an array of its own, under its name. Groups whose
  // place it has do not: that name is the one that it is read as.
  bool is_tag(std::size_t index) const { return index == geometrical_ || index == own_physical_; }

  void check_size() const {
    constexpr std::uint64_t kMost = std::numeric_limits<std::int32_t>::max();
    if (mesh_.points() <= kMost && cells() <= kMost) return;
    throw Error(ErrorCode::kUsage,
                fmt::format("a Gmsh file numbers at most {} points and cells; the mesh has {} and "
                            "{}: write a .vtu",
                            kMost, mesh_.points(), cells()));
  }

  template <class T>
  static std::byte* store(T value, std::byte* to) {
    std::memcpy(to, &value, sizeof value);
    return to + sizeof value;
  }

  // f(i, row) fills the `bytes` bytes of each row.
  template <class F>
  void put_binary_rows(std::size_t rows, std::size_t bytes, F f) {
    buffer_.resize(rows * bytes);
    for_each_block(rows, kTextRowsPerBlock, [&](std::size_t, std::size_t from, std::size_t to) {
      for (std::size_t i = from; i < to; ++i) f(i, buffer_.data() + i * bytes);
    });
    file_->append(buffer_.data(), buffer_.size());
  }

  void put_head() {
    put_text(fmt::format("$MeshFormat\n2.2 {} 8\n", binary_ ? 1 : 0), file_);
    if (binary_) {
      const std::int32_t one = 1;
      file_->append(&one, sizeof one);
      put_text("\n", file_);
    }
    put_text("$EndMeshFormat\n", file_);
  }

  static std::string in_quotes(std::string text) {
    std::replace(text.begin(), text.end(), '\n', ' ');
    return fmt::format("\"{}\"", text);
  }

  void put_names() {
    if (own_physical_ != kNoArray && physical_ != own_physical_) return;  // they have other groups
    std::string rows;
    std::size_t count = 0;
    for (std::size_t i = 0; i < mesh_.description().field_data.arrays.size(); ++i) {
      const ArrayInfo& info = mesh_.description().field_data.arrays[i];
      if (!is_gmsh_name(info)) continue;
      const DataArray array = mesh_.read_field(i);
      const Vector<std::int64_t> values = to_integers(info, array.bytes);
      const std::string name = info.name.substr(std::string_view(kGmshNamePrefix).size());
      for (std::size_t k = 0; k + 1 < values.size(); k += 2) {
        rows += fmt::format("{} {} {}\n", values[k + 1], values[k], in_quotes(name));
        ++count;
      }
    }
    if (count > 0) {
      put_text(fmt::format("$PhysicalNames\n{}\n{}$EndPhysicalNames\n", count, rows), file_);
    }
  }

  // 0: there is none.
  double find_time() {
    const AttributeSet& fields = mesh_.description().field_data;
    const std::size_t index = fields.find(kTimeValue);
    if (index == AttributeSet::npos || !is_time_value(fields.arrays[index])) return 0;
    const double time = *time_of(mesh_.read_field(index));
    return std::isfinite(time) ? time : 0;
  }

  void put_nodes() {
    put_text(fmt::format("$Nodes\n{}\n", mesh_.points()), file_);
    mesh_.for_each_points(
        {}, [&](std::uint64_t first, const Points& points, const std::vector<Vector<std::byte>>&) {
          std::visit([&](const auto& xyz) { put_node_window(first, xyz); }, points);
        });
    end_section("Nodes");
  }

  template <class Real>
  void put_node_window(std::uint64_t first, const Vector<Vec3<Real>>& xyz) {
    if (binary_) {
      put_binary_rows(xyz.size(), 4 + 3 * 8, [&](std::size_t i, std::byte* to) {
        to = store(static_cast<std::int32_t>(first + i + 1), to);
        to = store(static_cast<double>(xyz[i].x), to);
        to = store(static_cast<double>(xyz[i].y), to);
        store(static_cast<double>(xyz[i].z), to);
      });
    } else {
      put_text_rows(xyz.size(), file_, [&](std::size_t i, TextRow* row) {
        row->add(first + i + 1);
        row->add(double{xyz[i].x}).add(double{xyz[i].y}).add(double{xyz[i].z});
      });
    }
  }

  void end_section(const char* name) {
    put_text(fmt::format("{}$End{}\n", binary_ ? "\n" : "", name), file_);
  }

  // ---- elements ----

  struct Tags {
    Vector<std::int32_t> physical, geometrical;
  };

  Vector<std::int32_t> tags_of(std::size_t array, std::span<const std::byte> rows,
                               std::size_t count) const {
    Vector<std::int32_t> tags;
    tags.assign(count, 0);
    if (array == kNoArray) return tags;
    const ArrayInfo& info = mesh_.description().cell_data.arrays[array];
    const Vector<std::int64_t> values = to_integers(info, rows);
    for (std::size_t i = 0; i < count; ++i) {
      tags[i] = static_cast<std::int32_t>(values[i]);
      if (tags[i] != values[i]) {
        throw Error(ErrorCode::kBadInput, fmt::format("array \"{}\" has the value {}: a tag of a "
                                                      "Gmsh file has 32 bits; write a .vtu",
                                                      info.name, values[i]));
      }
    }
    return tags;
  }

  Tags both_tags(std::span<const std::byte> physical, std::span<const std::byte> geometrical,
                 std::size_t count) const {
    Tags tags{tags_of(physical_, physical, count), tags_of(entities_, geometrical, count)};
    if (entities_ == kNoArray) {
      for (std::size_t i = 0; i < count; ++i) tags.geometrical[i] = entity_of(tags.physical[i]);
    }
    return tags;
  }

  std::int32_t entity_of(std::int32_t physical) const {
    if (physical > 0) return physical;
    const auto known = entities_of_others_.find(physical);
    return known == entities_of_others_.end() ? 1 : known->second;
  }

  // Gmsh gives all of an entity to each group that an element of it is in, so where groups are made
  // of an array that is none each needs entities of its own, and so does what is in no group.
  void choose_entities() {
    entities_ = geometrical_;
    if (!makes_groups()) return;
    std::unordered_map<std::int32_t, std::int32_t> group_of;
    std::int32_t largest = 0;
    bool are_whole = geometrical_ != kNoArray;
    const auto look = [&](const Tags& tags) {
      for (std::size_t i = 0; i < tags.physical.size(); ++i) {
        const std::int32_t physical = tags.physical[i];
        largest = std::max(largest, physical);
        if (physical <= 0) entities_of_others_.emplace(physical, 0);
        if (!are_whole) continue;
        are_whole = group_of.emplace(tags.geometrical[i], physical).first->second == physical;
      }
    };
    mesh_.for_each_tets({physical_, geometrical_}, [&](std::uint64_t, const Vector<Tet>& tets,
                                                       const std::vector<Vector<std::byte>>& rows) {
      look({tags_of(physical_, rows[0], tets.size()), tags_of(geometrical_, rows[1], tets.size())});
    });
    const std::size_t lower = mesh_.lower().size();
    look({tags_of(physical_, mesh_.lower_rows(physical_), lower),
          tags_of(geometrical_, mesh_.lower_rows(geometrical_), lower)});
    if (!are_whole) entities_ = kNoArray;
    const std::string& name = mesh_.description().cell_data.arrays[physical_].name;
    if (!entities_of_others_.empty() && tell_) {
      tell_(
          fmt::format("cell array {} has values below 1, which are no physical groups in Gmsh: "
                      "cells with these are in none",
                      name));
    }
    for (auto& [physical, entity] : entities_of_others_) {
      if (largest == std::numeric_limits<std::int32_t>::max()) {
        throw Error(ErrorCode::kBadInput,
                    fmt::format("array \"{}\" has the value {}: no tag of a Gmsh file is left for "
                                "cells that are in no group; write a .vtu",
                                name, largest));
      }
      entity = ++largest;
    }
  }

  void put_elements() {
    put_text(fmt::format("$Elements\n{}\n", cells()), file_);
    if (binary_) put_block_head(kVtkTetra, mesh_.tets());
    mesh_.for_each_tets({physical_, entities_}, [&](std::uint64_t first, const Vector<Tet>& tets,
                                                    const std::vector<Vector<std::byte>>& rows) {
      const Tags tags = both_tags(rows[0], rows[1], tets.size());
      put_cells(kVtkTetra, first, tets.size(), tags, [&](std::size_t i) { return tets[i].data(); });
    });
    const Tags tags =
        both_tags(mesh_.lower_rows(physical_), mesh_.lower_rows(entities_), mesh_.lower().size());
    put_lower(tags);
    end_section("Elements");
  }

  void put_block_head(std::uint8_t type, std::uint64_t count) {
    const std::array<std::int32_t, 3> head = {gmsh_type(type), static_cast<std::int32_t>(count), 2};
    file_->append(head.data(), sizeof head);
  }

  // corners(i): those of cell i, from 0.
  template <class Corners>
  void put_cells(std::uint8_t type, std::uint64_t first, std::size_t count, const Tags& tags,
                 Corners corners) {
    const auto width = static_cast<std::size_t>(vtk_cell_size(type));
    if (binary_) {
      put_binary_rows(count, 4 * (3 + width), [&](std::size_t i, std::byte* to) {
        to = store(static_cast<std::int32_t>(first + i + 1), to);
        to = store(tags.physical[i], to);
        to = store(tags.geometrical[i], to);
        for (std::size_t k = 0; k < width; ++k) {
          to = store(static_cast<std::int32_t>(corners(i)[k] + 1), to);
        }
      });
    } else {
      put_text_rows(count, file_, [&](std::size_t i, TextRow* row) {
        row->add(first + i + 1).add(gmsh_type(type)).add(2);
        row->add(tags.physical[i]).add(tags.geometrical[i]);
        for (std::size_t k = 0; k < width; ++k) row->add(corners(i)[k] + 1);
      });
    }
  }

  // Cells of one type after another share the head of a block.
  void put_lower(const Tags& tags) {
    const LowerCells& lower = mesh_.lower();
    for (std::size_t begin = 0; begin < lower.size();) {
      const std::uint8_t type = lower.types[begin];
      std::size_t end = begin + 1;
      while (end < lower.size() && lower.types[end] == type) ++end;
      if (binary_) put_block_head(type, end - begin);
      const auto from = static_cast<std::ptrdiff_t>(begin);
      const auto to = static_cast<std::ptrdiff_t>(end);
      const Tags some{{tags.physical.begin() + from, tags.physical.begin() + to},
                      {tags.geometrical.begin() + from, tags.geometrical.begin() + to}};
      put_cells(type, mesh_.tets() + begin, end - begin, some, [&](std::size_t i) {
        return lower.connectivity.data() + lower.offsets[begin + i];
      });
      begin = end;
    }
  }

  // ---- arrays ----

  void begin_data(const char* section, const ArrayInfo& info, const GmshStep& step,
                  std::uint64_t rows) {
    // A quote ends the name for Gmsh. Names of groups have it nevertheless, as Gmsh writes them.
    std::string name = step.name;
    std::replace(name.begin(), name.end(), '"', '\'');
    put_text(fmt::format("${}\n1\n{}\n1\n{}\n3\n{}\n{}\n{}\n", section, in_quotes(name), step.time,
                         step.number, info.components, rows),
             file_);
  }

  // Rows without a number are read where a file has no value, and Gmsh's own files have none for
  // these: they are not written. How many are is said before, so that arrays of floating-point
  // numbers are gone through twice.
  static std::size_t passes(const AttributeSet& set) {
    std::size_t all = 0;
    for (const ArrayInfo& info : set.arrays) all += is_float(info.type) ? 2 : 1;
    return all;
  }

  static Vector<std::uint32_t> rows_with_numbers(const ArrayInfo& info,
                                                 const Vector<double>& values) {
    const std::size_t width = info.components;
    Vector<std::uint32_t> rows;
    for (std::size_t i = 0; i < values.size() / width; ++i) {
      const double* const row = values.data() + i * width;
      const auto is_number = [](double value) { return !std::isnan(value); };
      if (std::any_of(row, row + width, is_number)) rows.push_back(static_cast<std::uint32_t>(i));
    }
    return rows;
  }

  void put_values(const ArrayInfo& info, std::uint64_t first, std::span<const std::byte> bytes) {
    const Vector<double> values = to_doubles(info.type, bytes);
    const Vector<std::uint32_t> rows = rows_with_numbers(info, values);
    const std::size_t width = info.components;
    if (binary_) {
      put_binary_rows(rows.size(), 4 + 8 * width, [&](std::size_t i, std::byte* to) {
        to = store(static_cast<std::int32_t>(first + rows[i] + 1), to);
        std::memcpy(to, values.data() + rows[i] * width, 8 * width);
      });
    } else {
      put_text_rows(rows.size(), file_, [&](std::size_t i, TextRow* row) {
        row->add(first + rows[i] + 1);
        for (std::size_t k = 0; k < width; ++k) row->add(values[rows[i] * width + k]);
      });
    }
  }

  void put_node_data(std::size_t index, const GmshStep& step) {
    const ArrayInfo& info = mesh_.description().point_data.arrays[index];
    const auto for_each_rows = [&](auto f) { mesh_.for_each_point_rows(index, f); };
    put_data("NodeData", info, step, mesh_.points(), for_each_rows);
  }

  void put_element_data(std::size_t index, const GmshStep& step) {
    const ArrayInfo& info = mesh_.description().cell_data.arrays[index];
    const auto for_each_rows = [&](auto f) {
      mesh_.for_each_tets({index},
                          [&](std::uint64_t first, const Vector<Tet>&,
                              const std::vector<Vector<std::byte>>& rows) { f(first, rows[0]); });
      f(mesh_.tets(), mesh_.lower_rows(index));
    };
    put_data("ElementData", info, step, cells(), for_each_rows);
  }

  // for_each_rows(f) calls f(first, rows) for windows of the array.
  template <class ForEachRows>
  void put_data(const char* section, const ArrayInfo& info, const GmshStep& step,
                std::uint64_t rows, ForEachRows for_each_rows) {
    if (is_float(info.type)) {
      rows = 0;
      for_each_rows([&](std::uint64_t, const Vector<std::byte>& bytes) {
        rows += rows_with_numbers(info, to_doubles(info.type, bytes)).size();
      });
    }
    begin_data(section, info, step, rows);
    for_each_rows([&](std::uint64_t first, const Vector<std::byte>& bytes) {
      put_values(info, first, bytes);
    });
    end_section(section);
  }

  MeshPasses& mesh_;
  OutputFile* file_;
  bool binary_;
  std::size_t physical_ = kNoArray;
  std::size_t own_physical_ = kNoArray;  // the groups that the mesh was read with
  std::size_t geometrical_ = kNoArray;
  std::size_t entities_ = kNoArray;  // that array, or none where it goes with other groups
  std::map<std::int32_t, std::int32_t> entities_of_others_;  // by values that are no groups
  const TellUser& tell_;
  Vector<std::byte> buffer_;
};

}  // namespace

void write_gmsh(MeshPasses* mesh, OutputFile* file, bool binary,
                const std::function<void(double)>& progress, const TellUser& tell) {
  GmshWriter(mesh, file, binary, tell).run(progress);
}

bool is_gmsh_name(const ArrayInfo& field) {
  const bool has_pairs = field.values() == 2 || (field.values() > 0 && field.components == 2);
  return field.name.starts_with(kGmshNamePrefix) && has_pairs && !is_float(field.type) &&
         field.type != ValueType::kString;
}

}  // namespace tetfusion
