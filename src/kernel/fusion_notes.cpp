#include "kernel/fusion_notes.h"

#include <algorithm>
#include <cstring>

namespace tetfusion {

template <class Real>
void FusionNotes<Real>::begin(const WorkMesh<Real>* mesh, FusionLog* log) {
  mesh_ = mesh;
  log_ = log;
  if (log == nullptr) return;
  row_bytes_ = point_row_bytes(*mesh);
  tet_row_bytes_ = tet_row_bytes(*mesh);
  stamp_.assign(mesh->vertex_count(), 0);
  code_.resize(mesh->vertex_count());
  stamped_ = 0;
  star_.clear();
}

template <class Real>
void FusionNotes<Real>::before(VertexId kept, std::span<const VertexId> gone,
                               std::span<const TetId> deleted) {
  const std::span<const TetId> numbers = original_numbers(*mesh_);
  kept_ = kept;
  gone_ = static_cast<std::uint32_t>(gone.size());
  back_.assign(gone.begin(), gone.end());
  deleted_.assign(deleted.begin(), deleted.end());
  std::sort(deleted_.begin(), deleted_.end(),
            [&](TetId a, TetId b) { return numbers[a] < numbers[b]; });
  std::sort(star_.begin(), star_.end(),
            [&](const StarTet& a, const StarTet& b) { return numbers[a.tet] < numbers[b.tet]; });
  // A broken one may name the kept vertex twice.
  const auto is_same = [](const StarTet& a, const StarTet& b) { return a.tet == b.tet; };
  star_.erase(std::unique(star_.begin(), star_.end(), is_same), star_.end());
  ++stamped_;
  find_swallowed();
  codes_ = 0;
  const auto give_code = [&](VertexId v) {
    stamp_[v] = stamped_;
    code_[v] = codes_++;
  };
  give_code(kept);
  for (const VertexId v : back_) give_code(v);
  whose_.clear();
  for (const StarTet& s : star_) {
    whose_.push_back(s.whose);
    for (std::uint8_t c = 0; c < 4; ++c) {
      const VertexId v = mesh_->tets[s.tet][c];
      if (c != s.corner && stamp_[v] != stamped_) give_code(v);
    }
  }

  points_.clear();
  for (const VertexId v : back_) points_.push_back(mesh_->point_ids[v]);
  rows_.resize((back_.size() + 1) * row_bytes_);
  copy_point_row(*mesh_, kept, rows_.data());
  for (std::size_t i = 0; i < back_.size(); ++i) {
    copy_point_row(*mesh_, back_[i], rows_.data() + (i + 1) * row_bytes_);
  }
  tets_.clear();
  corners_.clear();
  elsewhere_.clear();
  tet_rows_.resize(deleted_.size() * tet_row_bytes_);
  for (std::size_t i = 0; i < deleted_.size(); ++i) {
    tets_.push_back(numbers[deleted_[i]]);
    const Tet& tet = mesh_->tets[deleted_[i]];
    corners_.push_back({code_of(tet[0]), code_of(tet[1]), code_of(tet[2]), code_of(tet[3])});
    copy_tet_row(*mesh_, deleted_[i], tet_rows_.data() + i * tet_row_bytes_);
  }
}

// Vertices that have no tetrahedra but those that are deleted. On an interface other chunks have
// more of them.
template <class Real>
void FusionNotes<Real>::find_swallowed() {
  const std::size_t gone = back_.size();
  const auto leave_out = [&](VertexId v) {
    stamp_[v] = stamped_;
    code_[v] = 0;
  };
  leave_out(kept_);
  for (const VertexId v : back_) leave_out(v);
  for (const TetId t : deleted_) {
    for (const VertexId v : mesh_->tets[t]) {
      if (stamp_[v] == stamped_) {
        if (code_[v] != 0) --code_[v];
        continue;
      }
      stamp_[v] = stamped_;
      code_[v] = mesh_->incidence[v] - 1;
      back_.push_back(v);
    }
  }
  const auto stays = [&](VertexId v) {
    return code_[v] != 0 || (mesh_->marks[v] & kOnInterface) != 0;
  };
  back_.erase(std::remove_if(back_.begin() + static_cast<std::ptrdiff_t>(gone), back_.end(), stays),
              back_.end());
  ++stamped_;
}

template <class Real>
CornerCode FusionNotes<Real>::code_of(VertexId v) {
  if (stamp_[v] == stamped_ && code_[v] < kNoCode) return static_cast<CornerCode>(code_[v]);
  elsewhere_.push_back(mesh_->point_ids[v]);
  return kNoCode;
}

template <class Real>
void FusionNotes<Real>::after(float error) {
  kept_row_.resize(row_bytes_);
  copy_point_row(*mesh_, kept_, kept_row_.data());
  const bool changed = std::memcmp(kept_row_.data(), rows_.data(), row_bytes_) != 0;
  for (std::size_t i = 0; i < rows_.size(); i += row_bytes_) {
    for (std::size_t b = 0; b < row_bytes_; ++b) rows_[i + b] ^= kept_row_[b];
  }
  FusionRecord record;
  record.kept = mesh_->point_ids[kept_];
  record.error = error;
  record.gone = gone_;
  record.points = points_;
  record.rows = std::span(rows_).subspan(changed ? 0 : row_bytes_);
  record.star = whose_;
  record.tets = tets_;
  record.corners = corners_;
  record.elsewhere = elsewhere_;
  record.tet_rows = tet_rows_;
  log_->append(record);
  star_.clear();
}

template class FusionNotes<float>;
template class FusionNotes<double>;

}  // namespace tetfusion
