// A piece: a header, then one column after another, each at a multiple of 8 bytes:
//
//   vertices  positions, point_ids, marks, steering, quadrics, deviations (if there are any), point
//             columns
//   tets      corners (by place among the piece's vertices), settled (1 byte), cell columns
//   removed   points: tet (by place among the piece's), positions, steering
//
// Of the marks kOnInterface says that the vertex lies on the interface of the round to come, and
// kUndecided that the interface table knows.
#include "partition/chunk_pieces.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <type_traits>

#include "base/copy_few.h"

namespace tetfusion {

namespace {

constexpr std::uint8_t kUndecided = kNearBoundary;                 // a mark that no piece has
constexpr std::uint8_t kLasting = kOnBoundary | kLocked | kMoved;  // marks that outlive a round
constexpr std::size_t kPieceAlignment = 64;

struct PieceHeader {
  std::uint64_t vertices = 0;
  std::uint64_t tets = 0;
  std::uint64_t removed = 0;
};

constexpr std::size_t padded(std::size_t bytes, std::size_t to = 8) {
  return (bytes + to - 1) / to * to;
}

template <class Real>
std::size_t piece_bytes(const WorkMesh<Real>& layout, const PieceHeader& header) {
  const std::size_t vertices = header.vertices, tets = header.tets, removed = header.removed;
  std::size_t bytes = sizeof(PieceHeader);
  bytes += padded(vertices * sizeof(Vec3<Real>)) + padded(vertices * sizeof(VertexId)) +
           padded(vertices) + vertices * layout.steering_width * sizeof(double) +
           padded(vertices * layout.quadric_width * sizeof(float)) +
           padded(layout.has_deviations ? vertices * sizeof(float) : 0);
  for (const Column& c : layout.point_columns) bytes += padded(vertices * c.stride());
  bytes += tets * sizeof(Tet) + padded(tets);
  for (const Column& c : layout.cell_columns) bytes += padded(tets * c.stride());
  bytes += padded(removed * sizeof(TetId)) + padded(removed * sizeof(Vec3<Real>)) +
           removed * layout.steering_width * sizeof(double);
  return bytes;
}

// Hands out the columns of a piece one after another.
template <class Byte>
class Cursor {
 public:
  explicit Cursor(Byte* at) : at_(at) {}
  Byte* take(std::size_t bytes) {
    Byte* column = at_;
    at_ += padded(bytes);
    if constexpr (!std::is_const_v<Byte>) std::fill(column + bytes, at_, Byte{});
    return column;
  }

 private:
  Byte* at_;
};

template <class T>
T* as(std::byte* p) {
  return reinterpret_cast<T*>(p);
}
template <class T>
const T* as(const std::byte* p) {
  return reinterpret_cast<const T*>(p);
}

void copy_rows(const Column& from, std::span<const std::uint32_t> rows, std::byte* to) {
  const std::size_t stride = from.stride();
  for (const std::uint32_t row : rows) {
    copy_few(from.rows.data() + row * stride, stride, to);
    to += stride;
  }
}

// The removed points of these tetrahedra, list by list.
template <class Real, class F>
void for_each_removed(const RemovedPoints<Real>& removed, std::span<const std::uint32_t> tets,
                      F f) {
  if (!removed.wanted()) return;
  for (std::uint32_t i = 0; i < tets.size(); ++i) {
    for (std::uint32_t p = removed.first[tets[i]]; p != kNoPoint; p = removed.next[p]) f(i, p);
  }
}

// Would a pass refuse the tetrahedron as a flip without looking, as nothing round it has moved
// since?
template <class Real>
bool is_settled(const WorkMesh<Real>& mesh, TetId t) {
  const std::uint16_t flipped = mesh.flipped[t];
  const Tet& tet = mesh.tets[t];
  return flipped != 0 && mesh.changed[tet[0]] < flipped && mesh.changed[tet[1]] < flipped &&
         mesh.changed[tet[2]] < flipped && mesh.changed[tet[3]] < flipped;
}

}  // namespace

template <class Real>
void ChunkScatter<Real>::scatter(const WorkMesh<Real>& mesh, const CurveCut& next,
                                 std::uint32_t source, PieceStore* to,
                                 Vector<InterfaceReport>* reports) {
  choose_buckets(mesh, next);
  sort_tets(mesh);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const bool was_between = (mesh.marks[v] & kOnInterface) != 0;
    if (low_[v] > high_[v] || (low_[v] == high_[v] && !was_between)) continue;
    const bool touched = was_between && mesh.changed[v] >= kFirstPassNumber;
    reports->push_back({mesh.point_ids[v], low_[v], high_[v], 0, touched});
  }
  add_pieces(mesh, source, to);
}

