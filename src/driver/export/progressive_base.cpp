#include "driver/export/progressive_base.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "base/serialize.h"

namespace tetfusion {

namespace {

Vector<std::uint32_t> ascending(const Vector<std::uint32_t>& numbers) {
  auto order = count_up<std::uint32_t>(numbers.size());
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return numbers[a] < numbers[b]; });
  return order;
}

template <class T>
Vector<T> chosen(const Vector<T>& values, std::span<const std::uint32_t> order) {
  Vector<T> out(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) out[i] = values[order[i]];
  return out;
}

// The same for rows of one length.
Vector<std::byte> chosen_rows(const Vector<std::byte>& rows, std::size_t stride,
                              std::span<const std::uint32_t> order) {
  Vector<std::byte> out(order.size() * stride);
  for (std::size_t i = 0; i < order.size() && stride > 0; ++i) {
    std::memcpy(out.data() + i * stride, rows.data() + std::size_t{order[i]} * stride, stride);
  }
  return out;
}

// Calls put(range, order) for the numbers of each range, ascending.
template <class Put>
void for_each_range(const Vector<std::uint32_t>& numbers, std::uint32_t a_range, const Put& put) {
  const Vector<std::uint32_t> order = ascending(numbers);
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    const std::uint32_t range = numbers[order[begin]] / a_range;
    while (end < order.size() && numbers[order[end]] / a_range == range) ++end;
    put(range, std::span(order).subspan(begin, end - begin));
  }
}

template <class T>
void append(ByteReader* in, Vector<T>* all) {
  Vector<T> part;
  in->get_all(&part);
  all->insert(all->end(), part.begin(), part.end());
}

std::uint32_t numbers_a_range(std::uint64_t bytes, std::size_t row) {
  return static_cast<std::uint32_t>(std::max<std::uint64_t>(bytes / row, 1));
}

std::uint32_t ranges(std::uint64_t numbers, std::uint32_t a_range) {
  return static_cast<std::uint32_t>(numbers / a_range + 1);
}

}  // namespace

template <class Real>
ProgressiveBase<Real>::ProgressiveBase(const WorkMesh<Real>& layout, std::uint64_t points,
                                       std::uint64_t cells, Scratch* scratch)
    : layout_(layout),
      point_row_(point_row_bytes(layout)),
      tet_row_(tet_row_bytes(layout)),
      points_a_range_(numbers_a_range(kRangeBytes, sizeof(VertexId) + point_row_)),
      tets_a_range_(numbers_a_range(kRangeBytes, sizeof(TetId) + sizeof(Tet) + tet_row_)),
      point_ranges_(ranges(points, points_a_range_)),
      tet_ranges_(ranges(cells, tets_a_range_)),
      store_(scratch->begin("base")) {}

template <class Real>
void ProgressiveBase<Real>::add(const MacroLod<Real>& mesh, const RunContext& context,
                                MemoryBudget* budget) {
  if (mesh.whole) {
    context.check();
    add_chunk(*mesh.whole);
    context.report(kWayBackPhase, 1);
    return;
  }
  ChunkGather<Real> gather;
  WorkMesh<Real> chunk(layout_);
  for (std::uint32_t c = 0; c < mesh.chunks; ++c) {
    context.check();
    const auto memory = budget->wait_for(chunk_memory(mesh.pieces->bytes(c)), "a chunk");
    Rounds<Real>::gather(mesh, c, &gather, &chunk);
    add_chunk(chunk);
    context.report(kWayBackPhase, 0, 1, c + 1, mesh.chunks);
  }
}

