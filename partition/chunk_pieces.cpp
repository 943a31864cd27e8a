// A piece: a header, then one column after another, each at a multiple of 8 bytes:
//
//   vertices  positions, point_ids, marks, steering, quadrics, deviations (if there are any), point
//             columns
//   tets      corners (by place among the piece's vertices), remembered (1 byte), cell columns
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

// Hands out the columns of a piece one after another; nothing but their sizes for no memory.
template <class Byte>
class Cursor {
 public:
  explicit Cursor(Byte* begin) : begin_(begin) {}
  template <class T>
  auto take(std::size_t count) {
    using Value = std::conditional_t<std::is_const_v<Byte>, const T, T>;
    return reinterpret_cast<Value*>(take_bytes(count * sizeof(T)));
  }
  Byte* take_bytes(std::size_t bytes) {
    const std::size_t at = taken_;
    taken_ += padded(bytes);
    if (begin_ == nullptr) return nullptr;
    if constexpr (!std::is_const_v<Byte>) std::fill(begin_ + at + bytes, begin_ + taken_, Byte{});
    return begin_ + at;
  }
  std::size_t taken() const { return taken_; }

 private:
  Byte* begin_;
  std::size_t taken_ = 0;
};

}  // namespace

template <class Real, class Byte>
struct PieceColumns {
  template <class T>
  using Rows = std::conditional_t<std::is_const_v<Byte>, const T*, T*>;

  PieceColumns(const WorkMesh<Real>& layout, const PieceHeader& of, Byte* begin) : header(of) {
    Cursor<Byte> cursor(begin);
    cursor.template take<PieceHeader>(1);
    positions = cursor.template take<Vec3<Real>>(header.vertices);
    point_ids = cursor.template take<VertexId>(header.vertices);
    marks = cursor.template take<std::uint8_t>(header.vertices);
    steering = cursor.template take<double>(header.vertices * layout.steering_width);
    quadrics = cursor.template take<float>(header.vertices * layout.quadric_width);
    deviations = cursor.template take<float>(layout.has_deviations ? header.vertices : 0);
    for (const Column& c : layout.point_columns) {
      point_rows.push_back(cursor.take_bytes(header.vertices * c.stride()));
    }
    corners = cursor.template take<Tet>(header.tets);
    remembered = cursor.template take<std::uint8_t>(header.tets);
    for (const Column& c : layout.cell_columns) {
      cell_rows.push_back(cursor.take_bytes(header.tets * c.stride()));
    }
    removed_from = cursor.template take<TetId>(header.removed);
    removed_positions = cursor.template take<Vec3<Real>>(header.removed);
    removed_steering = cursor.template take<double>(header.removed * layout.steering_width);
    bytes = cursor.taken();
  }

  PieceHeader header;
  Rows<Vec3<Real>> positions;
  Rows<VertexId> point_ids;
  Rows<std::uint8_t> marks;
  Rows<double> steering;
  Rows<float> quadrics, deviations;
  std::vector<Byte*> point_rows;
  Rows<Tet> corners;
  Rows<std::uint8_t> remembered;
  std::vector<Byte*> cell_rows;
  Rows<TetId> removed_from;
  Rows<Vec3<Real>> removed_positions;
  Rows<double> removed_steering;
  std::size_t bytes = 0;  // of the piece
};

