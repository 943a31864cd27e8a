#include "series/other_arrays.h"

#include <algorithm>
#include <utility>

#include "io/source/stream_around.h"

namespace tetfusion {

namespace {

class DressedStream final : public StreamAround {
 public:
  // `own`: the arrays of points of the mesh that is dressed.
  DressedStream(std::unique_ptr<MeshStream> mesh, const AttributeSet& own,
                const OtherArrays& arrays, std::uint64_t bytes)
      : StreamAround(std::move(mesh)), own_(own), arrays_(arrays), bytes_(bytes) {}

  void read_rows(Association association, std::size_t index, std::uint64_t first,
                 std::uint64_t count, std::span<std::byte> out) const override {
    const bool of_points = association == Association::kPoint;
    const ArrayFrom& from = (of_points ? arrays_.points : arrays_.cells).at(index);
    if (count == 0) return;
    from.fill(inner(), first, out.first(count * from.info.row_bytes()));
  }
  std::uint64_t bytes() const override { return StreamAround::bytes() + bytes_; }

  LargestDifference largest_difference() const override {
    LargestDifference largest = StreamAround::largest_difference();
    if (largest.share == 0 || largest.array >= own_.arrays.size()) return largest;
    const auto found = std::find_if(
        arrays_.points.begin(), arrays_.points.end(),
        [&](const ArrayFrom& a) { return a.info.name == own_.arrays[largest.array].name; });
    largest.array = found == arrays_.points.end()
                        ? AttributeSet::npos
                        : static_cast<std::size_t>(found - arrays_.points.begin());
    return largest;
  }

 private:
  const AttributeSet& own_;
  const OtherArrays& arrays_;
  const std::uint64_t bytes_;
};

class DressedMesh final : public MeshSource {
 public:
  DressedMesh(std::unique_ptr<MeshSource> mesh, OtherArrays arrays)
      : mesh_(std::move(mesh)), arrays_(std::move(arrays)), description_(mesh_->description()) {
    if (!arrays_.path.empty()) description_.path = arrays_.path;
    description_.point_data = describe(arrays_.points, arrays_.point_markers);
    description_.cell_data = describe(arrays_.cells, arrays_.cell_markers);
    description_.field_data = {};
    description_.left_out = {};  // who opens the file itself says so, once
    for (const DataArray& array : arrays_.field_data) {
      description_.field_data.arrays.push_back(array.info);
    }
  }

  const MeshDescription& description() const override { return description_; }
  Geometry read_geometry() override { return mesh_->read_geometry(); }

  DataArray read_array(Association association, std::size_t index) override {
    if (association == Association::kField) return arrays_.field_data.at(index);
    const bool of_points = association == Association::kPoint;
    const auto open = stream();
    DataArray array;
    array.info = (of_points ? arrays_.points : arrays_.cells).at(index).info;
    array.info.tuples = of_points ? open->points() : open->cells();
    array.bytes.resize(array.info.bytes());
    open->read_rows(association, index, 0, array.info.tuples, array.bytes);
    return array;
  }

  std::optional<std::uint64_t> mesh_checksum(const RunContext& context) override {
    return mesh_->mesh_checksum(context);
  }

  // Also where the mesh must be read whole: here, before anybody looks at its size.
  std::unique_ptr<MeshStream> stream() override {
    std::uint64_t bytes = 0;
    auto open = open_stream(mesh_.get(), [&](std::uint64_t needed) { bytes = needed; });
    return std::make_unique<DressedStream>(std::move(open), mesh_->description().point_data,
                                           arrays_, bytes);
  }

  std::unique_ptr<MeshStream> stream_of_rows() override {
    return std::make_unique<DressedStream>(open_rows(mesh_.get()), mesh_->description().point_data,
                                           arrays_, 0);
  }

 private:
  static AttributeSet describe(const std::vector<ArrayFrom>& arrays,
                               std::map<std::string, std::string> markers) {
    AttributeSet set;
    for (const ArrayFrom& array : arrays) set.arrays.push_back(array.info);
    set.active = std::move(markers);
    return set;
  }

  std::unique_ptr<MeshSource> mesh_;
  OtherArrays arrays_;
  MeshDescription description_;
};

}  // namespace

ArrayFrom own_array(const MeshDescription& mesh, Association association, std::size_t index) {
  const bool of_points = association == Association::kPoint;
  const ArrayInfo& info = (of_points ? mesh.point_data : mesh.cell_data).arrays[index];
  const std::uint64_t row = info.row_bytes();
  return {info, [association, index, row](const MeshStream& stream, std::uint64_t first,
                                          std::span<std::byte> out) {
            stream.read_rows(association, index, first, out.size() / row, out);
          }};
}

std::unique_ptr<MeshSource> with_arrays(std::unique_ptr<MeshSource> mesh, OtherArrays arrays) {
  return std::make_unique<DressedMesh>(std::move(mesh), std::move(arrays));
}

}  // namespace tetfusion
