#include "driver/import/chunk_loader.h"

#include <algorithm>
#include <stdexcept>

#include "driver/rounds/windows.h"
#include "partition/spatial_order.h"

namespace tetfusion {

namespace {

std::size_t items_in(const std::vector<std::span<const std::byte>>& pieces) {
  std::size_t items = 0;
  for (const std::span<const std::byte> piece : pieces) items += RowReader(piece).items();
  return items;
}

void append_column(RowReader* reader, std::size_t at, Column* column) {
  const std::size_t bytes = reader->items() * column->stride();
  std::copy_n(reader->take_bytes(bytes), bytes, column->rows.data() + at * column->stride());
}

}  // namespace

template <class Real>
ChunkLoader<Real>::ChunkLoader(const WorkMesh<Real>& layout, const Box& box)
    : curve_(box, 0), layout_(layout) {
  layout_.quadric_width = 0;
  layout_.has_deviations = false;
}

template <class Real>
void ChunkLoader<Real>::load(std::uint32_t chunk, PieceStore& tets, PieceStore& points,
                             WorkMesh<Real>* mesh) {
  raw_ = layout_;
  read_points(points.read(chunk)->pieces());
  read_tets(tets.read(chunk)->pieces());
  order_along_curve(curve_, raw_, mesh);
  raw_ = {};
}

template <class Real>
void ChunkLoader<Real>::read_points(const std::vector<std::span<const std::byte>>& pieces) {
  const std::size_t all = items_in(pieces);
  raw_.resize_vertices(all);
  raw_.incidence.assign(all, 0);
  raw_.changed.assign(all, 0);
  places_.reset(all);
  std::size_t at = 0;
  for (const std::span<const std::byte> piece : pieces) {
    RowReader reader(piece);
    const std::size_t n = reader.items();
    std::copy_n(reader.take<VertexId>(), n, raw_.point_ids.data() + at);
    std::copy_n(reader.take<std::uint8_t>(), n, raw_.marks.data() + at);
    std::copy_n(reader.take<Vec3<Real>>(), n, raw_.positions.data() + at);
    const std::size_t width = raw_.steering_width;
    for (std::size_t k = 0; k < width; ++k) {
      const double* values = reader.take<double>();
      for (std::size_t i = 0; i < n; ++i) raw_.steering[(at + i) * width + k] = values[i];
    }
    for (Column& column : raw_.point_columns) append_column(&reader, at, &column);
    for (std::size_t i = 0; i < n; ++i) {
      places_[raw_.point_ids[at + i]] = static_cast<VertexId>(at + i);
    }
    at += n;
  }
}

template <class Real>
void ChunkLoader<Real>::read_tets(const std::vector<std::span<const std::byte>>& pieces) {
  const std::size_t all = items_in(pieces);
  raw_.resize_tets(all);
  raw_.remembered.assign(all, 0);
  std::size_t at = 0;
  for (const std::span<const std::byte> piece : pieces) {
    RowReader reader(piece);
    const std::size_t n = reader.items();
    const Tet* tets = reader.take<Tet>();
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = 0; k < 4; ++k) {
        const VertexId place = places_.find(tets[i][k]);
        if (place == IdMap::kNone) {
          throw std::logic_error("a chunk lacks a point of its tetrahedra");
        }
        raw_.tets[at + i][k] = place;
        ++raw_.incidence[place];
      }
    }
    for (Column& column : raw_.cell_columns) append_column(&reader, at, &column);
    at += n;
  }
}

template class ChunkLoader<float>;
template class ChunkLoader<double>;

}  // namespace tetfusion