template <class Real>
void ChunkScatter<Real>::keep(const WorkMesh<Real>& mesh, std::uint32_t chunk, PieceStore* to) {
  low_.assign(mesh.vertex_count(), chunk);
  high_.assign(mesh.vertex_count(), chunk);
  tet_bucket_.assign(mesh.tets.size(), chunk);
  buckets_.clear();
  if (!mesh.tets.empty()) buckets_.push_back(chunk);
  if (slot_of_bucket_.size() <= chunk) slot_of_bucket_.resize(chunk + 1, kNoVertex);
  sort_tets(mesh);
  add_pieces(mesh, chunk, to);
}

// A tetrahedron's bucket is the chunk of the next round that gets it.
template <class Real>
void ChunkScatter<Real>::choose_buckets(const WorkMesh<Real>& mesh, const CurveCut& next) {
  const std::size_t vertices = mesh.vertex_count();
  bucket_.resize(vertices);
  for (std::size_t v = 0; v < vertices; ++v) bucket_[v] = next.chunk_of(mesh.positions[v]);
  low_.assign(vertices, kNoVertex);
  high_.assign(vertices, 0);
  tet_bucket_.resize(mesh.tets.size());
  buckets_.clear();
  if (slot_of_bucket_.size() < next.chunks()) slot_of_bucket_.resize(next.chunks(), kNoVertex);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const Tet& tet = mesh.tets[t];
    const std::uint32_t bucket =
        std::min({bucket_[tet[0]], bucket_[tet[1]], bucket_[tet[2]], bucket_[tet[3]]});
    tet_bucket_[t] = bucket;
    for (const VertexId v : tet) {
      low_[v] = std::min(low_[v], bucket);
      high_[v] = std::max(high_[v], bucket);
    }
    if (slot_of_bucket_[bucket] == kNoVertex) {
      slot_of_bucket_[bucket] = 0;
      buckets_.push_back(bucket);
    }
  }
  std::sort(buckets_.begin(), buckets_.end());
}

// A counting sort by bucket; leaves slot_of_bucket_ without slots.
template <class Real>
void ChunkScatter<Real>::sort_tets(const WorkMesh<Real>& mesh) {
  for (std::uint32_t s = 0; s < buckets_.size(); ++s) slot_of_bucket_[buckets_[s]] = s;
  begins_.assign(buckets_.size() + 1, 0);
  for (const std::uint32_t bucket : tet_bucket_) ++begins_[slot_of_bucket_[bucket] + 1];
  for (std::size_t s = 0; s < buckets_.size(); ++s) begins_[s + 1] += begins_[s];
  order_.resize(mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    order_[begins_[slot_of_bucket_[tet_bucket_[t]]]++] = static_cast<std::uint32_t>(t);
  }
  for (std::size_t s = buckets_.size(); s > 0; --s) begins_[s] = begins_[s - 1];
  begins_[0] = 0;
  for (const std::uint32_t bucket : buckets_) slot_of_bucket_[bucket] = kNoVertex;
}

