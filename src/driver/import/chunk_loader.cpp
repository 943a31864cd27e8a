#include "driver/import/chunk_loader.h"

#include <algorithm>
#include <stdexcept>

#include "partition/spatial_order.h"

namespace tetfusion {

namespace {

std::vector<RowReader> readers_of(const std::vector<std::span<const std::byte>>& pieces) {
  return {pieces.begin(), pieces.end()};
}

std::size_t items_in(const std::vector<RowReader>& readers) {
  std::size_t items = 0;
  for (const RowReader& reader : readers) items += reader.items();
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
  points.read(chunk)->use([this](const auto& pieces) { read_points(readers_of(pieces)); });
  tets.read(chunk)->use([this](const auto& pieces) { read_tets(readers_of(pieces)); });
  order_along_curve(curve_, raw_, mesh);
  raw_ = {};
}

template <class Real>
void ChunkLoader<Real>::read_points(std::vector<RowReader> readers) {
  const std::size_t all = items_in(readers);
  raw_.resize_vertices(all);
  raw_.incidence.assign(all, 0);
  raw_.changed.assign(all, 0);
  places_.reset(all);
  std::size_t at = 0;
  for (RowReader& reader : readers) {
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
void ChunkLoader<Real>::read_tets(std::vector<RowReader> readers) {
  const std::size_t all = items_in(readers);
  raw_.resize_tets(all);
  raw_.remembered.assign(all, 0);
  std::size_t at = 0;
  for (RowReader& reader : readers) {
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
