#include "refine/fusion_spool.h"

#include "base/serialize.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kMostInMemory = std::uint64_t{16} << 20;
constexpr std::uint64_t kRecordBytes = 64;

}  // namespace

void FusionSpool::add(const FusionRecord& record, std::uint32_t chunk) {
  logs_[chunk].append(record);
  in_memory_ += kRecordBytes + record.rows.size() + record.star.size() + record.tet_rows.size() +
                record.points.size_bytes() + record.tets.size_bytes() +
                record.corners.size_bytes() + record.elsewhere.size_bytes();
  if (in_memory_ >= kMostInMemory) put_away();
}

void FusionSpool::put_away() {
  for (const auto& [chunk, log] : logs_) {
    ByteWriter out;
    log.save(&out);
    const Vector<std::byte> bytes = out.take();
    file_.write(end_, bytes);
    extents_[chunk].push_back({end_, bytes.size()});
    end_ += bytes.size();
  }
  logs_.clear();
  in_memory_ = 0;
}

void FusionSpool::take(const std::function<void(const FusionLog& log)>& undo) {
  put_away();
  Vector<std::byte> bytes;
  for (const auto& [chunk, extents] : extents_) {
    for (const Extent& extent : extents) {
      bytes.resize(extent.bytes);
      file_.read(extent.offset, bytes);
      ByteReader in(bytes);
      FusionLog log;
      log.load(&in);
      undo(log);
    }
  }
  extents_.clear();
  end_ = 0;
}

}  // namespace tetfusion
