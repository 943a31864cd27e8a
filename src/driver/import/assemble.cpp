#include "driver/import/assemble.h"

#include <algorithm>
#include <atomic>

#include "base/mix.h"
#include "base/resources.h"
#include "base/tasks.h"
#include "driver/import/chunk_loader.h"
#include "driver/rounds/rounds.h"
#include "mesh/fusion_log.h"
#include "mesh/inspection/chunk_inspection.h"
#include "mesh/inspection/inspect.h"
#include "mesh/inspection/interface_inspection.h"
#include "mesh/regions/region_numbers.h"
#include "partition/chunk_pieces.h"
#include "partition/id_ranges.h"

namespace tetfusion {

namespace {

// The region of the tetrahedra round a vertex on the interface, as one chunk sees it; mixed: there
// are several.
struct RegionReport {
  VertexId id;
  bool mixed;
  std::uint64_t region;
};

// Counts what holds a vertex that would be free otherwise.
void count_locks(std::uint8_t marks, bool between_regions, InputFacts* facts) {
  if ((marks & kOnBoundary) != 0) return;
  if (between_regions) ++facts->between_regions;
  if ((marks & kLocked) == 0) return;
  ++facts->locked_vertices;
  if ((marks & kCarried) != 0) ++facts->carried_vertices;
}

// What a chunk contributes to the whole.
struct ChunkShare {
  ChunkFindings findings;
  Vector<InterfaceReport> interface;
  Vector<RegionReport> regions;
  Vector<TetId> rewound;  // their numbers
  std::uint64_t tets = 0;
  std::uint64_t free_vertices = 0;
  InputFacts locks;  // see count_locks()
};

template <class Real>
class Assembler {
 public:
  explicit Assembler(const ChunkParts<Real>& parts)
      : parts_(parts),
        loader_(parts.layout, without_outliers<Real>(parts.from.box, parts.from.samples)),
        mesh_(parts.layout) {}

  ChunkShare assemble(std::uint32_t chunk);
  WorkMesh<Real>& mesh() { return mesh_; }
  ChunkScatter<Real>& scatter() { return scatter_; }

 private:
  void inspect(ChunkShare* share);
  void mark_regions(ChunkShare* share);

