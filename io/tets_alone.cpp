#include "io/tets_alone.h"

#include <utility>

#include "io/merge_pieces.h"
#include "io/stream_around.h"

namespace tetfusion {

namespace {

class TetsAloneStream final : public StreamAround {
 public:
  using StreamAround::StreamAround;

  void read_cells(std::uint64_t first, std::uint64_t count, CellWindow* out) const override {
    StreamAround::read_cells(first, count, out);
    out->lower = {};
    out->lower_rows.clear();
  }
};

void drop_unused_points(Geometry* mesh) {
  Vector<std::uint8_t> used;
  used.assign(point_count(mesh->points), 0);
  for (const Tet& tet : mesh->tets) {
    for (const VertexId v : tet) used[v] = 1;
  }
  const Vector<std::uint64_t> rows = std::exchange(mesh->point_source, {});
  const Vector<VertexId> new_ids = compact_points(used, {}, mesh);
  if (new_ids.empty()) {
    mesh->point_source = rows;
    return;
  }
  for (Tet& tet : mesh->tets) {
    for (VertexId& v : tet) v = new_ids[v];
  }
  if (rows.empty()) return;
  for (std::uint64_t& row : mesh->point_source) row = rows[row];
}

class TetsAlone final : public MeshSource {
 public:
  explicit TetsAlone(std::unique_ptr<MeshSource> source) : source_(std::move(source)) {}

  const MeshDescription& description() const override { return source_->description(); }

  Geometry read_geometry() override {
    Geometry mesh = source_->read_geometry();
    if (mesh.lower.size() == 0) return mesh;
    mesh.lower = {};
    mesh.lower_source = {};
    drop_unused_points(&mesh);
    return mesh;
  }

  DataArray read_array(Association association, std::size_t index) override {
    return source_->read_array(association, index);
  }

  std::unique_ptr<MeshStream> stream() override {
    auto stream = source_->stream();
    if (stream == nullptr) return nullptr;
    return std::make_unique<TetsAloneStream>(std::move(stream));
  }
  std::unique_ptr<MeshStream> stream_of_rows() override { return source_->stream_of_rows(); }

  std::optional<std::uint64_t> mesh_checksum(const RunContext& context) override {
    return source_->mesh_checksum(context);
  }
  std::uint64_t memory_to_read() override { return source_->memory_to_read(); }

 private:
  std::unique_ptr<MeshSource> source_;
};

}  // namespace

std::unique_ptr<MeshSource> tets_alone(std::unique_ptr<MeshSource> source) {
  return std::make_unique<TetsAlone>(std::move(source));
}

}  // namespace tetfusion
