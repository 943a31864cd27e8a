#include "partition/vertex_chunks.h"

#include <algorithm>
#include <atomic>

namespace tetfusion {

namespace {

void sort_unique(Vector<std::uint64_t>* values, std::size_t from) {
  std::sort(values->begin() + static_cast<std::ptrdiff_t>(from), values->end());
  values->erase(std::unique(values->begin() + static_cast<std::ptrdiff_t>(from), values->end()),
                values->end());
}

}  // namespace

VertexChunks::VertexChunks(std::size_t points) { places_.assign(points, kNoneAway); }

void VertexChunks::Notes::add(VertexId v, std::uint32_t chunk) {
  const std::atomic_ref<std::uint32_t> place(table_->places_[v]);
  std::uint32_t now = place.load(std::memory_order_relaxed);
  if ((now & kChunkBits) == chunk) {
    if ((now & kAtHome) == 0) place.fetch_or(kAtHome, std::memory_order_relaxed);
    return;
  }
  while ((now & kNoneAway) == kNoneAway) {
    const std::uint32_t wanted = (now & ~kNoneAway) | chunk << 16;
    if (place.compare_exchange_weak(now, wanted, std::memory_order_relaxed)) return;
  }
  if (now >> 16 == chunk) return;
  const std::uint64_t note = std::uint64_t{v} << 16 | chunk;
  std::uint64_t& recent = recent_[(v ^ chunk * 0x9E37u) % kRecent];
  if (recent == note) return;
  recent = note;
  more_.push_back(note);
}

std::uint32_t VertexChunks::Notes::add(const Tet& tet) {
  const std::uint32_t first = table_->place(tet[0]);
  std::uint32_t lowest = first & kChunkBits, all = first, differ = 0;
  for (std::size_t i = 1; i < 4; ++i) {
    const std::uint32_t place = table_->place(tet[i]);
    lowest = std::min(lowest, place & kChunkBits);
    all &= place;
    differ |= (place ^ first) & kChunkBits;
  }
  if (differ == 0 && (all & kAtHome) != 0) return lowest;  // as nearly always
  for (const VertexId v : tet) add(v, lowest);
  return lowest;
}

void VertexChunks::Notes::hand_over() {
  sort_unique(&more_, 0);
  const std::lock_guard lock(table_->mutex_);
  Vector<std::uint64_t>& all = table_->more_;
  all.insert(all.end(), more_.begin(), more_.end());
  constexpr std::size_t kSlack = std::size_t{1} << 20;
  if (all.size() > 2 * table_->sorted_ + kSlack) {
    sort_unique(&all, 0);
    table_->sorted_ = all.size();
  }
}

void VertexChunks::finish() { sort_unique(&more_, 0); }

void VertexChunks::chunks_of(VertexId v, Vector<std::uint32_t>* chunks) const {
  const std::uint32_t place = places_[v];
  const std::size_t begin = chunks->size();
  if ((place & kAtHome) != 0) chunks->push_back(place & kChunkBits);
  if ((place & kNoneAway) == kNoneAway) return;
  chunks->push_back(place >> 16);
  auto more = std::lower_bound(more_.begin(), more_.end(), std::uint64_t{v} << 16);
  for (; more != more_.end() && *more >> 16 == v; ++more) {
    chunks->push_back(static_cast<std::uint32_t>(*more & 0xFFFF));
  }
  std::sort(chunks->begin() + static_cast<std::ptrdiff_t>(begin), chunks->end());
}

}  // namespace tetfusion
