#include "io/source/chosen_patches.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/name_list.h"
#include "base/numbers.h"
#include "io/source/stream_around.h"
#include "io/source/stream_windows.h"

namespace tetfusion {

namespace {

constexpr std::string_view kBlocks = "block", kBlockNames = "block_names";
// Of Exodus, whose blocks have numbers of their own.
constexpr std::string_view kObjectIds = "ObjectId", kBlockIds = "ElementBlockIds";

// Of each cell array, by its place: the values that are left out, and the patch that each is.
using Values = std::map<std::size_t, std::map<double, std::size_t>>;

// The file's names of blocks, and what cells of each have in a cell array.
struct NamedBlocks {
  std::size_t array = AttributeSet::npos;
  std::vector<std::string> names;
  Vector<double> values;
};

NamedBlocks named_blocks(MeshSource* mesh) {
  const AttributeSet& cell_data = mesh->description().cell_data;
  NamedBlocks blocks;
  for (const DataArray& array : mesh->read_field_data()) {
    if (array.info.name == kBlockNames) blocks.names = texts_of(array);
    if (array.info.name == kBlockIds) blocks.values = to_doubles(array.info.type, array.bytes);
  }
  blocks.array = cell_data.find(kBlocks);
  if (blocks.array != AttributeSet::npos) {
    blocks.values.resize(blocks.names.size());
    std::iota(blocks.values.begin(), blocks.values.end(), 0.0);
  } else {
    blocks.array = cell_data.find(kObjectIds);
  }
  if (blocks.array == AttributeSet::npos || blocks.values.size() != blocks.names.size()) return {};
  return blocks;
}

[[noreturn]] void refuse(const std::string& patch, const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 20;
  throw Error(ErrorCode::kUsage,
              fmt::format("--drop-patch {}: {}; of a cell array of numbers give ARRAY=VALUE, as in "
                          "block=2",
                          patch,
                          names.empty()
                              ? "the mesh has no named blocks"
                              : "there is no block of that name, but " + list_names(names, kMost)));
}

// Of "block=2".
std::optional<std::pair<std::size_t, double>> value_of_array(const std::string& patch,
                                                             const AttributeSet& cell_data) {
  const std::size_t sign = patch.rfind('=');
  if (sign == std::string::npos) return std::nullopt;
  const std::size_t index = cell_data.find(std::string_view(patch).substr(0, sign));
  const auto value = parse_number(std::string_view(patch).substr(sign + 1));
  if (index == AttributeSet::npos || !value) return std::nullopt;
  if (cell_data.arrays[index].components != 1) return std::nullopt;
  return std::pair(index, *value);
}

Values find_values(MeshSource* mesh, const std::vector<std::string>& patches) {
  const AttributeSet& cell_data = mesh->description().cell_data;
  const NamedBlocks blocks = named_blocks(mesh);
  Values values;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const auto name = std::ranges::find(blocks.names, patches[i]);
    if (name != blocks.names.end()) {
      const double value = blocks.values[static_cast<std::size_t>(name - blocks.names.begin())];
      values[blocks.array].emplace(value, i);
    } else if (const auto given = value_of_array(patches[i], cell_data)) {
      values[given->first].emplace(given->second, i);
    } else {
      refuse(patches[i], blocks.names);
    }
  }
  return values;
}

// Cells of lower dimension, row i of them rows[i], or i if there are none.
class LowerCellsToSift {
 public:
  LowerCellsToSift(LowerCells* cells, Vector<std::uint64_t>* rows)
      : cells_(*cells), rows_(*rows), dropped_(cells->size(), 0) {}

  // Drops those that have one of the values in the array, of which these are the rows from that one
  // on. Adds their patches to `met`.
  void drop(const ArrayInfo& info, std::uint64_t first, std::span<const std::byte> rows,
            const std::map<double, std::size_t>& values, std::set<std::size_t>* met) {
    visit_type(info.type, [&](auto zero) {
      const auto* of_cells = reinterpret_cast<const decltype(zero)*>(rows.data());
      for (std::uint64_t i = 0; i < cells_.size(); ++i) {
        const auto value = values.find(static_cast<double>(of_cells[row(i) - first]));
        if (value == values.end()) continue;
        dropped_[i] = 1;
        met->insert(value->second);
      }
    });
  }

  void keep_others() {
    LowerCells kept;
    Vector<std::uint64_t> kept_rows;
    for (std::uint64_t i = 0; i < cells_.size(); ++i) {
      if (dropped_[i] != 0) continue;
      kept.add(cells_.types[i], cells_.corners(i));
      kept_rows.push_back(row(i));
    }
    cells_ = std::move(kept);
    rows_ = std::move(kept_rows);
  }