template <class Real>
void ChunkScatter<Real>::add_pieces(const WorkMesh<Real>& mesh, std::uint32_t source,
                                    PieceStore* to) {
  stamp_.assign(mesh.vertex_count(), kNoVertex);
  local_.resize(mesh.vertex_count());
  buffer_.clear();
  extents_.clear();
  sizes_.clear();
  for (std::uint32_t s = 0; s < buckets_.size(); ++s) put_piece(mesh, s);
  std::vector<PieceRef> pieces;
  for (std::size_t s = 0; s < buckets_.size(); ++s) {
    const auto& [begin, bytes] = extents_[s];
    pieces.push_back({buckets_[s], {buffer_.data() + begin, bytes}});
  }
  to->add(source, pieces);
}

template <class Real>
void ChunkScatter<Real>::put_piece(const WorkMesh<Real>& mesh, std::uint32_t slot) {
  const std::span<const std::uint32_t> tets(order_.data() + begins_[slot],
                                            begins_[slot + 1] - begins_[slot]);
  used_.clear();
  for (const std::uint32_t t : tets) {
    for (const VertexId v : mesh.tets[t]) {
      if (stamp_[v] == slot) continue;
      stamp_[v] = slot;
      local_[v] = static_cast<VertexId>(used_.size());
      used_.push_back(v);
    }
  }

  const std::size_t n = used_.size();
  const std::size_t begin = padded(buffer_.size(), kPieceAlignment);
  PieceHeader header{n, tets.size(), 0};
  for_each_removed(mesh.removed, tets, [&](std::uint32_t, std::uint32_t) { ++header.removed; });
  const std::size_t bytes = piece_bytes(mesh, header);
  extents_.emplace_back(begin, bytes);
  buffer_.resize(begin + bytes);
  Cursor<std::byte> cursor(buffer_.data() + begin);
  std::memcpy(cursor.take(sizeof header), &header, sizeof header);
  auto* positions = as<Vec3<Real>>(cursor.take(n * sizeof(Vec3<Real>)));
  auto* point_ids = as<VertexId>(cursor.take(n * sizeof(VertexId)));
  auto* marks = as<std::uint8_t>(cursor.take(n));
  const std::size_t width = mesh.steering_width;
  auto* steering = as<double>(cursor.take(n * width * sizeof(double)));
  const std::size_t numbers = mesh.quadric_width;
  auto* quadrics = as<float>(cursor.take(n * numbers * sizeof(float)));
  const std::size_t deviation_count = mesh.has_deviations ? n : 0;
  auto* deviations = as<float>(cursor.take(deviation_count * sizeof(float)));
  for (std::size_t i = 0; i < deviation_count; ++i) deviations[i] = mesh.deviations[used_[i]];
  PieceSize& size = sizes_.emplace_back(PieceSize{buckets_[slot], 0, tets.size()});
  for (std::size_t i = 0; i < n; ++i) {
    const VertexId v = used_[i];
    positions[i] = mesh.positions[v];
    point_ids[i] = mesh.point_ids[v];
    std::uint8_t mark = mesh.marks[v] & kLasting;
    if ((mesh.marks[v] & kOnInterface) != 0) {
      mark |= kUndecided;
    } else if (low_[v] != high_[v]) {
      mark |= kOnInterface;
      if (low_[v] != buckets_[slot]) mark |= kAway;
      if (high_[v] == buckets_[slot]) mark |= kLast;
    } else {
      ++size.free_vertices;
    }
    marks[i] = mark;
    copy_few(mesh.steering.data() + v * width, width, steering + i * width);
    // Of a vertex that several chunks have, each has a part of the quadric, and they add up.
    if (low_[v] == buckets_[slot]) {
      copy_few(mesh.quadrics.data() + v * numbers, numbers, quadrics + i * numbers);
    } else {
      std::fill_n(quadrics + i * numbers, numbers, 0.0F);
    }
  }
  for (const Column& c : mesh.point_columns) copy_rows(c, used_, cursor.take(n * c.stride()));
  auto* corners = as<Tet>(cursor.take(tets.size() * sizeof(Tet)));
  auto* settled = as<std::uint8_t>(cursor.take(tets.size()));
  for (std::size_t i = 0; i < tets.size(); ++i) {
    const Tet& tet = mesh.tets[tets[i]];
    corners[i] = {local_[tet[0]], local_[tet[1]], local_[tet[2]], local_[tet[3]]};
    settled[i] = is_settled(mesh, tets[i]) ? 1 : 0;
  }
  for (const Column& c : mesh.cell_columns) {
    copy_rows(c, tets, cursor.take(tets.size() * c.stride()));
  }
  auto* tet_of = as<TetId>(cursor.take(header.removed * sizeof(TetId)));
  auto* places = as<Vec3<Real>>(cursor.take(header.removed * sizeof(Vec3<Real>)));
  auto* values = as<double>(cursor.take(header.removed * width * sizeof(double)));
  for_each_removed(mesh.removed, tets, [&](std::uint32_t tet, std::uint32_t point) {
    *tet_of++ = tet;
    *places++ = mesh.removed.positions[point];
    values = std::copy_n(mesh.removed.values.data() + point * width, width, values);
  });
}

