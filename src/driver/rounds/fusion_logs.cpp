#include "driver/rounds/fusion_logs.h"

#include <fmt/format.h>

#include <algorithm>
#include <queue>
#include <utility>

namespace tetfusion {

namespace {

constexpr std::uint64_t kMaxSlices = 4096;

double share_of(std::uint64_t undone, std::uint64_t tets) {
  return tets == 0 ? 0 : static_cast<double>(undone) / static_cast<double>(tets);
}

// Of one chunk, in the order in which fusions are undone.
struct LogSlice {
  std::uint64_t undone = 0;  // tetrahedra of the log, before it
  std::uint64_t tets = 0;    // of the whole log
  std::uint32_t chunk = 0;
  FusionLog log;
};

// Whose turn it is: the log of which the smallest share has been undone.
struct Turn {
  double share;
  std::size_t slice;
  std::size_t next;                          // record
  bool operator<(const Turn& other) const {  // for a queue that has the largest in front
    return share != other.share ? share > other.share : slice > other.slice;
  }
};

}  // namespace

FusionLogs::FusionLogs(Scratch* scratch, std::uint64_t bytes_per_tet)
    : scratch_(scratch), bytes_per_tet_(bytes_per_tet) {}

std::string FusionLogs::name_of(std::size_t round) { return fmt::format("log-{}", round); }

void FusionLogs::begin(std::uint64_t tets) {
  current_ = {};  // its name is free again
  current_.store = scratch_->begin(name_of(rounds_.size() + 1));
  current_.slices = static_cast<std::uint32_t>(
      std::clamp<std::uint64_t>(tets * bytes_per_tet_ / kSliceBytes, 1, kMaxSlices));
}

void FusionLogs::add(std::uint32_t chunk, const FusionLog& log) {
  std::vector<Vector<std::byte>> bytes;
  std::vector<std::uint32_t> numbers;
  std::uint64_t undone = 0;
  for (std::size_t left = log.size(); left > 0;) {
    const auto slice_at = [&] {
      const double slice = share_of(undone, log.tets()) * current_.slices;
      return std::min(static_cast<std::uint32_t>(slice), current_.slices - 1);
    };
    const std::uint32_t number = slice_at();
    LogSlice slice{undone, log.tets(), chunk, {}};
    while (left > 0 && slice_at() == number) {
      const FusionRecord record = log[--left];
      slice.log.append(record);
      undone += record.tets.size();
    }
    ByteWriter out;
    out.put(slice.undone);
    out.put(slice.tets);
    out.put(slice.chunk);
    slice.log.save(&out);
    bytes.push_back(out.take());
    numbers.push_back(number);
  }
  std::vector<PieceRef> pieces;
  for (std::size_t i = 0; i < bytes.size(); ++i) pieces.push_back({numbers[i], bytes[i]});
  if (!pieces.empty()) current_.store->add(chunk, pieces);
}

void FusionLogs::end() {
  current_.store->seal();
  rounds_.push_back(std::exchange(current_, {}));
}

std::vector<std::uint32_t> FusionLogs::keep() {
  while (kept_ < rounds_.size()) scratch_->keep(name_of(++kept_));
  std::vector<std::uint32_t> slices;
  for (const Round& round : rounds_) slices.push_back(round.slices);
  return slices;
}

void FusionLogs::resume(std::span<const std::uint32_t> slices, Checkpoint* from) {
  for (const std::uint32_t count : slices) {
    rounds_.push_back({from->take_kept(name_of(rounds_.size() + 1), "fusions"), count});
  }
  kept_ = rounds_.size();
}

void FusionLogs::take_backwards(const Take& take) {
  for (; !rounds_.empty(); rounds_.pop_back()) {
    Round& round = rounds_.back();
    for (std::uint32_t s = 0; s < round.slices; ++s) {
      if (s + 1 < round.slices) round.store->will_read(s + 1);
      take_slice(s, take);
      round.store->forget(s);
    }
  }
}

// Pieces are ascending by chunk.
void FusionLogs::take_slice(std::uint32_t slice, const Take& take) const {
  std::vector<LogSlice> slices;
  rounds_.back().store->for_each(slice, [&](std::span<const std::byte> piece) {
    ByteReader in(piece);
    LogSlice& one = slices.emplace_back();
    in.get(&one.undone);
    in.get(&one.tets);
    in.get(&one.chunk);
    one.log.load(&in);
  });
  std::priority_queue<Turn> turns;
  for (std::size_t i = 0; i < slices.size(); ++i) {
    turns.push({share_of(slices[i].undone, slices[i].tets), i, 0});
  }
  while (!turns.empty()) {
    Turn turn = turns.top();
    turns.pop();
    LogSlice& from = slices[turn.slice];
    const FusionRecord record = from.log[turn.next];
    from.undone += record.tets.size();
    take(record, static_cast<std::uint32_t>(rounds_.size()), from.chunk);
    if (++turn.next == from.log.size()) continue;
    turn.share = share_of(from.undone, from.tets);
    turns.push(turn);
  }
}

}  // namespace tetfusion
