#include "support/cut_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "support/interface_tables.h"
#include "support/work_meshes.h"

namespace tetfusion::testing {

namespace {

template <class T>
void append(const T* values, std::size_t count, std::string* text) {
  text->append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

void append_rows(const std::vector<Column>& columns, std::size_t row, std::string* text) {
  for (const Column& c : columns) append(c.rows.data() + row * c.stride(), c.stride(), text);
}

constexpr std::uint8_t kLasting = kOnBoundary | kLocked | kMoved;

template <class Real>
std::string vertex_text(const WorkMesh<Real>& mesh, VertexId v, bool with_id = true) {
  std::string text;
  const auto lasting = static_cast<char>(mesh.marks[v] & kLasting);
  if (with_id) append(&mesh.point_ids[v], 1, &text);
  append(&mesh.positions[v], 1, &text);
  append(&lasting, 1, &text);
  append(mesh.steering.data() + v * mesh.steering_width, mesh.steering_width, &text);
  append_rows(mesh.point_columns, v, &text);
  return text;
}

void copy_rows(const std::vector<Column>& from, std::size_t row, std::size_t to,
               std::vector<Column>* columns) {
  for (std::size_t c = 0; c < from.size(); ++c) {
    const std::size_t stride = from[c].stride();
    std::memcpy((*columns)[c].rows.data() + to * stride, from[c].rows.data() + row * stride,
                stride);
  }
}

template <class Real>
void copy_vertex(const WorkMesh<Real>& from, VertexId v, VertexId to, WorkMesh<Real>* mesh) {
  mesh->positions[to] = from.positions[v];
  mesh->marks[to] = from.marks[v] & kLasting;
  mesh->point_ids[to] = from.point_ids[v];
  mesh->changed[to] = 0;
  std::copy_n(from.steering.data() + v * from.steering_width, from.steering_width,
              mesh->steering.data() + to * from.steering_width);
  copy_rows(from.point_columns, v, to, &mesh->point_columns);
}

// The removed points of a tetrahedron.
template <class Real>
void copy_removed(const WorkMesh<Real>& from, std::size_t t, std::size_t to, WorkMesh<Real>* mesh) {
  if (!from.removed.wanted()) return;
  RemovedPoints<Real>& removed = mesh->removed;
  if (!removed.wanted()) removed.reset(mesh->tets.size());
  const std::size_t width = from.steering_width;
  for (std::uint32_t i = from.removed.first[t]; i != kNoPoint; i = from.removed.next[i]) {
    const std::uint32_t point = removed.add(1, width);
    removed.positions[point] = from.removed.positions[i];
    std::copy_n(from.removed.values.data() + i * width, width,
                removed.values.data() + point * width);
    removed.push(static_cast<std::uint32_t>(to), point);
  }
}

template <class Real>
void append_removed(const WorkMesh<Real>& mesh, std::size_t t, std::string* text) {
  if (!mesh.removed.wanted()) return;
  const RemovedPoints<Real>& removed = mesh.removed;
  std::vector<std::string> points;  // in any order
  for (std::uint32_t i = removed.first[t]; i != kNoPoint; i = removed.next[i]) {
    std::string& point = points.emplace_back();
    append(&removed.positions[i], 1, &point);
    append(removed.values.data() + i * mesh.steering_width, mesh.steering_width, &point);
  }
  std::sort(points.begin(), points.end());
  for (const std::string& point : points) *text += point;
}

// What the chunk has of its vertices' quadrics; place(id) is where a vertex goes.
template <class Real, class Place>
void add_quadrics(const WorkMesh<Real>& chunk, Place place, WorkMesh<Real>* mesh) {
  const std::size_t numbers = mesh->quadric_width;
  for (std::size_t v = 0; v < chunk.vertex_count() && numbers > 0; ++v) {
    float* sum = mesh->quadrics.data() + place(chunk.point_ids[v]) * numbers;
    for (std::size_t k = 0; k < numbers; ++k) sum[k] += chunk.quadrics[v * numbers + k];
  }
}

}  // namespace

template <class Real>
WorkMesh<Real> layout_of(const WorkMesh<Real>& mesh) {
  WorkMesh<Real> layout;
  layout.steering_width = mesh.steering_width;
  layout.quadric_width = mesh.quadric_width;
  for (const Column& c : mesh.point_columns)
    layout.point_columns.push_back({c.type, c.components, {}});
  for (const Column& c : mesh.cell_columns)
    layout.cell_columns.push_back({c.type, c.components, {}});
  return layout;
}

template <class Real>
Box box_of(const WorkMesh<Real>& mesh) {
  Box box;
  for (const Vec3<Real>& p : mesh.positions) box.add({p.x, p.y, p.z});
  return box;
}

template <class Real>
CurveCut cut_evenly(const WorkMesh<Real>& mesh, std::uint32_t chunks, std::uint32_t round) {
  const ShiftedCurve curve(box_of(mesh), round);
  Vector<std::uint64_t> keys;
  for (const Tet& t : mesh.tets) keys.push_back(curve.key(mesh.positions[t[0]]));
  return CurveCut(curve, chunks, std::move(keys));
}

template <class Real>
CutMesh cut_anew(const std::vector<WorkMesh<Real>>& chunks, const CurveCut& cut, Scratch* scratch,
                 const std::string& name) {
  CutMesh out{cut.chunks(), scratch->begin(name), {}};
  Vector<InterfaceReport> reports;
  ChunkScatter<Real> scatter;
  for (std::uint32_t c = 0; c < chunks.size(); ++c) {
    scatter.scatter(chunks[c], cut, c, out.pieces.get(), &reports);
  }
  out.pieces->seal();
  out.interface = table_of(std::move(reports));
  return out;
}

template <class Real>
CutMesh cut_up(const WorkMesh<Real>& mesh, std::uint32_t chunks, std::uint32_t round,
               Scratch* scratch, const std::string& name) {
  return cut_anew<Real>({mesh}, cut_evenly(mesh, chunks, round), scratch, name);
}

template <class Real>
std::vector<WorkMesh<Real>> gather_all(const CutMesh& mesh, const WorkMesh<Real>& layout) {
  ChunkGather<Real> gather;
  std::vector<WorkMesh<Real>> chunks(mesh.chunks, layout);
  for (std::uint32_t c = 0; c < mesh.chunks; ++c) {
    gather.gather(c, *mesh.pieces, mesh.interface, &chunks[c]);
  }
  return chunks;
}

template <class Real>
std::map<VertexId, std::set<std::size_t>> chunks_by_id(const std::vector<WorkMesh<Real>>& chunks) {
  std::map<VertexId, std::set<std::size_t>> out;
  for (std::size_t c = 0; c < chunks.size(); ++c) {
    for (const Tet& t : chunks[c].tets) {
      for (const VertexId v : t) out[chunks[c].point_ids[v]].insert(c);
    }
  }
  return out;
}

template <class Real>
void expect_chunks_know_their_vertices(const std::vector<WorkMesh<Real>>& chunks) {
  const auto homes = chunks_by_id(chunks);
  std::size_t seen = 0;
  for (std::size_t c = 0; c < chunks.size(); ++c) {
    const WorkMesh<Real>& chunk = chunks[c];
    std::set<VertexId> ids;
    WorkMesh<Real> counted = chunk;
    count_incidence(&counted);
    EXPECT_EQ(chunk.incidence, counted.incidence);
    for (std::size_t v = 0; v < chunk.vertex_count(); ++v) {
      const VertexId id = chunk.point_ids[v];
      EXPECT_TRUE(ids.insert(id).second) << "vertex " << id << " is twice in a chunk";
      const std::set<std::size_t>& home = homes.at(id);
      int expected = chunk.marks[v] & (kOnBoundary | kLocked);
      if (home.size() > 1) expected |= kOnInterface;
      if (home.size() > 1 && *home.rbegin() == c) expected |= kLast;
      const int told = chunk.marks[v] & ~(home.size() > 1 ? kMoved : kMoved | kLast);
      EXPECT_EQ(told, expected) << "vertex " << id << " in chunk " << c;
      if (*home.begin() == c) ++seen;
    }
  }
  EXPECT_EQ(seen, homes.size());
}

template <class Real>
WorkMesh<Real> join(const std::vector<WorkMesh<Real>>& chunks) {
  struct Copy {
    std::size_t chunk;
    VertexId vertex;
    VertexId place;
  };
  std::map<VertexId, Copy> copies;  // by id
  std::size_t tets = 0;
  for (std::size_t c = 0; c < chunks.size(); ++c) {
    tets += chunks[c].tets.size();
    for (VertexId v = 0; v < chunks[c].vertex_count(); ++v) {
      const auto [at, is_new] = copies.try_emplace(chunks[c].point_ids[v], Copy{c, v, 0});
      const Copy& first = at->second;
      if (!is_new && vertex_text(chunks[c], v) != vertex_text(chunks[first.chunk], first.vertex)) {
        throw std::logic_error("two chunks do not agree about a vertex");
      }
    }
  }
  WorkMesh<Real> mesh = layout_of(chunks.front());
  mesh.resize_vertices(copies.size());
  mesh.resize_tets(tets);
  VertexId place = 0;
  for (auto& [id, copy] : copies) {
    copy.place = place++;
    copy_vertex(chunks[copy.chunk], copy.vertex, copy.place, &mesh);
  }
  mesh.quadrics.assign(copies.size() * mesh.quadric_width, 0.0F);
  std::size_t to = 0;
  for (const WorkMesh<Real>& chunk : chunks) {
    add_quadrics(
        chunk, [&](VertexId id) { return copies.at(id).place; }, &mesh);
    for (std::size_t t = 0; t < chunk.tets.size(); ++t, ++to) {
      for (std::size_t k = 0; k < 4; ++k) {
        mesh.tets[to][k] = copies.at(chunk.point_ids[chunk.tets[t][k]]).place;
      }
      copy_rows(chunk.cell_columns, t, to, &mesh.cell_columns);
      copy_removed(chunk, t, to, &mesh);
    }
  }
  mesh.remembered.assign(tets, 0);
  count_incidence(&mesh);
  return mesh;
}

template <class Real>
std::vector<std::string> contents(const WorkMesh<Real>& mesh, bool with_ids) {
  std::vector<std::string> tets;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    std::string& text = tets.emplace_back();
    for (const VertexId v : mesh.tets[t]) text += vertex_text(mesh, v, with_ids);
    append_rows(mesh.cell_columns, t, &text);
    append_removed(mesh, t, &text);
  }
  std::sort(tets.begin(), tets.end());
  return tets;
}

#define TETFUSION_INSTANTIATE(Real)                                                        \
  template WorkMesh<Real> layout_of(const WorkMesh<Real>&);                                \
  template Box box_of(const WorkMesh<Real>&);                                              \
  template CurveCut cut_evenly(const WorkMesh<Real>&, std::uint32_t, std::uint32_t);       \
  template CutMesh cut_up(const WorkMesh<Real>&, std::uint32_t, std::uint32_t, Scratch*,   \
                          const std::string&);                                             \
  template CutMesh cut_anew(const std::vector<WorkMesh<Real>>&, const CurveCut&, Scratch*, \
                            const std::string&);                                           \
  template std::vector<WorkMesh<Real>> gather_all(const CutMesh&, const WorkMesh<Real>&);  \
  template std::map<VertexId, std::set<std::size_t>> chunks_by_id(                         \
      const std::vector<WorkMesh<Real>>&);                                                 \
  template void expect_chunks_know_their_vertices(const std::vector<WorkMesh<Real>>&);     \
  template WorkMesh<Real> join(const std::vector<WorkMesh<Real>>&);                        \
  template std::vector<std::string> contents(const WorkMesh<Real>&, bool);
TETFUSION_INSTANTIATE(float)
TETFUSION_INSTANTIATE(double)
#undef TETFUSION_INSTANTIATE

}  // namespace tetfusion::testing