  const ChunkParts<Real>& parts_;
  ChunkLoader<Real> loader_;
  Vector<VertexId> thirds_;
  Vector<std::uint8_t> mixed_;  // of each vertex: its tetrahedra are of several regions
  WorkMesh<Real> mesh_;
  ChunkScatter<Real> scatter_;
};

template <class Real>
ChunkShare Assembler<Real>::assemble(std::uint32_t chunk) {
  loader_.load(chunk, *parts_.from.tets, *parts_.from.points, &mesh_);
  parts_.from.points->forget(chunk);
  parts_.from.tets->forget(chunk);
  ChunkShare share;
  share.tets = mesh_.tets.size();
  inspect(&share);
  mark_regions(&share);
  for (std::size_t v = 0; v < mesh_.vertex_count(); ++v) {
    const std::uint8_t marks = mesh_.marks[v];
    mesh_.marks[v] &= static_cast<std::uint8_t>(~kCarried);
    if ((marks & kOnInterface) != 0) {
      share.interface.push_back({mesh_.point_ids[v], chunk, chunk, marks, false});
      continue;
    }
    ++share.free_vertices;
    count_locks(marks, mixed_[v] != 0, &share.locks);
  }
  for (InterfaceReport& report : share.interface) {
    report.marks &= kLocked | kOnBoundary | kCarried;
  }
  sort_by_id(&share.interface);
  sort_by_id(&share.regions);
  return share;
}

template <class Real>
void Assembler<Real>::inspect(ChunkShare* share) {
  thirds_.clear();
  for (std::size_t t = 0; parts_.numbered > 0 && t < mesh_.tets.size(); ++t) {
    thirds_.push_back(mesh_.tets[t][2]);
  }
  share->findings = inspect_as_marked(&mesh_, false);
  for (std::size_t t = 0; t < thirds_.size(); ++t) {
    if (mesh_.tets[t][2] != thirds_[t]) share->rewound.push_back(original_numbers(mesh_)[t]);
  }
  for (std::size_t v = 0; v < mesh_.vertex_count(); ++v) {
    const std::uint8_t flags = share->findings.vertex_flags[v];
    if ((flags & kBoundaryVertex) != 0) mesh_.marks[v] |= kOnBoundary;
    if ((flags & kBrokenVertex) != 0) mesh_.marks[v] |= kLocked;
  }
}

// They are made when the first round begins.
template <class Real>
void give_empty_quadrics(std::uint32_t width, WorkMesh<Real>* mesh) {
  mesh->quadric_width = width;
  mesh->quadrics.assign(mesh->vertex_count() * width, 0.0F);
  mesh->deviations.assign(mesh->has_deviations ? mesh->vertex_count() : 0, 0.0F);
}

// The mark of a vertex between regions.
template <class Real>
std::uint8_t lock_of_regions(const ChunkParts<Real>& parts) {
  return parts.surfaces_move ? std::uint8_t{0} : std::uint8_t{kLocked};
}

// A tetrahedron's region is what all the region arrays together say.
template <class Real>
void Assembler<Real>::mark_regions(ChunkShare* share) {
  mixed_.assign(mesh_.vertex_count(), 0);
  if (parts_.regions.empty()) return;
  Vector<std::uint64_t> region_of_vertex;
  region_of_vertex.assign(mesh_.vertex_count(), 0);
  Vector<std::uint8_t> seen;
  seen.assign(mesh_.vertex_count(), 0);
  Vector<std::uint64_t> region_of_tet;
  region_of_tet.assign(mesh_.tets.size(), 0);
  for (const std::size_t c : parts_.regions) {
    const Column& column = mesh_.cell_columns[c];
    const Vector<std::uint64_t> keys = region_keys(column.type, column.rows);
    for (std::size_t t = 0; t < keys.size(); ++t)
      region_of_tet[t] = mix(region_of_tet[t] ^ keys[t]);
  }
  for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
    const std::uint64_t region = region_of_tet[t];
    for (const VertexId v : mesh_.tets[t]) {
      if (seen[v] != 0 && region_of_vertex[v] != region) {
        mesh_.marks[v] |= lock_of_regions(parts_);
        mixed_[v] = 1;
      }
      seen[v] = 1;
      region_of_vertex[v] = region;
    }
  }
  for (std::size_t v = 0; v < mesh_.vertex_count(); ++v) {
    if ((mesh_.marks[v] & kOnInterface) == 0) continue;
    share->regions.push_back({mesh_.point_ids[v], mixed_[v] != 0, region_of_vertex[v]});
  }
}

template <class Real>
void apply_verdict(InterfaceVerdict verdict, Assembly<Real>* out) {
  const std::span<InterfaceReport> entries = out->mesh.interface.entries();
  auto entry = entries.begin();
  for (std::size_t i = 0; i < verdict.ids.size(); ++i) {
    while (entry != entries.end() && entry->id < verdict.ids[i]) ++entry;
    if (entry == entries.end()) break;
    if (entry->id != verdict.ids[i]) continue;
    if ((verdict.flags[i] & kBoundaryVertex) != 0) entry->marks |= kOnBoundary;
    if ((verdict.flags[i] & kBrokenVertex) != 0) entry->marks |= kLocked;
  }
  InputFacts& facts = out->facts;
  facts.locked_vertices += verdict.overrides.size();
  out->mesh.locks = std::move(verdict.overrides);
  facts.boundary_faces = verdict.boundary_faces;
  facts.volume = verdict.volume;
  facts.rewound = verdict.rewound;
  facts.degenerate = verdict.degenerate;
  facts.inverted = verdict.inverted;
  facts.duplicate_tets = verdict.duplicate_tets;
  facts.nonconforming_faces = verdict.foldover_faces + verdict.overfull_faces;
  facts.nonmanifold_edges = verdict.nonmanifold_edges;
}

// Marks the vertices whose tetrahedra are of one region in one chunk and of another in the next.
// Counts all locks on the interface.
void mark_between_regions(std::vector<Vector<RegionReport>> reports, std::uint8_t mark,
                          std::span<InterfaceReport> interface, InputFacts* facts) {
  auto entry = interface.begin();
  const auto count_up_to = [&](auto end) {
    for (; entry != end; ++entry) count_locks(entry->marks, false, facts);
  };
  for_each_id_range(std::move(reports), [&](const Vector<RegionReport>& of_range) {
    for (std::size_t begin = 0, end = 0; begin < of_range.size(); begin = end) {
      const RegionReport& first = of_range[begin];
      bool is_between = false;
      for (end = begin; end < of_range.size() && of_range[end].id == first.id; ++end) {
        is_between = is_between || of_range[end].mixed || of_range[end].region != first.region;
      }
      if (!is_between) continue;
      count_up_to(std::find_if(entry, interface.end(),
                               [&](const InterfaceReport& of) { return of.id == first.id; }));
      entry->marks |= mark;
      count_locks(entry->marks, true, facts);
      ++entry;
    }
  });
  count_up_to(interface.end());
}

// Joins the shares of all chunks, which come in the order of the chunks.
template <class Real>
class ShareJoiner {
 public:
  // `out` outlives this.
  ShareJoiner(const ChunkParts<Real>& parts, Assembly<Real>* out)
      : numbered_(parts.numbered), lock_(lock_of_regions(parts)), out_(out) {}

