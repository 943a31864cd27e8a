#include "io/gmsh/gmsh_reader.h"

#include <algorithm>
#include <bitset>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/name_list.h"
#include "io/files/guarded_reading.h"
#include "io/formats/format_file.h"
#include "io/formats/format_source.h"
#include "io/gmsh/gmsh_head.h"
#include "io/gmsh/gmsh_mesh.h"
#include "io/gmsh/gmsh_rows.h"
#include "io/gmsh/gmsh_steps.h"
#include "mesh/time_value.h"

namespace tetfusion {

namespace {

enum CellArray : std::size_t { kPhysical, kGeometrical, kFirstData };

class GmshReader final : public FormatReader {
 public:
  explicit GmshReader(MappedFile file) : file_{std::move(file)} {
    read_guarded(file_.file, [&] {
      head_ = parse_gmsh_head(file_);
      complete_names();
    });
    describe();
  }

  const MeshDescription& description() const override { return description_; }

  CellTypeCounts cell_types() const override { return mesh().cell_types(); }
  std::uint64_t bytes() const override { return mesh().bytes(); }

  bool has_rows_in_order() const override {
    const auto in_order = [](const auto& of) {
      return std::all_of(of.begin(), of.end(),
                         [](const GmshRows& rows) { return rows.in_order(); });
    };
    return in_order(rows_of(Association::kPoint)) && in_order(rows_of(Association::kCell));
  }

  void read_points(std::uint64_t first, std::uint64_t count, std::byte* out) const override {
    read_guarded(file_.file,
                 [&] { mesh().read_points(first, count, reinterpret_cast<Vec3<double>*>(out)); });
  }

  ListedCells read_cells(std::uint64_t first, std::uint64_t count) const override {
    ListedCells cells;
    read_guarded(file_.file, [&] { cells = mesh().read_cells(first, count); });
    return cells;
  }

  void read_rows(Association association, std::size_t index, std::uint64_t first,
                 std::uint64_t count, std::byte* out) const override {
    const bool of_points = association == Association::kPoint;
    read_guarded(file_.file, [&] {
      if (!of_points && index < kFirstData) {
        mesh().read_tags(index == kPhysical, first, count, reinterpret_cast<std::int32_t*>(out));
      } else {
        rows_of(association)[of_points ? index : index - kFirstData].read(
            first, count, reinterpret_cast<double*>(out));
      }
    });
  }

  DataArray read_field(std::size_t index) const override {
    DataArray array;
    array.info = description_.field_data.arrays.at(index);
    array.bytes.resize(array.info.bytes());
    if (array.info.name == kTimeValue) {
      array.as<double>()[0] = *time_.time;
      return array;
    }
    auto values = array.as<std::int32_t>().begin();
    for (const GmshName* name : groups_.at(index)) {
      *values++ = name->tag;
      *values++ = name->dimension;
    }
    return array;
  }

 private:
  // A name without a dimension goes with the groups of that tag, whatever dimension they have.
  void complete_names() {
    GmshDimensions of_tags;
    for (const GmshName& name : head_.names) {
      if (name.dimension == GmshName::kNoDimension) of_tags[name.tag];
    }
    if (of_tags.empty()) return;
    find_dimensions(file_, head_, &of_tags);
    std::vector<GmshName> names;
    std::vector<std::string> without;
    for (const GmshName& name : head_.names) {
      if (name.dimension != GmshName::kNoDimension) {
        names.push_back(name);
        continue;
      }
      const std::bitset<4>& dimensions = of_tags[name.tag];
      for (int d = 0; d < 4; ++d) {
        if (dimensions[static_cast<std::size_t>(d)]) names.push_back({d, name.tag, name.name});
      }
      if (dimensions.none()) without.push_back(name.name);
    }
    head_.names = std::move(names);
    if (without.empty()) return;
    constexpr std::size_t kMost = 8;
    head_.left_out.push_back((without.size() == 1 ? "the name " : "the names ") +
                             list_names(without, kMost) + " of what has no elements");
  }