namespace {

template <class Real>
std::size_t piece_bytes(const WorkMesh<Real>& layout, const PieceHeader& header) {
  return PieceColumns<Real, const std::byte>(layout, header, nullptr).bytes;
}

PieceHeader header_of(std::span<const std::byte> piece) {
  PieceHeader header;
  if (piece.size() >= sizeof header) std::memcpy(&header, piece.data(), sizeof header);
  return header;
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

// Of a tetrahedron, for the next round: of fuse its grade; of tetfuse, whether a pass would refuse
// it as a flip without looking, as nothing round it has moved since.
template <class Real>
std::uint8_t remembered_of(const WorkMesh<Real>& mesh, TetId t) {
  const std::uint16_t remembered = mesh.remembered[t];
  if (mesh.quadric_width > 0) return static_cast<std::uint8_t>(remembered);
  const auto is_as_it_was = [&](VertexId v) { return mesh.changed[v] < remembered; };
  return std::ranges::all_of(mesh.tets[t], is_as_it_was) ? 1 : 0;
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
  collect_vertices(mesh, tets, slot);
  PieceHeader header{used_.size(), tets.size(), 0};
  for_each_removed(mesh.removed, tets, [&](std::uint32_t, std::uint32_t) { ++header.removed; });
  const std::size_t begin = padded(buffer_.size(), kPieceAlignment);
  const std::size_t bytes = piece_bytes(mesh, header);
  extents_.emplace_back(begin, bytes);
  buffer_.resize(begin + bytes);
  std::byte* piece = buffer_.data() + begin;
  const PieceColumns<Real, std::byte> to(mesh, header, piece);
  std::memcpy(piece, &header, sizeof header);
  const std::uint64_t free = put_vertices(mesh, buckets_[slot], to);
  put_tets(mesh, tets, to);
  sizes_.push_back({buckets_[slot], free, tets.size()});
}

// Fills used_ and local_.
template <class Real>
void ChunkScatter<Real>::collect_vertices(const WorkMesh<Real>& mesh,
                                          std::span<const std::uint32_t> tets, std::uint32_t slot) {
  used_.clear();
  for (const std::uint32_t t : tets) {
    for (const VertexId v : mesh.tets[t]) {
      if (stamp_[v] == slot) continue;
      stamp_[v] = slot;
      local_[v] = static_cast<VertexId>(used_.size());
      used_.push_back(v);
    }
  }
}

// Returns how many of them are free.
template <class Real>
std::uint64_t ChunkScatter<Real>::put_vertices(const WorkMesh<Real>& mesh, std::uint32_t bucket,
                                               const PieceColumns<Real, std::byte>& to) const {
  std::uint64_t free = 0;
  const std::size_t width = mesh.steering_width, numbers = mesh.quadric_width;
  for (std::size_t i = 0; i < used_.size(); ++i) {
    const VertexId v = used_[i];
    to.positions[i] = mesh.positions[v];
    to.point_ids[i] = mesh.point_ids[v];
    std::uint8_t mark = mesh.marks[v] & kLasting;
    if ((mesh.marks[v] & kOnInterface) != 0) {
      mark |= kUndecided;
    } else if (low_[v] != high_[v]) {
      mark |= kOnInterface;
      if (high_[v] == bucket) mark |= kLast;
    } else {
      ++free;
    }
    to.marks[i] = mark;
    copy_few(mesh.steering.data() + v * width, width, to.steering + i * width);
    // Of a vertex that several chunks have, each has a part of the quadric, and they add up.
    if (low_[v] == bucket) {
      copy_few(mesh.quadrics.data() + v * numbers, numbers, to.quadrics + i * numbers);
    } else {
      std::fill_n(to.quadrics + i * numbers, numbers, 0.0F);
    }
    if (mesh.has_deviations) to.deviations[i] = mesh.deviations[v];
  }
  for (std::size_t c = 0; c < mesh.point_columns.size(); ++c) {
    copy_rows(mesh.point_columns[c], used_, to.point_rows[c]);
  }
  return free;
}

// With the points removed from them.
template <class Real>
void ChunkScatter<Real>::put_tets(const WorkMesh<Real>& mesh, std::span<const std::uint32_t> tets,
                                  const PieceColumns<Real, std::byte>& to) const {
  for (std::size_t i = 0; i < tets.size(); ++i) {
    const Tet& tet = mesh.tets[tets[i]];
    to.corners[i] = {local_[tet[0]], local_[tet[1]], local_[tet[2]], local_[tet[3]]};
    to.remembered[i] = remembered_of(mesh, tets[i]);
  }
  for (std::size_t c = 0; c < mesh.cell_columns.size(); ++c) {
    copy_rows(mesh.cell_columns[c], tets, to.cell_rows[c]);
  }
  const std::size_t width = mesh.steering_width;
  std::size_t row = 0;
  for_each_removed(mesh.removed, tets, [&](std::uint32_t tet, std::uint32_t point) {
    to.removed_from[row] = tet;
    to.removed_positions[row] = mesh.removed.positions[point];
    copy_few(mesh.removed.values.data() + point * width, width, to.removed_steering + row * width);
    ++row;
  });
}

template <class Real>
void ChunkGather<Real>::gather(std::uint32_t chunk, const PieceStore& from,
                               const InterfaceTable& interface, WorkMesh<Real>* mesh) {
  from.read(chunk)->use([&](const auto& bytes) {
    std::vector<Piece> pieces;
    for (const std::span<const std::byte> piece : bytes) {
      const PieceHeader header = header_of(piece);
      if (piece.size() != piece_bytes(*mesh, header)) {
        throw std::logic_error("a piece is not of this layout");
      }
      pieces.emplace_back(*mesh, header, piece.data());
    }
    make_room(pieces, mesh);
    std::size_t vertices = 0, tets = 0;  // so many are there already
    for (const Piece& piece : pieces) {
      vertices = take_vertices(piece, vertices, chunk, interface, mesh);
      take_tets(piece, tets, mesh);
      take_removed(piece, tets, mesh);
      tets += piece.header.tets;
    }
    mesh->resize_vertices(vertices);
  });
}

// Room for all that the pieces have, and to know again those vertices that may come more than once.
template <class Real>
void ChunkGather<Real>::make_room(const std::vector<Piece>& pieces, WorkMesh<Real>* mesh) {
  std::size_t vertices = 0, tets = 0, removed = 0, undecided = 0;
  for (const Piece& piece : pieces) {
    vertices += piece.header.vertices;
    tets += piece.header.tets;
    removed += piece.header.removed;
    undecided += static_cast<std::size_t>(
        std::count_if(piece.marks, piece.marks + piece.header.vertices,
                      [](std::uint8_t m) { return (m & kUndecided) != 0; }));
  }
  mesh->resize_vertices(vertices);
  mesh->resize_tets(tets);
  mesh->removed.reset(removed > 0 ? tets : 0);
  mesh->incidence.assign(vertices, 0);
  known_.reset(undecided);
}

// Of the piece's vertices those that are not there yet, from `first` on. Fills new_ids_. Returns
// how many vertices there are afterwards.
template <class Real>
std::size_t ChunkGather<Real>::take_vertices(const Piece& columns, std::size_t first,
                                             std::uint32_t chunk, const InterfaceTable& interface,
                                             WorkMesh<Real>* mesh) {
  const std::size_t count = columns.header.vertices;
  const std::size_t width = mesh->steering_width;
  const std::size_t numbers = mesh->quadric_width;
  std::size_t next = first;
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
  for (std::size_t c = 0; c < mesh->point_columns.size(); ++c) {
    Column& column = mesh->point_columns[c];
    const std::size_t stride = column.stride();
    for (std::size_t i = 0; i < count; ++i) {
      if (new_ids_[i] < first) continue;  // of a piece before
      copy_few(columns.point_rows[c] + i * stride, stride,
               column.rows.data() + new_ids_[i] * stride);
    }
  }
  return next;
}

template <class Real>
void ChunkGather<Real>::take_tets(const Piece& columns, std::size_t first, WorkMesh<Real>* mesh) {
  const std::size_t count = columns.header.tets;
  for (std::size_t i = 0; i < count; ++i) {
    Tet& tet = mesh->tets[first + i];
    for (std::size_t k = 0; k < 4; ++k) {
      tet[k] = new_ids_[columns.corners[i][k]];
      ++mesh->incidence[tet[k]];
    }
    mesh->remembered[first + i] = columns.remembered[i];
  }
  for (std::size_t c = 0; c < mesh->cell_columns.size(); ++c) {
    Column& column = mesh->cell_columns[c];
    const std::size_t stride = column.stride();
    std::memcpy(column.rows.data() + first * stride, columns.cell_rows[c], count * stride);
  }
}

// The piece's tetrahedra begin at `first_tet`.
template <class Real>
void ChunkGather<Real>::take_removed(const Piece& columns, std::size_t first_tet,
                                     WorkMesh<Real>* mesh) {
  const std::size_t count = columns.header.removed;
  const std::size_t width = mesh->steering_width;
  RemovedPoints<Real>& removed = mesh->removed;
  const std::uint32_t first = removed.add(count, width);
  std::copy_n(columns.removed_positions, count, removed.positions.data() + first);
  std::copy_n(columns.removed_steering, count * width, removed.values.data() + first * width);
  for (std::size_t i = count; i-- > 0;) {  // so that the order in a list stays
    removed.push(static_cast<TetId>(first_tet + columns.removed_from[i]),
                 static_cast<std::uint32_t>(first + i));
  }
}

template class ChunkScatter<float>;
template class ChunkScatter<double>;
template class ChunkGather<float>;
template class ChunkGather<double>;

}  // namespace tetfusion