template <class Real>
void ProgressiveBase<Real>::add_chunk(const WorkMesh<Real>& chunk) {
  PointRows points;
  TetRows tets;
  for (std::size_t v = 0; v < chunk.vertex_count(); ++v) {
    if (chunk.incidence[v] == 0) continue;
    points.numbers.push_back(chunk.point_ids[v]);
    points.rows.resize(points.rows.size() + point_row_);
    copy_point_row(chunk, v, points.rows.data() + points.rows.size() - point_row_);
  }
  const std::span<const TetId> numbers = original_numbers(chunk);
  tets.rows.resize(chunk.tets.size() * tet_row_);
  for (std::size_t t = 0; t < chunk.tets.size(); ++t) {
    Tet tet = chunk.tets[t];
    for (VertexId& v : tet) v = chunk.point_ids[v];
    tets.numbers.push_back(numbers[t]);
    tets.corners.push_back(tet);
    copy_tet_row(chunk, t, tets.rows.data() + t * tet_row_);
  }
  add_rows(points, tets);
}

template <class Real>
void ProgressiveBase<Real>::add(PointRows points) {
  add_rows(points, {});
}

template <class Real>
void ProgressiveBase<Real>::add_rows(const PointRows& points, const TetRows& tets) {
  std::vector<std::pair<std::uint32_t, Vector<std::byte>>> parts;
  for_each_range(points.numbers, points_a_range_, [&](std::uint32_t range, auto order) {
    ByteWriter out;
    out.put_all(chosen(points.numbers, order));
    out.put_all(chosen_rows(points.rows, point_row_, order));
    parts.emplace_back(range, out.take());
  });
  for_each_range(tets.numbers, tets_a_range_, [&](std::uint32_t range, auto order) {
    ByteWriter out;
    out.put_all(chosen(tets.numbers, order));
    out.put_all(chosen(tets.corners, order));
    out.put_all(chosen_rows(tets.rows, tet_row_, order));
    parts.emplace_back(point_ranges_ + range, out.take());
  });
  std::vector<PieceRef> pieces;
  for (const auto& [bucket, bytes] : parts) pieces.push_back({bucket, bytes});
  if (!pieces.empty()) store_->add(sources_++, pieces);
}

// A point on the interface comes from several chunks.
template <class Real>
void ProgressiveBase<Real>::put_points(const RunContext& context, ProgressiveWriter* writer,
                                       std::vector<bool>* known) {
  for (std::uint32_t range = 0; range < point_ranges_; ++range) {
    context.check();
    PointRows all;
    store_->for_each(range, [&](std::span<const std::byte> piece) {
      ByteReader in(piece);
      append(&in, &all.numbers);
      append(&in, &all.rows);
    });
    Vector<std::uint32_t> order = ascending(all.numbers);
    const auto is_same = [&](std::uint32_t a, std::uint32_t b) {
      return all.numbers[a] == all.numbers[b];
    };
    order.erase(std::unique(order.begin(), order.end(), is_same), order.end());
    for (const std::uint32_t i : order) (*known)[all.numbers[i]] = true;
    writer->put_points({chosen(all.numbers, order), chosen_rows(all.rows, point_row_, order)});
    store_->forget(range);
    context.report(kWayBackPhase, 0, 1, range + 1, point_ranges_);
  }
}

template <class Real>
void ProgressiveBase<Real>::put_tets(const RunContext& context, ProgressiveWriter* writer) {
  for (std::uint32_t range = 0; range < tet_ranges_; ++range) {
    context.check();
    TetRows all;
    store_->for_each(point_ranges_ + range, [&](std::span<const std::byte> piece) {
      ByteReader in(piece);
      append(&in, &all.numbers);
      append(&in, &all.corners);
      append(&in, &all.rows);
    });
    const Vector<std::uint32_t> order = ascending(all.numbers);
    writer->put_tets({chosen(all.numbers, order), chosen(all.corners, order),
                      chosen_rows(all.rows, tet_row_, order)});
    store_->forget(point_ranges_ + range);
    context.report(kWayBackPhase, 0, 1, range + 1, tet_ranges_);
  }
}

template class ProgressiveBase<float>;
template class ProgressiveBase<double>;

}  // namespace tetfusion