template <class Real>
void ChunkGather<Real>::gather(std::uint32_t chunk, const PieceStore& from,
                               const InterfaceTable& interface, WorkMesh<Real>* mesh) {
  const std::unique_ptr<BucketPieces> bucket = from.read(chunk);
  make_room(bucket->pieces(), mesh);
  std::size_t vertices = 0, tets = 0;  // so many are there already
  for (const std::span<const std::byte> piece : bucket->pieces()) {
    Cursor<const std::byte> cursor(piece.data());
    const PieceHeader header = *as<PieceHeader>(cursor.take(sizeof(PieceHeader)));
    const std::size_t n = header.vertices;
    const std::size_t width = mesh->steering_width;
    const std::size_t numbers = mesh->quadric_width;
    const std::size_t deviations = mesh->has_deviations ? n : 0;
    const VertexColumns<Real> columns{as<Vec3<Real>>(cursor.take(n * sizeof(Vec3<Real>))),
                                      as<VertexId>(cursor.take(n * sizeof(VertexId))),
                                      as<std::uint8_t>(cursor.take(n)),
                                      as<double>(cursor.take(n * width * sizeof(double))),
                                      as<float>(cursor.take(n * numbers * sizeof(float))),
                                      as<float>(cursor.take(deviations * sizeof(float)))};
    const std::size_t first = vertices;
    vertices = take_vertices(columns, n, first, chunk, interface, mesh);
    for (Column& c : mesh->point_columns) {
      const std::size_t stride = c.stride();
      const std::byte* rows = cursor.take(n * stride);
      for (std::size_t i = 0; i < n; ++i) {
        if (new_ids_[i] < first) continue;  // of a piece before
        copy_few(rows + i * stride, stride, c.rows.data() + new_ids_[i] * stride);
      }
    }
    const auto* corners = as<Tet>(cursor.take(header.tets * sizeof(Tet)));
    const auto* settled = as<std::uint8_t>(cursor.take(header.tets));
    for (std::size_t i = 0; i < header.tets; ++i) {
      Tet& tet = mesh->tets[tets + i];
      for (std::size_t k = 0; k < 4; ++k) {
        tet[k] = new_ids_[corners[i][k]];
        ++mesh->incidence[tet[k]];
      }
      mesh->flipped[tets + i] = settled[i];
    }
    for (Column& c : mesh->cell_columns) {
      const std::size_t bytes = header.tets * c.stride();
      std::memcpy(c.rows.data() + tets * c.stride(), cursor.take(bytes), bytes);
    }
    const auto* tet_of = as<TetId>(cursor.take(header.removed * sizeof(TetId)));
    const auto* places = as<Vec3<Real>>(cursor.take(header.removed * sizeof(Vec3<Real>)));
    const auto* values = as<double>(cursor.take(header.removed * width * sizeof(double)));
    RemovedPoints<Real>& removed = mesh->removed;
    const std::uint32_t first_point = removed.add(header.removed, width);
    std::copy_n(places, header.removed, removed.positions.data() + first_point);
    std::copy_n(values, header.removed * width, removed.values.data() + first_point * width);
    for (std::size_t i = header.removed; i-- > 0;) {  // so that the order in a list stays
      removed.push(static_cast<TetId>(tets + tet_of[i]),
                   static_cast<std::uint32_t>(first_point + i));
    }
    tets += header.tets;
  }
  mesh->resize_vertices(vertices);
}

