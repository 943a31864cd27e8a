#include "io/source/file_cells.h"

#include <array>
#include <atomic>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/blocks.h"
#include "base/error.h"
#include "io/source/cell_kinds.h"
#include "mesh/predicates.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

void renumber(const Vector<VertexId>& new_ids, Vector<Tet>* tets) {
  if (new_ids.empty()) return;
  for_each_block(tets->size(), kCellsPerBlock,
                 [&](std::size_t, std::size_t begin, std::size_t end) {
                   for (std::size_t t = begin; t < end; ++t) {
                     for (VertexId& v : (*tets)[t]) v = new_ids[v];
                   }
                 });
}

void take_tets(FileCells cells, const Vector<VertexId>& new_ids, Geometry* mesh) {
  mesh->tets = std::move(cells.tets);
  if (cells.ghosts > 0) {
    mesh->tet_source.resize(mesh->tets.size() - cells.ghosts);
    std::size_t kept = 0;
    for (std::size_t c = 0; c < cells.types.size(); ++c) {
      if (cells.types[c] == kLeftOut) continue;
      mesh->tets[kept] = mesh->tets[c];
      mesh->tet_source[kept++] = c;
    }
    mesh->tets.resize(kept);
  }
  renumber(new_ids, &mesh->tets);
}

// What one block of cells turns into.
struct Taken {
  std::vector<Tet> tets;
  std::vector<std::uint64_t> tet_source;
  std::vector<std::uint8_t> lower_types;
  std::vector<std::uint64_t> lower_source;
  std::vector<VertexId> lower_ids;
};

class MixedTaker {
 public:
  MixedTaker(const FileCells& cells, const Vector<VertexId>& new_ids, const Points& points)
      : cells_(cells), new_ids_(new_ids), points_(points) {}

  Taken take(std::size_t begin, std::size_t end) const {
    Taken out;
    for (std::size_t c = begin; c < end; ++c) take_cell(c, &out);
    return out;
  }

 private:
  VertexId id(std::size_t cell, std::size_t corner) const {
    const VertexId v = cells_.connectivity[cells_.offsets[cell] + corner];
    return new_ids_.empty() ? v : new_ids_[v];
  }

  void take_cell(std::size_t cell, Taken* out) const {
    const std::uint8_t type = linear_type(cells_.types[cell]);
    switch (type) {
      case kLeftOut:
        return;
      case kVtkVertex:
      case kVtkLine:
      case kVtkTriangle:
        return take_lower(cell, type, out);
      case kVtkPixel:
      case kVtkQuad:
        return cut_quadrilateral(cell, type, out);
      case kVtkTetra:
        out->tets.push_back({id(cell, 0), id(cell, 1), id(cell, 2), id(cell, 3)});
        out->tet_source.push_back(cell);
        return;
      default:
        return split(cell, type, out);
    }
  }

  void take_lower(std::size_t cell, std::uint8_t type, Taken* out) const {
    out->lower_types.push_back(type);
    out->lower_source.push_back(cell);
    for (std::size_t k = 0; k < corners_of(type); ++k) out->lower_ids.push_back(id(cell, k));
  }

  void cut_quadrilateral(std::size_t cell, std::uint8_t type, Taken* out) const {
    std::array<std::array<VertexId, 3>, 2> triangles{};
    const int count =
        split_quadrilateral(type, {id(cell, 0), id(cell, 1), id(cell, 2), id(cell, 3)}, &triangles);
    for (int k = 0; k < count; ++k) {
      const auto& triangle = triangles[static_cast<std::size_t>(k)];
      out->lower_types.push_back(kVtkTriangle);
      out->lower_source.push_back(cell);
      out->lower_ids.insert(out->lower_ids.end(), triangle.begin(), triangle.end());
    }
  }

  void split(std::size_t cell, std::uint8_t type, Taken* out) const {
    std::array<VertexId, 8> ids{};
    const std::size_t corners = corners_of(type);
    for (std::size_t k = 0; k < corners; ++k) ids[k] = id(cell, k);
    std::array<Tet, 6> tets{};
    const int count = split_cell(type, std::span(ids).first(corners), tets);
    const std::span<Tet> parts(tets.data(), static_cast<std::size_t>(count));
    if (type == kVtkWedge) wind(parts);
    for (const Tet& tet : parts) {
      out->tets.push_back(tet);
      out->tet_source.push_back(cell);
    }
  }

