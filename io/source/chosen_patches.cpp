#include "io/source/chosen_patches.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <mutex>
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

// Of each cell array, by its place: the values that are left out.
using Values = std::map<std::size_t, std::set<double>>;

std::vector<std::string> block_names(MeshSource* mesh) {
  std::vector<std::string> names;
  for (const DataArray& array : mesh->read_field_data()) {
    if (array.info.name == kBlockNames) names = texts_of(array);
  }
  return names;
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
  const std::size_t blocks = cell_data.find(kBlocks);
  std::vector<std::string> names;
  if (blocks != AttributeSet::npos) names = block_names(mesh);
  Values values;
  for (const std::string& patch : patches) {
    const auto name = std::ranges::find(names, patch);
    if (name != names.end()) {
      values[blocks].insert(static_cast<double>(name - names.begin()));
    } else if (const auto given = value_of_array(patch, cell_data)) {
      values[given->first].insert(given->second);
    } else {
      refuse(patch, names);
    }
  }
  return values;
}

// Sets dropped[i] where the row has one of the values.
void mark_rows(const ArrayInfo& info, std::span<const std::byte> rows,
               const std::set<double>& values, Vector<std::uint8_t>* dropped) {
  visit_type(info.type, [&](auto zero) {
    const auto* of_cells = reinterpret_cast<const decltype(zero)*>(rows.data());
    for (std::size_t i = 0; i < dropped->size(); ++i) {
      if (values.contains(static_cast<double>(of_cells[i]))) (*dropped)[i] = 1;
    }
  });
}

// Those cells alone whose row is not dropped; row i is dropped[row - first].
void keep_others(const Vector<std::uint8_t>& dropped, std::uint64_t first, LowerCells* lower,
                 Vector<std::uint64_t>* rows) {
  LowerCells kept;
  Vector<std::uint64_t> kept_rows;
  for (std::uint64_t i = 0; i < lower->size(); ++i) {
    const std::uint64_t row = rows->empty() ? i : (*rows)[i];
    if (dropped[row - first] != 0) continue;
    kept.add(lower->types[i], lower->corners(i));
    kept_rows.push_back(row);
  }
  *lower = std::move(kept);
  *rows = std::move(kept_rows);
}

class StreamWithoutPatches final : public StreamAround {
 public:
  StreamWithoutPatches(std::unique_ptr<MeshStream> mesh, const AttributeSet& cell_data,
                       const Values& values)
      : StreamAround(std::move(mesh)), cell_data_(cell_data), values_(values) {}

  // Counted when somebody asks first.
  LowerCount lower_cells() const override {
    std::call_once(counted_, [&] {
      if (inner().lower_cells().cells == 0) return;
      CellWindow window;
      for_each_window(cells(), RunContext(), [&](std::uint64_t first, std::uint64_t count) {
        read_cells(first, count, &window);
        count_.cells += window.lower.size();
        count_.corners += window.lower.connectivity.size();
      });
    });
    return count_;
  }

  void read_cells(std::uint64_t first, std::uint64_t count, CellWindow* out) const override {
    inner().read_cells(first, count, out);
    if (out->lower.size() == 0) return;
    Vector<std::uint8_t> dropped(count, 0);
    Vector<std::byte> rows;
    for (const auto& [index, values] : values_) {
      const ArrayInfo& info = cell_data_.arrays[index];
      rows.resize(count * info.row_bytes());
      inner().read_rows(Association::kCell, index, first, count, rows);
      mark_rows(info, rows, values, &dropped);
    }
    keep_others(dropped, first, &out->lower, &out->lower_rows);
  }

 private:
  const AttributeSet& cell_data_;
  const Values& values_;
  mutable std::once_flag counted_;
  mutable LowerCount count_;
};

class MeshWithoutPatches final : public MeshSource {
 public:
  MeshWithoutPatches(std::unique_ptr<MeshSource> mesh, Values values)
      : mesh_(std::move(mesh)), values_(std::move(values)) {}

  const MeshDescription& description() const override { return mesh_->description(); }

  Geometry read_geometry() override {
    Geometry geometry = mesh_->read_geometry();
    if (geometry.lower.size() == 0) return geometry;
    Vector<std::uint8_t> dropped(description().cells, 0);
    for (const auto& [index, values] : values_) {
      const DataArray array = mesh_->read_array(Association::kCell, index);
      dropped.resize(array.info.tuples, 0);
      mark_rows(array.info, array.bytes, values, &dropped);
    }
    keep_others(dropped, 0, &geometry.lower, &geometry.lower_source);
    return geometry;
  }

  DataArray read_array(Association association, std::size_t index) override {
    return mesh_->read_array(association, index);
  }
  std::unique_ptr<MeshStream> stream() override {
    auto inner = mesh_->stream();
    if (!inner) return nullptr;
    return std::make_unique<StreamWithoutPatches>(std::move(inner), description().cell_data,
                                                  values_);
  }
  std::unique_ptr<MeshStream> stream_of_rows() override { return mesh_->stream_of_rows(); }
  std::optional<std::uint64_t> mesh_checksum(const RunContext& context) override {
    return mesh_->mesh_checksum(context);
  }
  std::uint64_t memory_to_read() override { return mesh_->memory_to_read(); }

 private:
  const std::unique_ptr<MeshSource> mesh_;
  const Values values_;
};

}  // namespace

std::unique_ptr<MeshSource> without_patches(std::unique_ptr<MeshSource> mesh,
                                            const std::vector<std::string>& patches) {
  Values values = find_values(mesh.get(), patches);
  return std::make_unique<MeshWithoutPatches>(std::move(mesh), std::move(values));
}

}  // namespace tetfusion