 private:
  std::uint64_t row(std::uint64_t i) const { return rows_.empty() ? i : rows_[i]; }

  LowerCells& cells_;
  Vector<std::uint64_t>& rows_;
  Vector<std::uint8_t> dropped_;
};

void read_other_cells(const MeshStream& mesh, const AttributeSet& cell_data, const Values& values,
                      std::uint64_t first, std::uint64_t count, CellWindow* out,
                      std::set<std::size_t>* met) {
  mesh.read_cells(first, count, out);
  if (out->lower.size() == 0) return;
  LowerCellsToSift cells(&out->lower, &out->lower_rows);
  Vector<std::byte> rows;
  for (const auto& [index, of_array] : values) {
    const ArrayInfo& info = cell_data.arrays[index];
    rows.resize(count * info.row_bytes());
    mesh.read_rows(Association::kCell, index, first, count, rows);
    cells.drop(info, first, rows, of_array, met);
  }
  cells.keep_others();
}

class StreamWithoutPatches final : public StreamAround {
 public:
  StreamWithoutPatches(std::unique_ptr<MeshStream> mesh, const AttributeSet& cell_data,
                       const Values& values, LowerCount count)
      : StreamAround(std::move(mesh)), cell_data_(cell_data), values_(values), count_(count) {}

  LowerCount lower_cells() const override { return count_; }

  void read_cells(std::uint64_t first, std::uint64_t count, CellWindow* out) const override {
    std::set<std::size_t> met;
    read_other_cells(inner(), cell_data_, values_, first, count, out, &met);
  }

 private:
  const AttributeSet& cell_data_;
  const Values& values_;
  const LowerCount count_;
};

class MeshWithoutPatches final : public MeshSource {
 public:
  MeshWithoutPatches(std::unique_ptr<MeshSource> mesh, std::vector<std::string> patches)
      : mesh_(std::move(mesh)),
        patches_(std::move(patches)),
        values_(find_values(mesh_.get(), patches_)) {
    if (const auto stream = mesh_->stream()) count(*stream);
  }

  const MeshDescription& description() const override { return mesh_->description(); }

  Geometry read_geometry() override {
    Geometry geometry = mesh_->read_geometry();
    std::set<std::size_t> met;
    if (geometry.lower.size() > 0) {
      LowerCellsToSift cells(&geometry.lower, &geometry.lower_source);
      for (const auto& [index, values] : values_) {
        const DataArray array = mesh_->read_array(Association::kCell, index);
        cells.drop(array.info, 0, array.bytes, values, &met);
      }
      cells.keep_others();
    }
    refuse_unmet(met);
    return geometry;
  }

  DataArray read_array(Association association, std::size_t index) override {
    return mesh_->read_array(association, index);
  }
  std::unique_ptr<MeshStream> stream() override {
    auto inner = mesh_->stream();
    if (!inner) return nullptr;
    return std::make_unique<StreamWithoutPatches>(std::move(inner), description().cell_data,
                                                  values_, count_);
  }
  std::unique_ptr<MeshStream> stream_of_rows() override { return mesh_->stream_of_rows(); }
  std::uint64_t memory_to_read() override { return mesh_->memory_to_read(); }

 private:
  // What is left of them, which each stream is asked for anyway.
  void count(const MeshStream& stream) {
    std::set<std::size_t> met;
    CellWindow window;
    if (stream.lower_cells().cells > 0) {
      for_each_window(stream.cells(), RunContext(), [&](std::uint64_t first, std::uint64_t n) {
        read_other_cells(stream, description().cell_data, values_, first, n, &window, &met);
        count_.cells += window.lower.size();
        count_.corners += window.lower.connectivity.size();
      });
    }
    refuse_unmet(met);
  }

  // Hardly meant: the boundary would stay where it was to move.
  void refuse_unmet(const std::set<std::size_t>& met) const {
    for (const auto& [index, of_array] : values_) {
      for (const auto& [value, patch] : of_array) {
        if (met.contains(patch)) continue;
        throw Error(ErrorCode::kUsage,
                    fmt::format("--drop-patch {}: no triangle, line or point of the mesh has that",
                                patches_[patch]));
      }
    }
  }

  const std::unique_ptr<MeshSource> mesh_;
  const std::vector<std::string> patches_;
  const Values values_;
  LowerCount count_;
};

}  // namespace

std::unique_ptr<MeshSource> without_patches(std::unique_ptr<MeshSource> mesh,
                                            const std::vector<std::string>& patches) {
  return std::make_unique<MeshWithoutPatches>(std::move(mesh), patches);
}

}  // namespace tetfusion