  void describe() {
    MeshDescription& d = description_;
    d.path = file_.file.path();
    d.format = "Gmsh mesh, " + head_.version + (head_.binary ? ", binary" : ", text");
    d.left_out = head_.left_out;
    d.points = head_.node_count;
    d.cells = head_.element_count;
    if (!head_.is_4) describe_elements();
    d.point_type = ValueType::kFloat64;
    d.file_bytes = file_.file.size();
    d.spooled_checksum = file_.file.spooled_checksum();
    for (const char* name : {kGmshPhysical, kGmshGeometrical}) {
      d.cell_data.arrays.push_back({name, ValueType::kInt32, 1, {}, d.cells});
    }
    add_arrays(head_.node_data, d.points, &d.point_data);
    add_arrays(head_.element_data, d.cells, &d.cell_data);
    describe_groups();
    time_ = gmsh_time_of(head_);
    if (time_.time) d.field_data.arrays.push_back({kTimeValue, ValueType::kFloat64, 1, {}, 1});
    if (!time_.left_out.empty()) d.left_out.push_back(time_.left_out);
    if (d.cells == 0) file_.fail("the mesh has no cells");
    if (d.points > kMaxPoints) {
      file_.fail(ErrorCode::kMemory,
                 std::to_string(d.points) + " points are more than can be held in memory at once");
    }
  }

  // What elements of versions 1 and 2 say themselves.
  void describe_elements() {
    description_.cells = mesh().element_count();
    if (mesh().has_partitions()) description_.left_out.emplace_back(kGmshPartitions);
    const std::string lost = mesh().groups().left_out(head_.names);
    if (!lost.empty()) description_.left_out.push_back(lost);
  }

  // Groups of several dimensions may have one name: a row for each.
  void describe_groups() {
    std::vector<ArrayInfo>& fields = description_.field_data.arrays;
    std::map<std::string_view, std::size_t> known;
    for (const GmshName& name : head_.names) {
      const auto [found, is_new] = known.emplace(name.name, fields.size());
      if (is_new) {
        fields.push_back({kGmshNamePrefix + name.name, ValueType::kInt32, 2, {}, 0});
        groups_.emplace_back();
      }
      ++fields[found->second].tuples;
      groups_[found->second].push_back(&name);
    }
  }

  // A file may have one name several times.
  static std::string unused(const std::string& name, const AttributeSet& set) {
    std::string free = name;
    for (int i = 2; set.find(free) != AttributeSet::npos; ++i) {
      free = name + " " + std::to_string(i);
    }
    return free;
  }

  static void add_arrays(const std::vector<GmshData>& all, std::uint64_t tuples,
                         AttributeSet* set) {
    const std::vector<std::string> names = gmsh_array_names(all);
    for (std::size_t i = 0; i < all.size(); ++i) {
      set->arrays.push_back({unused(names[i], *set),
                             ValueType::kFloat64,
                             static_cast<std::uint32_t>(all[i].components),
                             {},
                             tuples});
    }
  }

  // Made when it is first asked for: that goes through the whole file. Of versions 1 and 2 it says
  // what there is, too, and is made at once.
  const GmshMesh& mesh() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!mesh_) {
      read_guarded(file_.file, [&] { mesh_ = std::make_unique<const GmshMesh>(file_, head_); });
    }
    return *mesh_;
  }
  const std::vector<GmshRows>& rows_of(Association association) const {
    const GmshMesh& all = mesh();
    const bool of_points = association == Association::kPoint;
    const std::lock_guard<std::mutex> lock(mutex_);
    std::optional<std::vector<GmshRows>>& rows = of_points ? point_rows_ : cell_rows_;
    if (!rows) {
      std::vector<GmshRows> made;
      read_guarded(file_.file, [&] {
        for (const GmshData& data : of_points ? head_.node_data : head_.element_data) {
          made.emplace_back(file_, head_, data, of_points ? all.nodes() : all.elements(),
                            of_points ? head_.node_count : all.element_count());
        }
      });
      rows = std::move(made);
    }
    return *rows;
  }

  FormatFile file_;
  GmshHead head_;
  GmshTime time_;
  MeshDescription description_;
  std::vector<std::vector<const GmshName*>> groups_;  // of each field array that is one of names
  mutable std::mutex mutex_;
  mutable std::unique_ptr<const GmshMesh> mesh_;
  mutable std::optional<std::vector<GmshRows>> point_rows_, cell_rows_;
};

}  // namespace

std::unique_ptr<MeshSource> open_gmsh(MappedFile file, const OpenOptions& options) {
  return make_source(std::make_unique<GmshReader>(std::move(file)), options);
}

}  // namespace tetfusion