  void add(ChunkShare share);
  // After the last one: judges what lies between the chunks.
  void finish();

 private:
  const std::uint64_t numbered_;
  const std::uint8_t lock_;
  Assembly<Real>* out_;
  InterfaceInspection between_;
  std::vector<Vector<InterfaceReport>> interface_;
  std::vector<Vector<RegionReport>> regions_;
};

template <class Real>
void ShareJoiner<Real>::add(ChunkShare share) {
  between_.add(&share.findings);
  interface_.push_back(std::move(share.interface));
  regions_.push_back(std::move(share.regions));
  if (!share.rewound.empty()) out_->rewound.resize(numbered_);
  for (const TetId t : share.rewound) out_->rewound[t] = true;
  out_->mesh.tets += share.tets;
  InputFacts& facts = out_->facts;
  facts.points += share.free_vertices;
  facts.locked_vertices += share.locks.locked_vertices;
  facts.between_regions += share.locks.between_regions;
  facts.carried_vertices += share.locks.carried_vertices;
}

template <class Real>
void ShareJoiner<Real>::finish() {
  InterfaceTable& table = out_->mesh.interface;
  table = InterfaceTable(std::move(interface_));
  apply_verdict(between_.finish(), out_);
  mark_between_regions(std::move(regions_), lock_, table.entries(), &out_->facts);
  out_->facts.tets = out_->mesh.tets;
  out_->facts.points += table.entries().size();
  for (InterfaceReport& entry : table.entries()) {
    entry.marks &= static_cast<std::uint8_t>(~kCarried);
  }
}

}  // namespace

template <class Real>
Assembly<Real> assemble_chunks(const ChunkParts<Real>& parts, const ChunkWork<Real>& work,
                               const ImportPlace& place) {
  const std::uint32_t chunks = parts.from.chunks;
  Assembly<Real> out;
  out.mesh.chunks = chunks;
  const bool whole = chunks == 1;
  if (!whole && !work) {
    out.mesh.pieces = place.scratch->begin("import");
    out.mesh.sizes.resize(chunks);
  }
  std::vector<std::unique_ptr<Assembler<Real>>> workers;
  for (int i = 0; i < thread_count(); ++i) {
    workers.push_back(std::make_unique<Assembler<Real>>(parts));
  }
  ShareJoiner<Real> shares(parts, &out);
  InOrder<ChunkShare> join([&](ChunkShare share) { shares.add(std::move(share)); });
  std::atomic<std::size_t> done{0};
  run_tasks(chunks, thread_count(), [&](std::size_t c, std::size_t w) {
    place.context.check();
    const auto chunk = static_cast<std::uint32_t>(c);
    const auto memory =
        place.budget->wait_for(chunk_memory(parts.bytes(chunk)), "a chunk to be put together");
    place.context.check();  // that may have taken long
    Assembler<Real>& worker = *workers[w];
    ChunkShare share = worker.assemble(chunk);
    const ChunkSize size{share.free_vertices, share.tets};
    join.put(c, std::move(share));
    if (whole) {
      out.mesh.whole = std::move(worker.mesh());
    } else if (work) {
      work(chunk, w, &worker.mesh());
    } else {
      give_empty_quadrics(parts.layout.quadric_width, &worker.mesh());
      worker.scatter().keep(worker.mesh(), chunk, out.mesh.pieces.get());
      out.mesh.sizes[chunk] = size;
    }
    place.context.report("assembling", 0.12, work ? kAssembledWithWork : kAssembledShare, ++done,
                         chunks);
  });
  workers.clear();
  trim_memory();
  if (out.mesh.pieces) out.mesh.pieces->seal();
  shares.finish();
  return out;
}

template <class Real>
WorkMesh<Real> assemble_excerpt(const ChunkParts<Real>& parts) {
  Assembler<Real> assembler(parts);
  assembler.assemble(parts.from.all_chunks);
  return std::move(assembler.mesh());
}

template Assembly<float> assemble_chunks(const ChunkParts<float>&, const ChunkWork<float>&,
                                         const ImportPlace&);
template Assembly<double> assemble_chunks(const ChunkParts<double>&, const ChunkWork<double>&,
                                          const ImportPlace&);
template WorkMesh<float> assemble_excerpt(const ChunkParts<float>&);
template WorkMesh<double> assemble_excerpt(const ChunkParts<double>&);

}  // namespace tetfusion