// Room for all that the pieces have, and to know again those vertices that may come more than once.
template <class Real>
void ChunkGather<Real>::make_room(const std::vector<std::span<const std::byte>>& pieces,
                                  WorkMesh<Real>* mesh) {
  std::size_t vertices = 0, tets = 0, removed = 0, undecided = 0;
  for (const std::span<const std::byte> piece : pieces) {
    const auto* header = as<PieceHeader>(piece.data());
    if (piece.size() < sizeof(PieceHeader) || piece.size() != piece_bytes(*mesh, *header)) {
      throw std::logic_error("a piece is not of this layout");
    }
    vertices += header->vertices;
    tets += header->tets;
    removed += header->removed;
    Cursor<const std::byte> cursor(piece.data());
    cursor.take(sizeof(PieceHeader));
    cursor.take(header->vertices * sizeof(Vec3<Real>));
    cursor.take(header->vertices * sizeof(VertexId));
    const auto* marks = as<std::uint8_t>(cursor.take(header->vertices));
    undecided += static_cast<std::size_t>(std::count_if(
        marks, marks + header->vertices, [](std::uint8_t m) { return (m & kUndecided) != 0; }));
  }
  mesh->resize_vertices(vertices);
  mesh->resize_tets(tets);
  mesh->removed.reset(removed > 0 ? tets : 0);
  mesh->incidence.assign(vertices, 0);
  known_.reset(undecided);
}

// Fills new_ids_. Returns how many vertices there are afterwards.
template <class Real>
std::size_t ChunkGather<Real>::take_vertices(const VertexColumns<Real>& columns, std::size_t count,
                                             std::size_t next, std::uint32_t chunk,
                                             const InterfaceTable& interface,
                                             WorkMesh<Real>* mesh) {
  const std::size_t width = mesh->steering_width;
  const std::size_t numbers = mesh->quadric_width;
  new_ids_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::uint8_t mark = columns.marks[i];
    std::uint16_t changed = 0;
    const VertexId id = columns.point_ids[i];
    if ((mark & kUndecided) != 0) {
      VertexId& known = known_[id];
      if (known != IdMap::kNone) {
        new_ids_[i] = known;
        float* sum = mesh->quadrics.data() + known * numbers;
        for (std::size_t k = 0; k < numbers; ++k) sum[k] += columns.quadrics[i * numbers + k];
        continue;
      }
      known = static_cast<VertexId>(next);
      const InterfaceReport* report = interface.find(id);
      if (report == nullptr) throw std::logic_error("a vertex is missing in the interface table");
      mark = static_cast<std::uint8_t>((mark & kLasting) | report->marks);
      if (report->low != report->high) mark |= kOnInterface;
      if (report->low != chunk) mark |= kAway;
      if (report->high == chunk) mark |= kLast;
      changed = report->touched ? 1 : 0;
    }
    mesh->positions[next] = columns.positions[i];
    mesh->point_ids[next] = id;
    mesh->marks[next] = mark;
    mesh->changed[next] = changed;
    copy_few(columns.steering + i * width, width, mesh->steering.data() + next * width);
    copy_few(columns.quadrics + i * numbers, numbers, mesh->quadrics.data() + next * numbers);
    if (mesh->has_deviations) mesh->deviations[next] = columns.deviations[i];
    new_ids_[i] = static_cast<VertexId>(next++);
  }
  return next;
}

template class ChunkScatter<float>;
template class ChunkScatter<double>;
template class ChunkGather<float>;
template class ChunkGather<double>;

}  // namespace tetfusion
