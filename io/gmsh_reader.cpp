#include "io/gmsh_reader.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "io/format_file.h"
#include "io/format_source.h"
#include "io/gmsh_head.h"
#include "io/gmsh_mesh.h"
#include "io/guarded_reading.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

enum CellArray : std::size_t { kPhysical, kGeometrical, kFirstData };

class GmshReader final : public FormatReader {
 public:
  explicit GmshReader(MappedFile file) : file_{std::move(file)} {
    read_guarded(file_.file, [&] { head_ = parse_gmsh_head(file_); });
    describe();
  }

  const MeshDescription& description() const override { return description_; }

  // What they are is not known before they are read.
  CellTypeCounts cell_types() const override {
    CellTypeCounts counts{};
    counts[kVtkTetra] = description_.cells;
    return counts;
  }
  // Numbers and tags of elements, numbers of nodes, and what they are looked up in.
  std::uint64_t memory_beside() const override {
    return 56 * description_.points + 64 * description_.cells;
  }

  Points read_points() const override {
    Points points;
    read_guarded(file_.file, [&] {
      GmshNodes nodes = read_gmsh_nodes(file_, head_);
      points = std::move(nodes.points);
      keep(std::move(nodes.places));
    });
    return points;
  }

  ListedCells read_cells() const override {
    ListedCells cells;
    read_guarded(file_.file, [&] {
      GmshElements elements = read_gmsh_elements(file_, head_, *node_places());
      cells = std::move(elements.cells);
      keep(std::move(elements));
    });
    return cells;
  }

  DataArray read_array(Association association, std::size_t index) const override {
    DataArray array;
    if (association == Association::kField) return name_array(index);
    const bool of_points = association == Association::kPoint;
    array.info = (of_points ? description_.point_data : description_.cell_data).arrays.at(index);
    array.bytes.resize(array.info.values() * size_of(array.info.type));
    read_guarded(file_.file, [&] {
      if (of_points) {
        fill(head_.node_data[index], *node_places(), &array);
      } else if (index < kFirstData) {
        const auto kept = element_tags();
        const Vector<std::int32_t>& tags = index == kPhysical ? kept->physical : kept->geometrical;
        std::copy(tags.begin(), tags.end(), array.as<std::int32_t>().begin());
      } else {
        fill(head_.element_data[index - kFirstData], element_tags()->places, &array);
      }
    });
    return array;
  }

 private:
  void describe() {
    MeshDescription& d = description_;
    d.path = file_.file.path();
    d.format = "Gmsh mesh, " + head_.version + (head_.binary ? ", binary" : ", text");
    for (std::size_t i = 0; i < head_.left_out.size(); ++i) {
      d.format += (i == 0 ? "; left out: " : ", ") + head_.left_out[i];
    }
    d.points = head_.node_count;
    d.cells = head_.element_count;
    d.point_type = ValueType::kFloat64;
    d.file_bytes = file_.file.size();
    d.spooled_checksum = file_.file.spooled_checksum();
    for (const char* name : {kGmshPhysical, kGmshGeometrical}) {
      d.cell_data.arrays.push_back({name, ValueType::kInt32, 1, {}, d.cells});
    }
    for (const GmshData& data : head_.node_data) add_array(data, d.points, &d.point_data);
    for (const GmshData& data : head_.element_data) add_array(data, d.cells, &d.cell_data);
    for (const GmshName& name : head_.names) {
      const std::string unique = unused(kGmshNamePrefix + name.name, d.field_data);
      d.field_data.arrays.push_back({unique, ValueType::kInt32, 2, {}, 1});
    }
    if (d.cells == 0) file_.fail("the mesh has no cells");
    if (d.points > kMaxPoints) {
      file_.fail(ErrorCode::kMemory,
                 std::to_string(d.points) + " points are more than can be held in memory at once");
    }
  }

  // A file may have one array at several times: each has a name of its own.
  static std::string unused(const std::string& name, const AttributeSet& set) {
    std::string free = name;
    for (int i = 2; set.find(free) != AttributeSet::npos; ++i) {
      free = name + " " + std::to_string(i);
    }
    return free;
  }

  static void add_array(const GmshData& data, std::uint64_t tuples, AttributeSet* set) {
    set->arrays.push_back({unused(data.name, *set),
                           ValueType::kFloat64,
                           static_cast<std::uint32_t>(data.components),
                           {},
                           tuples});
  }

  DataArray name_array(std::size_t index) const {
    DataArray array;
    array.info = description_.field_data.arrays.at(index);
    array.bytes.resize(2 * sizeof(std::int32_t));
    array.as<std::int32_t>()[0] = head_.names[index].tag;
    array.as<std::int32_t>()[1] = head_.names[index].dimension;
    return array;
  }

  // What arrays need of nodes and elements is kept, so that these are not gone through again for
  // each of them.
  struct ElementTags {
    Vector<std::int32_t> physical, geometrical;
    NumberMap places;  // by the elements' numbers, if there are values for them
  };

  std::shared_ptr<const NumberMap> keep(NumberMap places) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    node_places_ = std::make_shared<const NumberMap>(std::move(places));
    return node_places_;
  }
  std::shared_ptr<const ElementTags> keep(GmshElements elements) const {
    ElementTags tags{std::move(elements.physical), std::move(elements.geometrical), {}};
    if (!head_.element_data.empty()) tags.places = NumberMap(elements.numbers);
    const std::lock_guard<std::mutex> lock(mutex_);
    element_tags_ = std::make_shared<const ElementTags>(std::move(tags));
    return element_tags_;
  }
  std::shared_ptr<const NumberMap> node_places() const {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (node_places_) return node_places_;
    }
    return keep(read_gmsh_nodes(file_, head_).places);
  }
  std::shared_ptr<const ElementTags> element_tags() const {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (element_tags_) return element_tags_;
    }
    return keep(read_gmsh_elements(file_, head_, *node_places()));
  }

  void fill(const GmshData& data, const NumberMap& places, DataArray* array) const {
    const auto values = array->as<double>();
    std::fill(values.begin(), values.end(), std::numeric_limits<double>::quiet_NaN());
    GmshCursor in(file_, data.text, head_.binary, head_.swapped);
    for (std::uint64_t row = 0; row < data.rows; ++row) {
      in.skip_blanks_of_text();
      const char* const at = in.at();
      const std::int64_t number = in.integer();
      const std::uint64_t place =
          number < 0 ? NumberMap::kNone : places.find(static_cast<std::uint64_t>(number));
      if (place == NumberMap::kNone) {
        in.fail_at(at, "\"" + data.name + "\" has a value for " + std::to_string(number) +
                           ", which is not there");
      }
      for (std::uint64_t k = 0; k < data.components; ++k) {
        values[place * data.components + k] = in.real();
      }
    }
    in.rest_is_blank();
  }

  FormatFile file_;
  GmshHead head_;
  MeshDescription description_;
  mutable std::mutex mutex_;
  mutable std::shared_ptr<const NumberMap> node_places_;
  mutable std::shared_ptr<const ElementTags> element_tags_;
};

}  // namespace

std::unique_ptr<MeshSource> open_gmsh(MappedFile file, const OpenOptions& options) {
  return make_source(std::make_unique<GmshReader>(std::move(file)), options);
}

}  // namespace tetfusion
