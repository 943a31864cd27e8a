#include "partition/chunks.h"

#include <algorithm>
#include <atomic>

#include "mesh/blocks.h"
#include "partition/curve_cut.h"

namespace tetfusion {

namespace {

constexpr std::size_t kBlockTets = std::size_t{1} << 16;

// Chunks that work at the same time may both have changed the ball of a vertex between them. They
// then write the same number, and none of them decides by it: the vertex is locked.
std::uint16_t load_changed(std::uint16_t& changed) {
  return std::atomic_ref(changed).load(std::memory_order_relaxed);
}
void raise_changed(std::uint16_t pass, std::uint16_t& changed) {
  if (pass > load_changed(changed)) std::atomic_ref(changed).store(pass, std::memory_order_relaxed);
}

}  // namespace

template <class Real>
Chunking cut_into_chunks(const WorkMesh<Real>& mesh, std::uint64_t chunk_tets,
                         std::uint32_t round) {
  const CurveCut cut = cut_curve(mesh.positions, mesh.tets, chunk_tets, round);
  const std::size_t tets = mesh.tets.size();
  const std::size_t blocks = (tets + kBlockTets - 1) / kBlockTets;

  // A counting sort in parallel: each block of tetrahedra counts its own, then knows where they go.
  Vector<std::uint64_t>
      place;  // of a block in a chunk: chunk-major, so that prefix sums run over blocks first
  place.assign(cut.chunks * blocks + 1, 0);
  for_each_block(tets, kBlockTets, [&](std::size_t block, std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t)
      ++place[cut.chunk_of(mesh.tets[t]) * blocks + block + 1];
  });
  for (std::size_t i = 1; i < place.size(); ++i) place[i] += place[i - 1];
  Chunking chunking;
  for (std::size_t c = 0; c <= cut.chunks; ++c) chunking.begins.push_back(place[c * blocks]);
  chunking.tets.resize(tets);
  for_each_block(tets, kBlockTets, [&](std::size_t block, std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      std::uint64_t& next = place[cut.chunk_of(mesh.tets[t]) * blocks + block];
      chunking.tets[next++] = static_cast<TetId>(t);
    }
  });
  return chunking;
}

template <class Real>
WorkMesh<Real> ChunkCutter<Real>::take(WorkMesh<Real>& mesh, const Chunking& chunking,
                                       std::size_t chunk) {
  const std::uint64_t begin = chunking.begins[chunk];
  const std::size_t tets = chunking.begins[chunk + 1] - begin;
  WorkMesh<Real> out;
  out.tets.resize(tets);
  out.tet_ids.resize(tets);
  out.flipped.resize(tets);
  Vector<VertexId>& vertices = out.point_ids;
  if (local_.size() < mesh.vertex_count()) local_.resize(mesh.vertex_count(), kNoVertex);
  for (std::size_t i = 0; i < tets; ++i) {
    const TetId t = chunking.tets[begin + i];
    out.tets[i] = mesh.tets[t];
    out.tet_ids[i] = mesh.tet_ids[t];
    out.flipped[i] = mesh.flipped[t];
    for (const VertexId v : mesh.tets[t]) {
      if (local_[v] == kNoVertex) {
        local_[v] = 0;
        vertices.push_back(v);
      }
      ++local_[v];  // counts, for now
    }
  }

  const std::size_t n = vertices.size();
  const std::size_t width = mesh.steering_width;
  out.steering_width = mesh.steering_width;
  out.positions.resize(n);
  out.marks.resize(n);
  out.incidence.resize(n);
  out.changed.resize(n);
  out.steering.resize(n * width);
  for (std::size_t i = 0; i < n; ++i) {
    const VertexId v = vertices[i];
    const std::uint32_t count = local_[v];
    const bool is_free = count == mesh.incidence[v];
    if (is_free) mesh.incidence[v] = 0;  // until put_back: what dies in the chunk stays at 0
    local_[v] = static_cast<VertexId>(i);
    out.positions[i] = mesh.positions[v];
    out.marks[i] = static_cast<std::uint8_t>(mesh.marks[v] | (is_free ? 0 : kOnInterface));
    out.incidence[i] = is_free ? count : 0;
    out.changed[i] = load_changed(mesh.changed[v]);
    std::copy_n(mesh.steering.data() + v * width, width, out.steering.data() + i * width);
  }
  for (Tet& t : out.tets) {
    for (VertexId& v : t) v = local_[v];
  }
  for (const VertexId v : vertices) local_[v] = kNoVertex;
  return out;
}

template <class Real>
ChunkRemains put_back(WorkMesh<Real> chunk, WorkMesh<Real>* mesh) {
  ChunkRemains remains;
  const std::size_t width = mesh->steering_width;
  for (std::size_t i = 0; i < chunk.vertex_count(); ++i) {
    const VertexId v = chunk.point_ids[i];
    raise_changed(chunk.changed[i], mesh->changed[v]);
    if ((chunk.marks[i] & kOnInterface) != 0) {
      if (chunk.incidence[i] != 0) remains.changes.push_back({v, chunk.incidence[i]});
      continue;
    }
    mesh->positions[v] = chunk.positions[i];
    mesh->incidence[v] = chunk.incidence[i];
    std::copy_n(chunk.steering.data() + i * width, width, mesh->steering.data() + v * width);
  }
  remains.tets = std::move(chunk.tets);
  remains.tet_ids = std::move(chunk.tet_ids);
  remains.flipped = std::move(chunk.flipped);
  remains.vertices = std::move(chunk.point_ids);
  return remains;
}

template <class Real>
void join_chunks(std::vector<ChunkRemains> remains, WorkMesh<Real>* mesh) {
  Vector<std::uint64_t> begins{0};
  for (const ChunkRemains& r : remains) {
    for (const auto& change : r.changes) mesh->incidence[change.vertex] += change.incidence;
    begins.push_back(begins.back() + r.tets.size());
  }
  mesh->tets.resize(begins.back());
  mesh->tet_ids.resize(begins.back());
  mesh->flipped.resize(begins.back());
  const Vector<VertexId> new_ids = drop_unused_vertices(mesh);
  for_each_block(remains.size(), 1, [&](std::size_t c, std::size_t, std::size_t) {
    const ChunkRemains r = std::move(remains[c]);  // freed here
    Tet* tets = mesh->tets.data() + begins[c];
    for (std::size_t t = 0; t < r.tets.size(); ++t) {
      for (std::size_t i = 0; i < 4; ++i) tets[t][i] = new_ids[r.vertices[r.tets[t][i]]];
    }
    std::copy(r.tet_ids.begin(), r.tet_ids.end(), mesh->tet_ids.data() + begins[c]);
    std::copy(r.flipped.begin(), r.flipped.end(), mesh->flipped.data() + begins[c]);
  });
}

template class ChunkCutter<float>;
template class ChunkCutter<double>;
template Chunking cut_into_chunks(const WorkMesh<float>&, std::uint64_t, std::uint32_t);
template Chunking cut_into_chunks(const WorkMesh<double>&, std::uint64_t, std::uint32_t);
template ChunkRemains put_back(WorkMesh<float>, WorkMesh<float>*);
template ChunkRemains put_back(WorkMesh<double>, WorkMesh<double>*);
template void join_chunks(std::vector<ChunkRemains>, WorkMesh<float>*);
template void join_chunks(std::vector<ChunkRemains>, WorkMesh<double>*);

}  // namespace tetfusion