  // VTK sees the first triangle of a wedge from outside, but that of one of higher order from
  // inside, as Exodus and CGNS do of all; its readers and its writer leave it so. Where the mesh
  // has no points here cells stay as they come.
  void wind(std::span<Tet> tets) const {
    const double volume = std::visit(
        [&](const auto& p) {
          double sum = 0;
          for (const Tet& tet : tets) sum += p.empty() ? 0 : determinant(p, tet).value;
          return sum;
        },
        points_);
    if (!(volume < 0)) return;
    for (Tet& tet : tets) std::swap(tet[2], tet[3]);
  }

  const FileCells& cells_;
  const Vector<VertexId>& new_ids_;
  const Points& points_;
};

void append(const Taken& block, Geometry* mesh) {
  mesh->tets.insert(mesh->tets.end(), block.tets.begin(), block.tets.end());
  mesh->tet_source.insert(mesh->tet_source.end(), block.tet_source.begin(), block.tet_source.end());
  LowerCells& lower = mesh->lower;
  lower.types.insert(lower.types.end(), block.lower_types.begin(), block.lower_types.end());
  lower.connectivity.insert(lower.connectivity.end(), block.lower_ids.begin(),
                            block.lower_ids.end());
  mesh->lower_source.insert(mesh->lower_source.end(), block.lower_source.begin(),
                            block.lower_source.end());
}

void clear_if_identity(Vector<std::uint64_t>* source, std::uint64_t size) {
  if (source->size() != size) return;
  for (std::uint64_t i = 0; i < size; ++i) {
    if ((*source)[i] != i) return;
  }
  source->clear();
}

void take_mixed(const std::string& path, const FileCells& cells, const Vector<VertexId>& new_ids,
                Geometry* mesh) {
  const MixedTaker taker(cells, new_ids, mesh->points);
  std::vector<Taken> blocks(block_count(cells.types.size(), kCellsPerBlock));
  for_each_block(cells.types.size(), kCellsPerBlock,
                 [&](std::size_t b, std::size_t begin, std::size_t end) {
                   blocks[b] = taker.take(begin, end);
                 });
  std::uint64_t tets = 0;
  for (const Taken& block : blocks) tets += block.tets.size();
  if (tets > kMaxTets) fail_too_many_tets(path, tets);
  mesh->tets.reserve(tets);
  mesh->tet_source.reserve(tets);
  for (Taken& block : blocks) {
    append(block, mesh);
    block = {};
  }
  LowerCells& lower = mesh->lower;
  if (lower.size() > 0) {
    lower.offsets.resize(lower.size() + 1);
    lower.offsets[0] = 0;
    for (std::size_t c = 0; c < lower.size(); ++c) {
      lower.offsets[c + 1] = lower.offsets[c] + corners_of(lower.types[c]);
    }
  }
  // Empty means the identity: the rows of the arrays are those of the cells of the file, which need
  // not be all taken, but begin with these.
  clear_if_identity(&mesh->tet_source, mesh->tets.size());
  clear_if_identity(&mesh->lower_source, lower.size());
}

}  // namespace

void mark_used(std::uint8_t* used, VertexId point) {
  std::atomic_ref<std::uint8_t> flag(used[point]);
  if (flag.load(std::memory_order_relaxed) == 0) flag.store(1, std::memory_order_relaxed);
}

void fail_too_many_tets(const std::string& path, std::uint64_t tets) {
  throw Error(ErrorCode::kMemory, path + ": " + std::to_string(tets) +
                                      " tetrahedra are more than can be held in memory at once (" +
                                      std::to_string(kMaxTets) + ")");
}

void take_cells(const std::string& path, FileCells cells, const Vector<VertexId>& new_ids,
                Geometry* mesh) {
  mesh->ghost_cells = cells.ghosts;
  if (cells.tets_only) {
    take_tets(std::move(cells), new_ids, mesh);
  } else {
    take_mixed(path, cells, new_ids, mesh);
  }
  if (mesh->tets.empty()) {
    throw Error(ErrorCode::kBadInput, path + ": the mesh has no tetrahedra");
  }
}

}  // namespace tetfusion
